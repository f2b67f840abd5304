//! What a user must know beside the result of a command, and the steps of a scan.

use crate::counted::{Entries, Errors, Frames, Lines, OfSamples, Samples};
use crate::error::{Differing, Error};
use adapter::unread::Unread;
use plumbline::can::BitRate;
use plumbline::time::Duration;
use texts::texts;

/// Where the calibration and the identity of a unit go from its store file.
const DOWNLOAD: &str = "The download with probe-rs (README of Plumbline, \"Calibrating a unit\") replaces the settings of the unit: `plumbline backup` before and `plumbline restore` after it keep them";
const DOWNLOAD_DE: &str = "Das Laden mit probe-rs (README von Plumbline, \"Calibrating a unit\") ersetzt die Einstellungen der Einheit: `plumbline backup` davor und `plumbline restore` danach erhalten sie";

texts! {
    /// What a user must know beside the result.
    Note {
        NotStored = "not stored yet: `plumbline save` stores it",
            "noch nicht gespeichert: Drücken Sie Im Sensor speichern", "not stored yet: press Save in sensor";
        StoredBySensor = "the sensor stores it by itself", "der Sensor speichert es von selbst";
        ThenSave = "then `plumbline save`, so that the sensor keeps the factory values",
            "drücken Sie dann Im Sensor speichern, damit der Sensor die Werkswerte behält",
            "then press Save in sensor, so that the sensor keeps the factory values";
        NoSaveCommand = "the device has no command to store: its manual says whether it keeps its settings at power-off",
            "das Gerät hat keinen Befehl zum Speichern: Sein Handbuch sagt, ob es seine Einstellungen beim Ausschalten behält";
        AtRestart(name: String) = "{name} acts after the next restart", "{name} gilt nach dem nächsten Neustart";
        Cleared(name: &'static str) = "the sensor had the error {name} before this command, which cleared it",
            "der Sensor hatte vor diesem Befehl den Fehler {name}; der Befehl hat ihn gelöscht";
        PdoOff(name: String) = "the PDO of {name} stays switched off. To switch it on, set {name}",
            "das PDO von {name} bleibt ausgeschaltet. Um es einzuschalten, setzen Sie {name}";
        NoAngles(why: Step) = "{why}: its angles are not compared", "{why}: Seine Winkel werden nicht verglichen";
        SwitchOn(name: String, product: &'static str) = "switch on the next sensor: {name} ({product})", "schalten Sie den nächsten Sensor ein: {name} ({product})";
        Scans(product: &'static str) = "looking for sensors of {product} by LSS: all nodes with LSS lose their node-ID until they get one, or until their restart",
            "sucht Sensoren von {product} durch LSS: Alle Knoten mit LSS verlieren ihre Node-ID, bis sie eine bekommen oder neu starten";
        SwitchOff(name: String) = "switch {name} off", "schalten Sie {name} aus";
        Commissioned(line: String) = "{line}", "{line}";
        GoesOn(path: String) = "the same command continues where it stopped; {path} has the state", "derselbe Befehl setzt dort fort, wo er aufgehört hat; {path} hat den Stand";
        StaysZero(name: String) = "{name} stays 0. To change it, set {name}", "{name} bleibt 0. Um es zu ändern, setzen Sie {name}";
        LeftOut(why: String) = "skipped: {why}", "weggelassen: {why}";
        EntryLeftOut(name: String, failure: Error) = "{name} is skipped: {failure}", "{name} ist weggelassen: {failure}";
        CommandLeftOut = "one entry is skipped, because writing it is a command or changes process data: the file names it",
            "ein Eintrag ist weggelassen, weil sein Schreiben ein Befehl ist oder Prozessdaten ändert: Die Datei nennt ihn";
        CommandsLeftOut(count: usize) = "{count} entries are skipped, because writing them is a command or changes process data: the file lists them",
            "{count} Einträge sind weggelassen, weil ihr Schreiben ein Befehl ist oder Prozessdaten ändert: Die Datei nennt sie";
        Labels(path: String) = "the names are in {path}", "die Namen stehen in {path}";
        Labelled(name: String) = "the sensor has the name {name:?} of the file now", "der Sensor hat jetzt den Namen {name:?} der Datei";
        NotLabelled(failure: Error) = "the label in the file was not taken over: {failure}", "der Name in der Datei wurde nicht übernommen: {failure}";
        Here(sensor: String) = "{sensor}", "{sensor}";
        LastCommand(options: String) = "as in the last command: {options}", "wie im letzten Befehl: {options}";
        Listens = "the bit rate is not sure: the tool listens at all bit rates, for 13 s at most",
            "die Bitrate ist nicht sicher: Das Programm hört mit allen Bitraten, höchstens 13 s lang";
        Searches = "no answer there: the tool searches as without the last command",
            "dort antwortet niemand: Das Programm sucht wie ohne den letzten Befehl";
        FoundNow(line: String) = "this line finds the sensor now: {line}", "diese Zeile findet den Sensor jetzt: {line}";
        FoundAfterRestart(line: String) = "this line finds the sensor after its next restart: {line}",
            "diese Zeile findet den Sensor nach seinem nächsten Neustart: {line}";
        FramesUnknown(count: u64) = "frames that are in no table: {count}. Give the product with --product, or the data sheet (--eds) or CAN database (--dbc) of the device that sends them",
            "Frames, die in keiner Tabelle stehen: {count}. Geben Sie das Produkt mit --product an, oder das Datenblatt (--eds) oder die CAN-Datenbank (--dbc) des Geräts, das sie sendet";
        ProductUnknown(nodes: String) = "the product of {nodes} is not known, so its data are shown as bytes: give it with --product NAME (`plumbline scan` shows it), or its data sheet with --eds FILE",
            "das Produkt von {nodes} ist nicht bekannt, deshalb sind die Daten als Bytes gezeigt: Geben Sie es mit --product NAME an (`plumbline scan` zeigt es), oder das Datenblatt mit --eds FILE";
        Taken(names: String) = "the sensor has set {names} from its position, and this cannot be transferred to another sensor: after `restore` to another one, bring it into the same position and repeat `plumbline teach` or `plumbline zero` there",
            "der Sensor hat {names} aus seiner Lage übernommen, und kein anderer Sensor kann das erhalten: Bringen Sie nach dem Wiederherstellen einen anderen in dieselbe Lage, und wiederholen Sie dort `plumbline teach` oder `plumbline zero`";
        TakenMissing(names: String) = "the file cannot carry {names}, which the sensor in it had set from its position: bring this sensor into the same position, and repeat `plumbline teach` or `plumbline zero`",
            "die Datei kann {names} nicht übertragen, was ihr Sensor aus seiner Lage übernommen hatte: Bringen Sie diesen Sensor in dieselbe Lage, und wiederholen Sie `plumbline teach` oder `plumbline zero`";
        Unread(count: Lines, first: String) = "the adapter has sent {count} not in the format of slcan, the first is {first:?}: frames are missing. Check its firmware and the settings of its port",
            "der Adapter hat {count} nicht im Format von slcan gesendet, die erste ist {first:?}: Frames fehlen. Prüfen Sie seine Firmware und die Einstellungen seines Anschlusses";
        LostFrames(count: Frames) = "the adapter has lost at least {count}: stop other programs, or use an adapter with a larger queue",
            "der Adapter hat mindestens {count} verloren: Beenden Sie andere Programme, oder verwenden Sie einen Adapter mit größerem Puffer";
        OtherLines(count: Lines) = "skipped: {count} of the log without a frame of classical CAN",
            "weggelassen: {count} des Protokolls ohne Frame von klassischem CAN";
        NoAdapter = "this computer has no adapter that plumbline can use: plug one in, or try demo:is2",
            "dieser Computer hat keinen Adapter für plumbline: Stecken Sie einen an, oder versuchen Sie demo:is2";
        EntriesNotShown(count: Entries) = "skipped: {count} of the data sheet with a type that plumbline does not show, or without an object",
            "weggelassen: {count} des Datenblatts mit einem Typ, den plumbline nicht zeigt, oder ohne Objekt";
        LineIgnored(line: usize) = "line {line} of the data sheet is no section, new entry or comment and is ignored",
            "Zeile {line} des Datenblatts ist weder Abschnitt noch neuer Eintrag noch Kommentar und wird nicht beachtet";
        LinesIgnored(line: usize, more: usize) = "line {line} (and {more} more) of the data sheet is no section, new entry or comment and is ignored",
            "Zeile {line} (und {more} weitere) des Datenblatts ist weder Abschnitt noch neuer Eintrag noch Kommentar und wird nicht beachtet";
        NotCompared(what: String) = "the data sheet names no {what}, so it is not compared",
            "das Datenblatt nennt {what} nicht, deshalb wird das nicht verglichen";
        Sheet(path: String) = "the sheet is {path}", "das Datenblatt ist {path}";
        Identity(product: &'static str, path: String) = "the identity of a unit of {product} is in {path}. {DOWNLOAD}",
            "die Identität einer Einheit von {product} ist in {path}. {DOWNLOAD_DE}";
        Calibration(product: &'static str, serial: u32, path: String) = "the calibration of {product} with serial number {serial} is in {path}. {DOWNLOAD}",
            "die Kalibrierung von {product} mit der Seriennummer {serial} ist in {path}. {DOWNLOAD_DE}";
        NoStore = "--store FILE with --product NAME writes it into a store file of the unit",
            "--store FILE mit --product NAME schreibt sie in eine Speicherdatei der Einheit";
        OtherComputers = "other computers can open the page: use the address of this computer instead of 127.0.0.1. Every user who knows the secret can change the sensor",
            "andere Computer können die Seite öffnen: Verwenden Sie die Adresse dieses Computers statt 127.0.0.1. Jeder, der das Geheimnis kennt, kann den Sensor ändern";
        Secret = "the address contains a secret: do not give it to other people. Ctrl-C ends the server.",
            "die Adresse enthält ein Geheimnis: Geben Sie sie nicht weiter. Strg-C beendet den Server.";
        NoBrowser(reason: String) = "cannot open a browser ({reason}): open the address yourself",
            "kein Browser lässt sich öffnen ({reason}): Öffnen Sie die Adresse selbst";
        Silent(cause: Box<Note>) = "the sensor has not answered for 1 s: {cause}. The command continues; Ctrl-C ends it",
            "der Sensor hat 1 s lang nicht geantwortet: {cause}. Der Befehl geht weiter; Strg-C beendet ihn";
        CheckWiring = "check power and wiring", "Prüfen Sie Versorgung und Verdrahtung";
        Answers = "the sensor answers again", "der Sensor antwortet wieder";
        LostSamples(lost: u64, all: OfSamples) = "{lost} of {all} lost", "{lost} von {all} verloren";
        NoValue(count: Samples) = "{count} with an empty value: the sensor sent no valid angle, or the angle does not fit in 16 bits at this resolution (in this case set resolution, or leave out --cyclic)",
            "{count} mit leerem Wert: Der Sensor hat keinen gültigen Winkel gesendet, oder der Winkel passt bei dieser Auflösung nicht in 16 Bits (dann setzen Sie resolution, oder lassen Sie --cyclic weg)";
        CounterRestarted = "the counter of the sensor started again: was the sensor off? The lost samples of this time are calculated from the time",
            "der Zähler des Sensors hat neu begonnen: War der Sensor aus? Die verlorenen Messwerte dieser Zeit sind aus der Zeit berechnet";
        NotPutBack = "the settings of the sensor for --cyclic could not be put back. They are not stored: switch the sensor off and on, then it has its previous settings",
            "die Einstellungen des Sensors für --cyclic konnten nicht zurückgesetzt werden. Sie sind nicht gespeichert: Schalten Sie den Sensor aus und ein, dann hat er seine vorigen Einstellungen";
        NotReleased = "the connection to the sensor could not be released: the sensor releases the connection by itself after four times --every, and not before 10 s",
            "die Verbindung zum Sensor konnte nicht freigegeben werden: Der Sensor gibt sie von selbst nach viermal --every frei, aber nicht vor 10 s";
        SentAlready(number: u16, every: Every) = "the sensor sends its angles in TPDO {number} already, {every}: it is only listened to, without --every",
            "der Sensor sendet seine Winkel schon in TPDO {number}, {every}: Er wird nur gehört, ohne --every";
        OwnedByOther(every: Every, names: String) = "another master owns the sensor: it is only listened to, nothing is sent. Its messages come {every}; they are taken as {names}, with the factory resolution",
            "ein anderer Master besitzt den Sensor: Er wird nur gehört, nichts wird gesendet. Seine Nachrichten kommen {every}; sie gelten als {names}, mit der Auflösung wie geliefert";
        AdapterTakesPart = "the adapter has no listen-only mode: it acknowledges the messages of other devices while the tool listens",
            "der Adapter hat keine Betriebsart, in der er nur hört: Er bestätigt die Nachrichten anderer Geräte, während das Programm hört";
        InterfaceTakesPart(failure: Error) = "the interface takes part in the bus and acknowledges the messages of other devices while the tool listens: {failure}",
            "die Schnittstelle nimmt am Bus teil und bestätigt die Nachrichten anderer Geräte, während das Programm hört: {failure}";
        AsksAtOnce = "the adapter has no listen-only mode: sending requests without listening first",
            "der Adapter hat keine Betriebsart, in der er nur hört: Das Programm fragt, ohne vorher zu hören";
        NotAsked(option: &'static str) = "no request was sent: `plumbline scan {option}` sends the requests without this question",
            "keine Anfrage wurde gesendet ({option})", "no request was sent ({option})";
        Protocol(name: &'static str) = "the protocol of the bus is {name}: the tool sends no requests of other protocols",
            "das Protokoll des Busses ist {name}: Das Programm sendet keine Anfragen anderer Protokolle";
        SearchTakes(seconds: u64) = "the requests to all node-IDs, MAC IDs and 11-bit identifiers take at least {seconds} s",
            "die Anfragen an alle Node-IDs, MAC IDs und 11-Bit-Identifier dauern mindestens {seconds} s";
        WaitsInBootloader = "the sensor waits in its bootloader: its settings were not read",
            "der Sensor wartet in seinem Bootloader: Seine Einstellungen wurden nicht gelesen";
        SettingsDiffer(differing: Differing, path: String) = "{differing} from {path}: `plumbline restore` writes the file again",
            "{differing} als in {path}: `plumbline restore` schreibt die Datei wieder";
        SendsOnce(frame: String) = "sends {frame} once", "sendet {frame} einmal";
        Replays(count: Frames, path: String, time: f64) = "sends {count} of {path} in {time:.1} s", "sendet {count} von {path} in {time:.1} s";
        ReplaysAgain(count: Frames, path: String, time: f64) = "sends {count} of {path} repeatedly, each time in {time:.1} s",
            "sendet {count} von {path} immer wieder, jedes Mal in {time:.1} s";
        SendsEvery(frame: String, every: u32) = "sends {frame} every {every} ms", "sendet {frame} alle {every} ms";
        NotSentInTime(count: Frames) = "skipped: {count}, because the bus or the computer was too slow",
            "ausgelassen: {count}, weil der Bus oder der Computer zu langsam war";
        BusErrors(count: Errors) = "the adapter has reported at least {count} of the bus, so frames can be missing: check bit rate, wiring, terminators, and whether another device is on the bus",
            "der Adapter hat mindestens {count} des Busses gemeldet, also können Frames fehlen: Prüfen Sie Bitrate, Verdrahtung und Abschlusswiderstände, und ob ein anderes Gerät am Bus ist";
        BrokerConnected(url: String) = "connected with {url}", "verbunden mit {url}";
        BrokerAway(url: String, reason: String, seconds: u64) = "no connection with {url} ({reason}): samples are buffered, next try in {seconds} s",
            "keine Verbindung mit {url} ({reason}): Die Messwerte werden aufgehoben, nächster Versuch in {seconds} s";
        RecordsLost(count: Samples) = "lost: {count}, because the broker was disconnected for too long: give more room with --buffer-size",
            "verloren: {count}, weil der Broker zu lange fort war: Geben Sie mit --buffer-size mehr Platz";
        DiskFull(count: Samples, path: String) = "lost: {count}, because the disk of {path} is full: the next ones are buffered as soon as it has space",
            "verloren: {count}, weil die Platte von {path} voll ist: Die nächsten werden behalten, sobald sie Platz hat";
        BufferDamaged(path: String) = "a file in {path} is damaged or deleted: the samples after the damaged part are lost", "eine Datei in {path} ist beschädigt oder gelöscht: Die Messwerte hinter der Beschädigung sind verloren";
        RecordsLeft(count: Samples, path: String) = "the next start delivers {count} from {path}",
            "der nächste Start liefert {count} aus {path}";
        NotSynchronised(path: String, reason: String) = "{path} cannot be written to the disk ({reason}): samples can be lost at a power cut",
            "{path} lässt sich nicht auf die Platte schreiben ({reason}): Bei einem Stromausfall können Messwerte verloren gehen";
        SensorLost(sensor: String) = "{sensor}: does not answer any more", "{sensor}: antwortet nicht mehr";
        SensorBack(sensor: String) = "{sensor}: answers again", "{sensor}: antwortet wieder";
        SensorNew(sensor: String) = "{sensor}: is new on the bus", "{sensor}: ist neu am Bus";
        NotBridged(sensor: String) = "{sensor}: skipped, because its product is not known, or another master owns it",
            "{sensor}: weggelassen, weil das Produkt nicht bekannt ist oder ein anderer Master ihn besitzt";
        OnlyHeard(node: String) = "{node}: skipped, because it was heard and does not answer as a sensor",
            "{node}: weggelassen, weil er zu hören war und nicht als Sensor antwortet";
        AllCauses = "all causes are in the chapter \"No answer\" of EXCHANGE.md",
            "alle Ursachen stehen im Kapitel \"Niemand antwortet\" von AUSTAUSCH.md";
        NothingSent = "nothing was sent", "nichts wurde gesendet";
        OnlyAcknowledged = "nothing was sent, but the messages of other devices were acknowledged",
            "nichts wurde gesendet, aber die Nachrichten anderer Geräte wurden bestätigt";
        Sent(count: Frames, at: At) = "sent {count} at {at}", "{count} bei {at} gesendet";
    }
}

impl Note {
    /// What the adapter says and the tool cannot read; None: every line was read.
    pub fn unread(unread: &Unread) -> Option<Self> {
        let count = unread.count();
        (count > 0).then(|| Self::Unread(Lines(count), unread.first()))
    }
}

texts! {
    /// A step of a scan.
    Step {
        Switch = "switch the sensor off and on now: it then sends its address",
            "schalten Sie den Sensor jetzt aus und ein: Dann sendet er seine Adresse";
        Listened(at: At, time: u64, frames: Frames) = "listened at {at} for {time} ms: {frames}",
            "bei {at} {time} ms gehört: {frames}";
        Counted(step: Box<Step>, errors: Errors) = "{step}, {errors}", "{step}, {errors}";
        Waits(step: Box<Step>) = "{step} - switch the sensor off and on now: it then sends its address",
            "{step} - schalten Sie den Sensor jetzt aus und ein: Dann sendet er seine Adresse";
        Numbered(done: usize, total: usize, step: Box<Step>) = "[{done:2}/{total}] {step}", "[{done:2}/{total}] {step}";
        Delivered(at: At) = "sending requests to the factory addresses ({at})", "fragt bei {at} auf den Adressen wie geliefert";
        DeliveredAgain(at: At) = "sending requests to the factory addresses again, with more time ({at})",
            "fragt bei {at} noch einmal auf den Adressen wie geliefert, mit mehr Zeit";
        Everybody(at: At) = "sending requests to all node-IDs and MAC IDs ({at})", "fragt bei {at} auf allen Node-IDs und MAC IDs";
        Examines(frames: Frames) = "listening: {frames}", "hört: {frames}";
        Moves(spread: f64) = "the sensor is not at rest: spread {spread:.2} deg in 3 s", "der Sensor ist nicht in Ruhe: Streuung {spread:.2} deg in 3 s";
        NoAngleYet = "the sensor has no valid angle for 3 s without a break", "der Sensor hat nicht 3 s lang einen gültigen Winkel";
        Defective = "the sensor reports an error, so its angles are not valid", "der Sensor meldet einen Fehler, deshalb sind seine Winkel nicht gültig";
        Downloads(version: String) = "loading version {version} into the sensor", "lädt die Version {version} in den Sensor";
        Identifiers(seconds: u64, at: At) = "searching all 11-bit identifiers, at least {seconds} s ({at})",
            "sucht bei {at} auf allen 11-Bit-Identifiern, mindestens {seconds} s lang";
    }
}

texts! {
    /// A bit rate of a bus.
    At {
        Interface = "the bit rate of the interface", "der Bitrate der Schnittstelle";
        Rate(name: &'static str) = "{name}", "{name}";
    }
}

impl From<Option<BitRate>> for At {
    fn from(rate: Option<BitRate>) -> Self {
        rate.map_or(Self::Interface, |rate| Self::Rate(rate.name()))
    }
}

texts! {
    /// When cyclic messages come.
    Every {
        Time(ms: f64) = "every {ms} ms", "alle {ms} ms";
        Unknown = "without a period, so lost samples cannot be counted",
            "ohne Periode, deshalb werden verlorene Messwerte nicht gezählt";
    }
}

impl From<Option<Duration>> for Every {
    fn from(every: Option<Duration>) -> Self {
        every.map_or(Self::Unknown, |every| {
            Self::Time(every.ticks() as f64 / 1000.0)
        })
    }
}
