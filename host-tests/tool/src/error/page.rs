//! Errors of the server of the page.

use std::fmt::{Display, Formatter};
use texts::{Text, errors, texts};
use virtual_sensor::server::Refused;

errors! {
    /// A request of the page that is refused.
    PageError {
        Stopped: Stopped "stopped" = "stopped by the user: start the command again to finish it",
            "angehalten: Beginnen Sie die Aktion noch einmal, um sie zu beenden";
        OtherTab: Refused "other-tab" = "another tab controls the sensor: nothing was done. Press Take over, then repeat the action",
            "ein anderer Tab steuert den Sensor: Nichts ist geschehen. Drücken Sie Übernehmen, und wiederholen Sie die Aktion";
        NoTab: Usage "bad-request" = "the request has no name of a tab", "die Anfrage hat keinen Namen eines Tabs";
        Stopping: Bus "stopped" = "the server is stopping: start `plumbline serve` again", "der Server hält an: Starten Sie `plumbline serve` neu";
        Samples(most: u32): Usage "out-of-range" = "at most {most} samples per second are possible", "höchstens {most} Messwerte pro Sekunde sind möglich";
        TextOrProduct: Usage "bad-request" = "a file is opened from its text or from a product", "eine Datei wird aus ihrem Text oder von einem Produkt geöffnet";
        NoStore: Usage "no-store" = "there is no store file: start `plumbline serve --store FILE`", "es gibt keine Speicherdatei: Starten Sie `plumbline serve --store FILE`";
        NoRequest: Usage "bad-request" = "there is no such request", "diese Anfrage gibt es nicht";
        List: Usage "bad-request" = "the request is not valid: it is a list", "die Anfrage ist nicht gültig: Sie ist eine Liste";
        Invalid(why: BadRequest): Usage "bad-request" = "the request is not valid: {why}", "die Anfrage ist nicht gültig: {why}";
        NoProtocol: Usage "bad-request" = "an address needs its protocol: fsc, canopen, devicenet or j1939", "eine Adresse braucht ihr Protokoll: fsc, canopen, devicenet oder j1939";
        TooManyTabs(most: usize): Bus "too-many-tabs" = "{most} tabs are already open: close one of them, then this page connects automatically",
            "{most} Tabs sind schon offen. Schließen Sie einen davon: Dann verbindet sich diese Seite von selbst";
        Forbidden(why: Forbidden): Usage "forbidden" = "{why}", "{why}";
        NoListen(address: String, reason: String): Bus "no-listen" = "cannot listen on {address} ({reason}): choose another port with --listen 127.0.0.1:0",
            "auf {address} ist keine Verbindung möglich ({reason}): Wählen Sie einen anderen Port mit --listen 127.0.0.1:0";
        NoServer(reason: String): Bus "no-server" = "{reason}", "der Server ist gescheitert: {reason}";
        NoRandom(reason: String): Bus "no-random" = "no random numbers: {reason}", "keine Zufallszahlen: {reason}";
        SheetGone: Usage "unknown-product" = "the server does not have this data sheet any more: choose its file again",
            "der Server hat dieses Datenblatt nicht mehr: Wählen Sie die Datei noch einmal";
        StandIn(why: Refused): Usage "bad-value" = "the virtual sensor refuses it: {why}", "der virtuelle Sensor lehnt ab: {why}";
        NoStandIn: Usage "not-connected" = "there is no virtual sensor: only a port demo:PRODUCT has one", "es gibt keinen virtuellen Sensor: Nur ein Anschluss demo:PRODUKT hat einen";
        NotOfStandIn: Usage "bad-request" = "the page cannot ask this of the virtual sensor", "die Seite kann das vom virtuellen Sensor nicht verlangen";
        NotInCatalogue(product: String): Usage "wrong-image" = "the catalogue does not have the product {product} of the file: nothing has changed",
            "der Katalog hat das Produkt {product} der Datei nicht: Nichts hat sich geändert";
        NotConnected: Usage "not-connected" = "there is no sensor: connect to one first", "kein Sensor: Verbinden Sie sich zuerst mit einem";
        SendsNothing: Usage "not-connected" = "nothing can be sent: connect in the mode active, or in the mode frames only",
            "es kann nichts gesendet werden: Verbinden Sie sich in der Betriebsart aktiv oder nur Frames";
        NoFrame: Usage "bad-value" = "this is no frame: write identifier#data with up to 3 hexadecimal digits or 8, and up to 8 bytes, for example 181#0102",
            "das ist kein Frame: Schreiben Sie Identifier#Daten mit bis zu 3 hexadezimalen Ziffern oder 8 und bis zu 8 Bytes, zum Beispiel 181#0102";
        Period(most: u32): Usage "out-of-range" = "the period is 1 to {most} ms", "die Periode ist 1 bis {most} ms";
        Speed: Usage "out-of-range" = "the speed is 0.01 to 100", "die Geschwindigkeit ist 0,01 bis 100";
        NoLine(number: u64): Usage "no-line" = "line {number} is no longer in the transmit list", "Zeile {number} ist nicht mehr in der Sendeliste";
        TooManyLines(most: usize): Usage "too-many-lines" = "the transmit list has at most {most} lines: remove some first",
            "die Sendeliste hat höchstens {most} Zeilen: Entfernen Sie zuerst einige";
        AlreadyShown(address: String): Usage "already-shown" = "the chart shows the sensor at {address} already: choose another one",
            "das Diagramm zeigt den Sensor auf {address} schon: Wählen Sie einen anderen";
        TooManySensors(most: usize): Usage "too-many-sensors" = "the chart shows {most} sensors already: remove one first",
            "das Diagramm zeigt schon {most} Sensoren: Entfernen Sie zuerst einen";
        SensorChanged(line: String): Refused "sensor-changed" = "another sensor is connected now ({line}): nothing was done. Look at it, and give the command again",
            "jetzt ist ein anderer Sensor verbunden ({line}), deshalb ist nichts geschehen. Sehen Sie ihn an, und wiederholen Sie die Aktion";
    }
}

/// Why the body of a request is not valid. Programs that send requests read the English text of the parser.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct BadRequest {
    english: String,
    /// Where it is no JSON: line and column; None: it is JSON with a wrong name or value.
    place: Option<(usize, usize)>,
}

impl From<serde_json::Error> for BadRequest {
    fn from(error: serde_json::Error) -> Self {
        Self {
            english: error.to_string(),
            place: (!error.is_data()).then(|| (error.line(), error.column())),
        }
    }
}

impl Display for BadRequest {
    fn fmt(&self, to: &mut Formatter) -> std::fmt::Result {
        to.write_str(&self.english)
    }
}

impl Text for BadRequest {
    fn german(&self) -> String {
        match self.place {
            None => "sie hat einen Namen oder einen Wert, den es nicht gibt".to_owned(),
            Some((line, column)) => {
                format!("sie ist kein JSON, ab Zeile {line}, Spalte {column}")
            }
        }
    }
}

texts! {
    /// Why a request is not answered.
    Forbidden {
        Unreadable = "a header is not readable", "ein Header ist nicht lesbar";
        Twice = "a header occurs twice", "ein Header kommt zweimal vor";
        Host = "the name of the server is wrong: open the address that `plumbline serve` has printed",
            "der Name des Servers ist falsch: Öffnen Sie die Adresse, die `plumbline serve` ausgegeben hat";
        Origin = "this request came from another page and was refused: nothing was done",
            "diese Anfrage kam von einer anderen Seite und wurde abgelehnt: Nichts ist geschehen";
        Secret = "the secret is missing or old: open the address that `plumbline serve` has printed",
            "das Geheimnis fehlt oder ist alt: Öffnen Sie die Adresse, die `plumbline serve` ausgegeben hat";
        ContentType = "a request has the content type application/json", "eine Anfrage hat den Content-Type application/json";
        TooLong = "the request is too long: a log has at most 16 MiB, another file 1 MiB",
            "die Anfrage ist zu lang: Ein Protokoll hat höchstens 16 MiB, eine andere Datei 1 MiB";
    }
}
