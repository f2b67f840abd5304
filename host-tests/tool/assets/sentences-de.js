// The steps of the program in German. A text that is not here stays in English.

/** The sentences of the program and their German texts; {0}, {1} are the parts that change. @type {[string, string][]} */
const TEXTS = [
  // Steps.
  ["switch the sensor off and on now: it then tells its address",
    "Schalten Sie den Sensor jetzt aus und ein: Dann nennt er seine Adresse"],
  ["listened at {0} for {1} ms: {2} - {3}", "bei {0} {1} ms gehört: {2} - {3}"],
  ["listened at {0} for {1} ms: {2}", "bei {0} {1} ms gehört: {2}"],
  ["{0} frames, {1} errors", "{0} Frames, {1} Fehler"],
  ["{0} frames", "{0} Frames"],
  ["asking at the addresses as delivered ({0})", "fragt auf den Adressen wie geliefert ({0})"],
  ["asking at all node-IDs and MAC IDs ({0})", "fragt auf allen Node-IDs und MAC IDs ({0})"],
  ["the protocol of the bus is {0}: the tool sends no requests of other protocols",
    "Das Protokoll des Busses ist {0}: Das Programm sendet keine Anfragen anderer Protokolle"],
  ["nothing was sent", "nichts wurde gesendet"],
  ["nothing was sent, but the messages of other devices were acknowledged",
    "nichts wurde gesendet, aber die Nachrichten anderer Geräte wurden bestätigt"],
  ["sent {0} frames at {1}", "{0} Frames bei {1} gesendet"],
  ["the bit rate of the interface", "der Bitrate der Schnittstelle"],
  // The beginnings of messages that the page goes on with.
  ["nobody answers at {0} at {1}", "niemand antwortet auf {0} bei {1}"],
  ["nobody answers at {0}", "niemand antwortet auf {0}"],
  ["any bit rate", "jeder Bitrate"],
  ["no sensor was found", "kein Sensor wurde gefunden"],
  ["traffic at {0} ({1}), no sensor recognised", "Verkehr bei {0} ({1}), kein Sensor erkannt"],
  ["stopped by the user: start the command again to finish it",
    "angehalten: Beginnen Sie die Aktion noch einmal, um sie zu beenden"],
];

/** @param {string} text */
function pattern(text) {
  const parts = text.split(/\{\d\}/).map((part) => part.replace(/[.*+?^${}()|[\]\\]/g, "\\$&"));
  return new RegExp(`^${parts.join("(.+?)")}$`);
}

/** The patterns with the German texts. @type {[RegExp, string][]} */
export const sentences = TEXTS.map(([text, german]) => [pattern(text), german]);
