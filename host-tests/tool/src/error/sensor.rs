//! Errors of a sensor: it refuses, does not answer, or is not as it should be.

use super::{NO_ANSWER, NO_ANSWER_DE, NOT_FOUND, NOT_FOUND_DE};
use crate::counted::Bytes;
use crate::ops::NewRate;
use texts::{errors, texts};

errors! {
    /// A request that the sensor has refused.
    Refusal {
        Code(code: u8, names: String, next: Next): Refused "refused" = "the sensor refused code {code:02X}h ({names}): nothing has changed. {next}",
            "der Sensor hat Code {code:02X}h abgelehnt ({names}): Nichts hat sich geändert. {next}";
        Status(request: String, status: u8, next: Next): Refused "refused" = "the sensor refused {request}, or an earlier request: its answer has the status {status:02X}h. {next}; `plumbline raw 02` reads and clears the status",
            "der Sensor hat {request} oder eine frühere Anfrage abgelehnt: Seine Antwort hat den Status {status:02X}h. {next}; die Anfrage 02 liest und löscht den Status";
        Sdo(what: What, reason: Reason, code: u32, next: Next): Refused "refused" = "the sensor refused {what}: {reason} ({code:08X}h). {next}",
            "der Sensor hat {what} abgelehnt: {reason} ({code:08X}h). {next}";
        Length(what: What, reason: Reason, code: u32, length: Bytes, example: String): Refused "refused" = "the sensor refused {what}: {reason} ({code:08X}h). The object has {length}: write all bytes of the object, for example {example}",
            "der Sensor hat {what} abgelehnt: {reason} ({code:08X}h). Das Objekt hat {length}: Schreiben Sie alle Bytes des Objekts, zum Beispiel {example}";
        Explicit(what: What, reason: Reason, code: u8, more: u8, next: Next): Refused "refused" = "the sensor refused {what}: {reason} ({code:02X}h, {more:02X}h). {next}",
            "der Sensor hat {what} abgelehnt: {reason} ({code:02X}h, {more:02X}h). {next}";
        Lss(what: What, error: u8, next: Next): Refused "refused" = "the sensor refused {what} (LSS error {error}): it has not changed. {next}",
            "der Sensor hat {what} abgelehnt (LSS-Fehler {error}): Nichts hat sich geändert. {next}";
        Group(pgn: u32): Refused "refused" = "the node does not have the group {pgn:05X}h, or cannot send it now: check the number, or repeat",
            "der Knoten hat die Gruppe {pgn:05X}h nicht oder kann sie jetzt nicht senden: Prüfen Sie die Nummer, oder wiederholen Sie";
    }
}

errors! {
    /// No answer in time.
    Silence {
        Nobody(at: Place, rate: Rates): Silent "no-answer" = "no answer{at}{rate}: check power and wiring, or find the sensor with `plumbline scan`",
            "niemand antwortet{at}{rate}: {NO_ANSWER_DE}",
            "no answer{at}{rate}: {NO_ANSWER}";
        Code(code: u8, id: String): Silent "no-answer" = "no answer to code {code:02X}h at the identifier {id}: `plumbline scan` finds the sensor",
            "niemand antwortet auf Code {code:02X}h auf dem Identifier {id}: {NO_ANSWER_DE}",
            "no answer to code {code:02X}h at the identifier {id}: {NO_ANSWER}";
        Node(node: u8): Silent "no-answer" = "node {node} does not answer: `plumbline scan` finds the sensor",
            "Node {node} antwortet nicht: {NOT_FOUND_DE}", "node {node} does not answer: {NOT_FOUND}";
        J1939Node(address: u8): Silent "no-answer" = "the J1939 node with the address {address} does not answer: `plumbline scan` finds the sensor",
            "der J1939-Knoten mit der Adresse {address} antwortet nicht: {NOT_FOUND_DE}",
            "the J1939 node with the address {address} does not answer: {NOT_FOUND}";
        J1939Address(address: u8): Silent "no-answer" = "the J1939 address {address} does not answer: `plumbline scan` finds the sensor",
            "die J1939-Adresse {address} antwortet nicht: {NOT_FOUND_DE}",
            "the J1939 address {address} does not answer: {NOT_FOUND}";
        MacId(mac: u8): Silent "no-answer" = "MAC ID {mac} does not answer: `plumbline scan` finds the sensor",
            "MAC ID {mac} antwortet nicht: {NOT_FOUND_DE}", "MAC ID {mac} does not answer: {NOT_FOUND}";
        Bootloader: Silent "no-answer" = "the bootloader does not answer: `plumbline update` with the address of the sensor continues",
            "der Bootloader antwortet nicht: Wählen Sie oben Bitrate und Adresse des Sensors, der wartet, und drücken Sie Firmware aktualisieren",
            "the bootloader does not answer: choose bit rate and address of the waiting sensor above, and press Update firmware";
        Selection: Silent "no-answer" = "no node has answered to the selection by LSS: does another node have the same identity (1018h)?",
            "kein Knoten hat auf die Auswahl durch LSS geantwortet: Hat ein anderer Knoten dieselbe Identität (1018h)?";
        Lss: Silent "no-answer" = "the sensor does not answer LSS requests: `plumbline scan` finds it",
            "der Sensor antwortet nicht auf LSS-Anfragen: {NOT_FOUND_DE}",
            "the sensor does not answer LSS requests: {NOT_FOUND}";
        Next(name: String, seconds: u64): Silent "no-answer" = "no sensor has answered at the factory address for {seconds} s ({name} is next): check power, wiring and the bit rate (--rate), or wait longer with --wait. The same command continues",
            "auf der Adresse wie geliefert hat {seconds} s lang kein Sensor geantwortet ({name} ist der nächste): Prüfen Sie Versorgung, Verdrahtung und Bitrate (--rate), oder warten Sie länger mit --wait. Derselbe Befehl setzt fort";
        Moved(address: String): Silent "no-answer" = "the sensor does not answer at the {address}: switch it off and on, then `plumbline scan`",
            "der Sensor antwortet nicht auf {address}: Schalten Sie ihn aus und ein. {NOT_FOUND_DE}",
            "the sensor does not answer at the {address}: {NOT_FOUND}";
        Rate(rate: NewRate): Silent "no-answer" = "the sensor does not answer at the bit rate {rate}: switch it off and on, then `plumbline scan`",
            "der Sensor antwortet nicht bei der Bitrate {rate}: Schalten Sie ihn aus und ein. {NOT_FOUND_DE}",
            "the sensor does not answer at the bit rate {rate}: {NOT_FOUND}";
        Request: Silent "no-answer" = "the sensor does not answer", "der Sensor antwortet nicht";
        AnyRequest: Silent "no-answer" = "the sensor has not answered any request: check power and wiring",
            "der Sensor hat auf keine Anfrage geantwortet: Prüfen Sie Versorgung und Verdrahtung";
        Seconds(seconds: u64): Silent "no-answer" = "the sensor has not answered for the last {seconds} s: check power and wiring, then repeat the command",
            "der Sensor hat in den letzten {seconds} s nicht geantwortet: Prüfen Sie Versorgung und Verdrahtung, und wiederholen Sie den Befehl";
        Angles: Silent "no-answer" = "the sensor does not send its angles", "der Sensor sendet seine Winkel nicht";
        AnglesEnded: Silent "no-answer" = "the sensor does not send its angles any more: check power and wiring. If it was switched off during the command, start the command again",
            "der Sensor sendet seine Winkel nicht mehr: Prüfen Sie Versorgung und Verdrahtung. War er währenddessen aus, beginnen Sie noch einmal";
        Traffic: Silent "no-answer" = "there is no traffic, so the bit rate is unknown: give it with --rate",
            "es gibt keinen Verkehr, deshalb ist die Bitrate unbekannt: Wählen Sie die Bitrate";
        PageTraffic: Silent "no-answer" = "there is no traffic, so the bit rate is unknown: choose the bit rate, or connect actively",
            "es gibt keinen Verkehr, deshalb ist die Bitrate unbekannt: Wählen Sie die Bitrate, oder verbinden Sie sich aktiv";
    }
}

errors! {
    /// A sensor that is not as it should be.
    SensorError {
        WrongState(what: What, reason: Reason, code: u32, next: Next): Refused "wrong-state" = "the sensor refused {what}: {reason} ({code:08X}h). {next}",
            "der Sensor hat {what} abgelehnt: {reason} ({code:08X}h). {next}";
        Unexpected(what: What): Refused "unexpected-answer" = "the answer to {what} does not fit the product: is --product right?",
            "die Antwort auf {what} passt nicht zum Produkt: Ist das richtige Produkt gewählt?";
        NotInPlan(sensor: String): Refused "not-in-plan" = "this sensor ({sensor}) is not the next one in the plan: nothing has changed. Switch it off, or change the plan",
            "dieser Sensor ({sensor}) ist keiner, der im Plan an der Reihe ist: Nichts hat sich geändert. Schalten Sie ihn aus, oder ändern Sie den Plan";
        Together(address: String, serials: String): Usage "several-sensors" = "several sensors answer at {address}, with the serial numbers {serials}: leave only one of them on. The same command continues",
            "mehrere Sensoren antworten auf {address}, mit den Seriennummern {serials}: Lassen Sie nur einen eingeschaltet. Derselbe Befehl setzt fort";
        StillOn(name: String, seconds: u64): Usage "still-on" = "{name} still answers after {seconds} s: switch it off. The same command continues",
            "{name} antwortet nach {seconds} s noch immer: Schalten Sie ihn aus. Derselbe Befehl setzt fort";
        NotKept(name: String, differing: Differing): Refused "not-kept" = "{name} after its restart: {differing} from the plan. The same command writes the plan again",
            "{name} nach dem Neustart: {differing} als im Plan. Derselbe Befehl schreibt den Plan noch einmal";
        BadIdentity(why: String): Refused "unexpected-answer" = "{why}", "die Identität ist nicht gültig: {why}";
        Owned(mac: u8): Refused "owned" = "another master owns the sensor with MAC ID {mac}: it is only listened to; stop that master and repeat",
            "ein anderer Master besitzt den Sensor mit der MAC ID {mac}: Er wird nur gehört; halten Sie diesen Master an, und wiederholen Sie";
        OwnedUnknown(address: String): Refused "owned" = "another master owns the sensor with {address}, so the product is unknown: stop that master, or listen with --cyclic --product NAME",
            "ein anderer Master besitzt den Sensor mit {address}, deshalb ist das Produkt unbekannt: Halten Sie diesen Master an, oder wählen Sie das Produkt";
        OwnedSilent(mac: u8): Refused "owned" = "another master owns the sensor with MAC ID {mac}, and no I/O message of the sensor comes: stop that master and repeat",
            "ein anderer Master besitzt den Sensor mit der MAC ID {mac}, und es kommt keine I/O-Nachricht des Sensors: Halten Sie diesen Master an, und wiederholen Sie";
        Heartbeat(node: u8, own: u16, period: u32): Refused "not-put-back" = "the tool could not restore the heartbeat time of node {node}, which is {own} ms now: write {period} ms to 1017h, or restart the node",
            "die Heartbeat-Zeit von Node {node} konnte nicht zurückgesetzt werden und ist jetzt {own} ms: Schreiben Sie {period} ms in 1017h, oder starten Sie den Knoten neu";
        AddressInUse(address: String): Refused "address-in-use" = "the {address} is in use: nothing has changed. Choose another one; `plumbline scan --active` shows the devices on the bus",
            "{address} wird schon verwendet: Nichts hat sich geändert. Wählen Sie eine andere; Sensoren suchen zeigt die Geräte am Bus",
            "the {address} is in use: nothing has changed. Choose another one; Find sensors shows the devices on the bus";
        NotRestarted(new: NewRate, old: &'static str): Refused "not-restarted" = "{new} is stored, but the sensor still has {old}: switch it off and on",
            "{new} ist gespeichert, aber der Sensor hat noch {old}: Schalten Sie ihn aus und ein";
        NotWritten(name: String, text: String, read: String): Refused "not-written" = "{name} was written as {text}, but reads {read}: repeat, or restart the sensor with `plumbline restart`",
            "{name} wurde als {text} geschrieben, ist aber {read}: Wiederholen Sie, oder starten Sie den Sensor neu";
        Other(line: String): Refused "other-sensor" = "another sensor answers now ({line}): nothing was done. Check the sensor, and start the command again",
            "jetzt antwortet ein anderer Sensor ({line}): Nichts ist geschehen. Prüfen Sie den Sensor, und beginnen Sie noch einmal";
        NotAtRest(spread: f64): Refused "not-at-rest" = "the sensor was not at rest for 60 s, its angles differ by {spread:.2} deg in 3 s: nothing has changed. Stop the machine and repeat",
            "der Sensor war 60 s lang nicht in Ruhe, seine Winkel unterscheiden sich in 3 s um {spread:.2} deg: Nichts hat sich geändert. Halten Sie die Maschine an, und wiederholen Sie";
        NoValidAngle: Refused "no-angle" = "the sensor has had no valid angle for 3 s without a break: nothing has changed. `plumbline watch` shows its angles",
            "der Sensor hatte nie 3 s lang einen gültigen Winkel: Nichts hat sich geändert. Sehen Sie seine Winkel an";
        Defective: Refused "no-angle" = "the sensor reports an error, so its angles are not valid: nothing has changed. Check its position and supply, switch it off and on, or replace it",
            "der Sensor meldet einen Fehler, deshalb sind seine Winkel nicht gültig: Nichts hat sich geändert. Prüfen Sie seine Lage und Versorgung, schalten Sie ihn aus und ein, oder ersetzen Sie ihn";
        NoHeartbeat: Refused "not-offered" = "the NMT state of the node is unknown (no heartbeat, 1017h), so the tool does not start the node: start it with another NMT master, or leave out --cyclic",
            "der NMT-Zustand des Knotens ist unbekannt (kein Heartbeat, 1017h), deshalb wird der Knoten nicht gestartet: Starten Sie ihn mit einem anderen NMT-Master, oder lassen Sie --cyclic weg";
        NoTpdo: Refused "not-offered" = "no TPDO of the sensor has all angles, an event timer, and a unique COB-ID from 181h to 57Fh: set them (1800h, 1A00h), or leave out --cyclic",
            "kein TPDO des Sensors hat alle Winkel, einen Event-Timer und eine eindeutige COB-ID von 181h bis 57Fh: Stellen Sie sie ein (1800h, 1A00h), oder lassen Sie --cyclic weg";
        NoAngle(name: String, text: String): Refused "not-offered" = "{name} is {text}, so the response to a poll has no angle: set {name}, or leave out --cyclic",
            "{name} ist {text}, deshalb hat die Antwort auf einen Poll keinen Winkel: Setzen Sie {name}, oder lassen Sie --cyclic weg";
        IoSize(size: Bytes): Usage "wrong-product" = "the I/O messages of the sensor have {size}, not those of the angles of this product: is --product right?",
            "die I/O-Nachrichten des Sensors haben {size}, nicht die der Winkel dieses Produkts: Ist das richtige Produkt gewählt?";
        NoBootloader: Refused "no-bootloader" = "the sensor has no bootloader: it is an original, or its firmware was flashed without one; nothing has changed",
            "der Sensor hat keinen Bootloader: Er ist ein Original, oder sein Programm wurde ohne Bootloader geladen; nichts hat sich geändert";
        ImageUnfit: Refused "wrong-image" = "the bootloader refuses the file: it is for another product, measuring element or board; nothing has changed",
            "der Bootloader lehnt die Datei ab: Sie ist für ein anderes Produkt, Messelement oder eine andere Platine; nichts hat sich geändert";
        ImageOlder(version: String): Refused "older-image" = "the sensor has newer firmware than {version}: --downgrade installs the older one; nothing has changed",
            "das Programm des Sensors ist neuer als {version}: --downgrade lädt die Datei trotzdem; nichts hat sich geändert";
        ImageUnsigned: Refused "unsigned-image" = "the sensor takes only files with a signature of its key: `plumbline key sign` writes it; nothing has changed",
            "der Sensor nimmt nur Dateien mit einer Unterschrift seines Schlüssels: `plumbline key sign` schreibt sie; nichts hat sich geändert";
        ImageSigned: Refused "damaged-image" = "the file has arrived damaged, or the bootloader takes no signed files: start the command again, or load the file without a signature",
            "die Datei ist beschädigt angekommen, oder der Bootloader nimmt keine Dateien mit Unterschrift: Beginnen Sie den Befehl noch einmal, oder laden Sie die Datei ohne Unterschrift";
        ImageDamaged: Refused "damaged-image" = "the file has arrived damaged: start the command again",
            "die Datei ist beschädigt angekommen: Beginnen Sie den Befehl noch einmal";
        OtherBootloader: Refused "other-bootloader" = "the bootloader at this address is not that of Plumbline: nothing has changed",
            "der Bootloader an dieser Adresse ist nicht der von Plumbline: Nichts hat sich geändert";
        OtherProgram(crc: String): Refused "other-program" = "after the restart the sensor runs other firmware than that of the file (CRC {crc}): start the command again",
            "nach dem Neustart läuft im Sensor ein anderes Programm als das der Datei (CRC {crc}): Beginnen Sie den Befehl noch einmal";
        Restarted: Silent "restarted" = "the sensor was switched off and on, and sends with its stored period now: start the command again",
            "der Sensor war aus und sendet jetzt mit seiner gespeicherten Periode: Beginnen Sie noch einmal";
        NotFound: Silent "nothing-found" = "no sensor was found: check power, wiring and terminators, then switch the sensor off and on during `plumbline scan`, or try `plumbline scan --search`",
            "kein Sensor wurde gefunden: {NOT_FOUND_DE}", "no sensor was found: {NOT_FOUND}";
        NotRecognised(rate: Rates, ids: String, option: String): Silent "nothing-found" = "traffic{rate} ({ids}), no sensor recognised: switch the sensor off and on during `plumbline {option}scan`, or give its address with --id, --node, --mac or --address; if no other device is on the bus, try `plumbline {option}scan --search`",
            "Verkehr{rate} ({ids}), kein Sensor erkannt (Befehl: `plumbline {option}scan`): {NOT_FOUND_DE}",
            "traffic{rate} ({ids}), no sensor recognised (command: `plumbline {option}scan`): {NOT_FOUND}";
        NoOwnAddress: Bus "no-own-address" = "the tool has found no free J1939 address for itself: are all addresses from 128 to 247 in use?",
            "das Programm hat keine freie J1939-Adresse für sich gefunden: Werden alle Adressen von 128 bis 247 verwendet?";
        LongCode: Usage "too-long" = "a request has at most 7 bytes of data after its code",
            "eine Anfrage hat nach ihrem Code höchstens 7 Bytes Daten";
        LongRequest: Usage "too-long" = "an explicit request has at most four bytes of data",
            "eine explizite Anfrage hat höchstens vier Bytes Daten";
        BusFaults(count: usize): Refused "bus-faults" = "faults of the bus: {count}", "Fehler des Busses: {count}";
        Replacement(count: usize): Refused "different" = "the new sensor differs from the old one: {count}; the report lists the differences",
            "der neue Sensor unterscheidet sich vom alten: {count}; der Bericht nennt die Unterschiede";
        Different(differing: Differing, path: String): Refused "different" = "{differing} from {path}",
            "{differing} als in {path}";
    }
}

texts! {
    /// How many settings differ, before the word for "from".
    Differing {
        One = "1 setting differs", "1 Einstellung ist anders";
        Several(count: usize) = "{count} settings differ", "{count} Einstellungen sind anders";
    }
}

impl Differing {
    /// This number of settings.
    pub fn of(count: usize) -> Self {
        match count {
            1 => Self::One,
            count => Self::Several(count),
        }
    }
}

texts! {
    /// What a request is for.
    What {
        Name(name: String) = "{name}", "{name}";
        Read(name: String) = "to read {name}", "das Lesen von {name}";
        Write(name: String) = "to write {name}", "das Schreiben von {name}";
        Identity = "to read the identity", "das Lesen der Identität";
        Serial = "to read the serial number", "das Lesen der Seriennummer";
        DeviceType = "to read the device type", "das Lesen des Gerätetyps";
        Angles = "to send its angles", "das Senden der Winkel";
        Settings = "its old settings", "die alten Einstellungen";
        PacketRate = "the expected packet rate", "die Expected Packet Rate";
        Allocation = "the allocation", "die Allokation";
        Release = "the release", "die Freigabe";
        Request = "the request", "die Anfrage";
        Restart = "the restart", "den Neustart";
        Reset = "the reset", "das Rücksetzen";
        Save = "save", "das Speichern";
        Load = "load", "das Laden der Werkswerte";
        BitRate = "the bit rate", "die Bitrate";
        Store = "to store it", "das Speichern";
        NodeId = "the node-ID", "die Node-ID";
        Parameter = "a parameter", "einen Parameter";
        Assembly = "an assembly", "eine Assembly";
        CyclicMode = "cyclic mode", "den zyklischen Betrieb";
        TheAngles = "the angles", "die Winkel";
        Program = "the update", "das Update";
        Function = "the function", "die Funktion";
    }
}

texts! {
    /// What a user can do after a refusal.
    Next {
        List = "`plumbline parameters` lists the names and the permitted values", "Die Parameter zeigen die Namen und die erlaubten Werte";
        State = "It can store or be in operation: wait some seconds, stop its master, and repeat",
            "Vielleicht speichert er oder ist in Betrieb: Warten Sie einige Sekunden, halten Sie seinen Master an, und wiederholen Sie";
        Failed = "Repeat, and restart the sensor with `plumbline restart`; if it fails again, the sensor is faulty",
            "Wiederholen Sie, und starten Sie den Sensor neu; gelingt es wieder nicht, ist der Sensor defekt";
        Repeat = "Repeat; if it is refused again, `plumbline restart` restarts the sensor",
            "Wiederholen Sie; lehnt er wieder ab, starten Sie den Sensor neu";
        OtherRate = "The sensor does not have this bit rate: choose another one", "Der Sensor hat diese Bitrate nicht: Wählen Sie eine andere";
        SetRate = "Write the bit rate with `plumbline set`, and store it with `plumbline save`",
            "Setzen Sie die Bitrate bei den Parametern, und speichern Sie sie im Sensor";
    }
}

texts! {
    /// The addresses where nobody answers.
    Place {
        Nowhere = "", "";
        At(addresses: String) = " at {addresses}", " auf {addresses}";
    }
}

texts! {
    /// The bit rates at which nobody answers.
    Rates {
        Own = "", "";
        One(rate: &'static str) = " at {rate}", " bei {rate}";
        Any = " at any bit rate", " bei jeder Bitrate";
    }
}

texts! {
    /// Why a device has refused a request.
    Reason {
        Toggle = "toggle bit not alternated", "das Toggle-Bit hat nicht gewechselt";
        TimeOut = "time-out of the protocol", "Zeitüberschreitung des Protokolls";
        Command = "unknown command", "unbekannter Befehl";
        BlockSize = "the block size is not permitted", "die Blockgröße ist nicht erlaubt";
        SequenceNumber = "the sequence number is not permitted", "die Sequenznummer ist nicht erlaubt";
        Crc = "the CRC is wrong", "die CRC ist falsch";
        Access = "unsupported access", "nicht unterstützter Zugriff";
        WriteOnly = "the object can only be written", "das Objekt ist nur schreibbar";
        ReadOnly = "the object can only be read", "das Objekt ist nur lesbar";
        NoObject = "there is no such object", "dieses Objekt gibt es nicht";
        NotMappable = "the object cannot be mapped", "das Objekt lässt sich nicht mappen";
        TooManyMapped = "the mapping is too long for a PDO", "das Mapping ist zu lang für ein PDO";
        Hardware = "a hardware error", "ein Fehler der Hardware";
        Length = "the length does not match the type", "die Länge passt nicht zum Typ";
        TooLong = "the value is too long", "der Wert ist zu lang";
        TooShort = "the value is too short", "der Wert ist zu kurz";
        NoSubIndex = "there is no such sub-index", "diesen Subindex gibt es nicht";
        Value = "the value is not permitted", "der Wert ist nicht erlaubt";
        TooHigh = "the value is too high", "der Wert ist zu groß";
        TooLow = "the value is too low", "der Wert ist zu klein";
        Signature = "the value cannot be stored", "der Wert lässt sich nicht speichern";
        State = "not in the present state of the device", "nicht im jetzigen Zustand des Geräts";
        NoData = "there is no data", "es gibt keine Daten";
        Memory = "out of memory", "kein Speicher mehr";
        Together = "parameters do not fit each other", "die Parameter passen nicht zueinander";
        General = "general error", "allgemeiner Fehler";
        Resource = "the resource is not available", "die Ressource ist nicht verfügbar";
        Service = "there is no such service", "diesen Service gibt es nicht";
        Already = "already in this state", "schon in diesem Zustand";
        AttributeReadOnly = "the attribute can only be read", "das Attribut ist nur lesbar";
        Permission = "the permission is missing", "die Erlaubnis fehlt";
        TooLittle = "there is not enough data", "es sind zu wenige Daten";
        NoAttribute = "there is no such attribute", "dieses Attribut gibt es nicht";
        TooMuch = "there is too much data", "es sind zu viele Daten";
        Vendor = "a vendor specific error", "ein Fehler des Herstellers";
        Parameter = "a parameter of the service is not permitted", "ein Parameter des Service ist nicht erlaubt";
    }
}
