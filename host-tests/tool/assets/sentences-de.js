// The questions and the steps of the program in German. A text that is not here stays in English.

/** The sentences of the program and their German texts; {0}, {1} are the parts that change. @type {[string, string][]} */
const TEXTS = [
  // Questions.
  ["There is no traffic. Ask at all addresses and bit rates?",
    "Es gibt keinen Verkehr. Auf allen Adressen und Bitraten fragen?"],
  ["There is no traffic at any bit rate. Ask at all bit rates? At a wrong rate the questions destroy the messages of other devices.",
    "Auf keiner Bitrate gibt es Verkehr. Auf allen Bitraten fragen? Auf einer falschen Bitrate zerstören die Anfragen die Nachrichten anderer Geräte."],
  ["There is traffic, but no sensor was recognised. Ask at all addresses? Other devices can interpret a request as a command.",
    "Es gibt Verkehr, aber kein Sensor wurde erkannt. Auf allen Adressen fragen? Andere Geräte können eine Anfrage als Befehl verstehen."],
  ["There is traffic, but no sensor was recognised. Ask at the addresses as delivered? Other devices can interpret a request as a command.",
    "Es gibt Verkehr, aber kein Sensor wurde erkannt. Auf den Adressen wie geliefert fragen? Andere Geräte können eine Anfrage als Befehl verstehen."],
  ["Search for more sensors? The tool asks at all other addresses. Other devices can interpret a request as a command.",
    "Nach weiteren Sensoren suchen? Das Programm fragt auf allen anderen Adressen. Andere Geräte können eine Anfrage als Befehl verstehen."],
  ["Frames look like those of a sensor ({0}, {1}). Ask it? Another device can interpret the request as a command.",
    "Frames sehen aus wie die eines Sensors ({0}, {1}). Ihn fragen? Ein anderes Gerät kann die Anfrage als Befehl verstehen."],
  ["The adapter has no listen-only mode. Allow it to take part in the bus at {0} while the tool listens? It acknowledges the messages of other devices, and at a wrong bit rate it destroys them.",
    "Der Adapter hat keine Betriebsart, in der er nur hört. Darf er bei {0} am Bus teilnehmen, während das Programm hört? Er bestätigt die Nachrichten anderer Geräte, und auf einer falschen Bitrate zerstört er sie."],
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
