//! Errors of the command line, of names, and of what a product does not have.

use super::NumberError;
use crate::meaning::Named;
use crate::ops::NewRate;
use crate::question::Doubts;
use texts::{errors, texts};

/// The ports that there can be.
const PORTS: &str = "ports are slcan://HOST:PORT, slcan:/dev/ttyACM0, can0 (Linux), usb[:SERIAL], pcan[:USBBUS1] and demo:PRODUCT; `plumbline ports` lists those of this computer";
const PORTS_DE: &str = "Anschlüsse sind slcan://HOST:PORT, slcan:/dev/ttyACM0, can0 (Linux), usb[:SERIAL], pcan[:USBBUS1] und demo:PRODUCT; `plumbline ports` nennt die dieses Computers";

errors! {
    /// What is wrong with a request.
    RequestError {
        Usage(text: String): Usage "bad-usage" = "{text}", "{text}";
        Stopped: Stopped "stopped" = "stopped by Ctrl-C: start the command again to finish it",
            "angehalten: Beginnen Sie den Befehl noch einmal, um ihn zu beenden";
        UnknownPort(port: String): Usage "unknown-port" = "there is no port {port:?}: {PORTS}",
            "es gibt keinen Anschluss {port:?}: {PORTS_DE}";
        NoAdapter: Bus "not-open" = "there is no adapter", "es gibt keinen Adapter";
        Demonstration: Bus "adapter-lost" = "the demonstration does not start", "die Demonstration startet nicht";
        ListenRate: Bus "no-listen-only" = "the adapter has no listen-only mode: give the bit rate with --rate",
            "der Adapter kann nicht nur hören: Wählen Sie die Bitrate";
        LogListens: Bus "no-listen-only" = "the adapter has no listen-only mode, but `log` only listens: use another adapter",
            "der Adapter kann nicht nur hören, `log` hört aber nur: Verwenden Sie einen anderen Adapter";
        MayNotTakePart: Usage "no-listen-only" = "the adapter has no listen-only mode, so it was not opened: --yes lets it take part in the bus; with --id, --node, --mac or --address the tool sends requests to the sensor without listening first",
            "der Adapter kann nicht nur hören und wurde nicht geöffnet: Erlauben Sie ihm, am Bus teilzunehmen, oder geben Sie die Adresse des Sensors an";
        AllRefused: Bus "adapter-refused" = "the adapter refuses all bit rates: another program may have it open, or it is not an slcan adapter. Close the other program, or check --port",
            "der Adapter lehnt alle Bitraten ab: Vielleicht verwendet ihn ein anderes Programm, oder er ist kein slcan-Adapter. Schließen Sie das andere Programm, oder prüfen Sie den Anschluss";
        UnknownProduct(name: String, products: String, meant: Meant): Usage "unknown-product" = "there is no product {name:?}; the products are {products}{meant}",
            "es gibt kein Produkt {name:?}; die Produkte sind {products}{meant}";
        NoJ1939(name: String): Usage "unknown-product" = "{name} does not have J1939: ims360/j1939 has it",
            "{name} hat kein J1939: ims360/j1939 hat es";
        UnknownArticle(article: String): Usage "unknown-product" = "the article {article} is not in the catalogue: select a compatible product with --product NAME, or give its data sheet with --eds FILE",
            "der Artikel {article} ist nicht im Katalog: Wählen Sie ein Produkt, dem er gleicht, oder sein Datenblatt (EDS)";
        NotInCatalogue: Usage "unknown-product" = "an identity belongs to a product of the catalogue: give it with --product NAME, without --eds",
            "eine Identität gehört zu einem Produkt des Katalogs: Wählen Sie es ohne Datenblatt (EDS)";
        IdentityProduct: Usage "unknown-product" = "an identity belongs to one product: give the product with --product NAME",
            "eine Identität gehört zu einem Produkt: Wählen Sie das Produkt";
        StoreProduct: Usage "unknown-product" = "a store file belongs to one product: give the product with --product NAME",
            "eine Speicherdatei gehört zu einem Produkt: Geben Sie das Produkt mit --product NAME an";
        Several(article: String, names: String): Usage "ambiguous-product" = "the article {article} fits several products ({names}): choose one with --product NAME",
            "der Artikel {article} passt zu mehreren Produkten ({names}): Wählen Sie eines";
        ProductProtocol(product: &'static str, protocol: &'static str, own: &'static str): Usage "wrong-product" = "{product} uses {protocol}, but the sensor uses {own}: give another --product",
            "{product} spricht {protocol}, der Sensor aber {own}: Wählen Sie ein anderes Produkt";
        OtherProduct(own: String, product: &'static str): Usage "wrong-product" = "the sensor identifies itself as {own}, not {product}: leave out --product, or use --yes for the tables of {product}",
            "der Sensor nennt sich {own}, nicht {product}: Wählen Sie kein Produkt, oder bestätigen Sie die Tabellen von {product}";
        ImageProduct(file: String, product: &'static str): Usage "wrong-image" = "the file is for {file}, but the sensor is {product}: nothing has changed",
            "die Datei ist für {file}, aber der Sensor ist {product}: Nichts hat sich geändert";
        ImageHardware(file: String, own: String): Usage "wrong-image" = "the file is for another board or measuring element ({file}) than that of the sensor ({own}): nothing has changed",
            "die Datei ist für eine andere Platine oder ein anderes Messelement ({file}) als der Sensor ({own}): Nichts hat sich geändert";
        NoSuchSensor(product: String): Usage "wrong-image" = "there is no {product} on the bus: `plumbline scan` shows the sensors",
            "am Bus ist kein {product}: Prüfen Sie die Datei, und suchen Sie die Sensoren";
        RestartFirst: Usage "restart-first" = "the address or the bit rate of the sensor changes at its next start: `plumbline restart` first, then update it there; nothing has changed",
            "die Adresse oder die Bitrate des Sensors ändert sich beim nächsten Start: Starten Sie ihn zuerst neu, und aktualisieren Sie ihn dort; nichts hat sich geändert";
        DataSheet(doubts: Doubts): Usage "wrong-product" = "the data sheet {doubts}: give the right file, or --yes",
            "das Datenblatt passt nicht zum Gerät ({doubts}): Wählen Sie die richtige Datei, oder bestätigen Sie";
        BadId(id: String, why: Box<NumberError>): Usage "bad-value" = "--id {id}: {why}", "Identifier {id}: {why}";
        TooManyAddresses: Usage "too-many-addresses" = "give one of --id (GEMAC), --node (CANopen), --mac (DeviceNet) and --address (J1939)",
            "geben Sie nur eines an: Identifier (GEMAC), Node-ID (CANopen), MAC ID (DeviceNet) oder J1939-Adresse";
        AddressRange(option: &'static str, number: String, kind: &'static str, low: u8, high: u8): Usage "out-of-range" = "{option} {number}: a {kind} is {low} to {high}; `plumbline scan` shows the addresses of the sensors on the bus",
            "{option} {number}: {kind} ist {low} bis {high}; Sensoren suchen zeigt die Adressen der Sensoren am Bus";
        NotAsked: Usage "no-address" = "no request was sent, because other devices use the factory identifiers of the sensor: give its address with --id, --node, --mac or --address",
            "keine Anfrage wurde gesendet, weil andere Geräte die Identifier des Sensors wie geliefert verwenden: Geben Sie seine Adresse an";
        NotRecognised: Usage "no-address" = "there is traffic, but no sensor was recognised: give its address with --id, --node, --mac or --address, or try `plumbline scan`",
            "es gibt Verkehr, aber kein Sensor wurde erkannt: Geben Sie seine Adresse an, oder drücken Sie Sensoren suchen",
            "there is traffic, but no sensor was recognised: give its address, or press Find sensors";
        NodeId255: Usage "no-address" = "the node-ID is 255 after the restart, so the tool cannot read from the sensor: give it one with `plumbline node-id`",
            "die Node-ID ist nach dem Neustart 255, deshalb kann der Sensor nicht gelesen werden: Geben Sie ihm eine mit Node-ID";
        SeveralSensors(lines: String): Usage "several-sensors" = "several sensors answer: {lines}. Choose one with --id, --node, --mac or --address",
            "mehrere Sensoren antworten: {lines}. Wählen Sie einen mit seiner Adresse";
        TwinNodes(count: usize, address: String, serials: String): Usage "several-sensors" = "{count} sensors answer at {address}, with the serial numbers {serials}: connect one of them alone and give it another one (plumbline node-id)",
            "{count} Sensoren antworten auf {address}, mit den Seriennummern {serials}: Schließen Sie einen davon allein an, und geben Sie ihm eine andere (plumbline node-id)";
        Twins(count: usize, address: String, serials: String): Usage "several-sensors" = "{count} sensors answer at {address}, with the serial numbers {serials}: connect one of them alone and give it other identifiers (set-id, reply-id)",
            "{count} Sensoren antworten auf {address}, mit den Seriennummern {serials}: Schließen Sie einen davon allein an, und geben Sie ihm andere Identifier (set-id, reply-id)";
        TwinMacs(count: usize, mac: String, serials: String): Usage "several-sensors" = "{count} sensors have MAC ID {mac}, with the serial numbers {serials}: at most one of them answers, the others are silent with a red network LED. Switch a silent one on alone, and give it another MAC ID (plumbline mac)",
            "{count} Sensoren haben MAC ID {mac}, mit den Seriennummern {serials}: Höchstens einer antwortet, die anderen schweigen mit roter Netzwerk-LED. Schalten Sie einen, der schweigt, allein ein, und geben Sie ihm eine andere MAC ID (plumbline mac)";
        NoRate: Usage "no-rate" = "there is no traffic, so the bit rate is unknown: give it with --rate, or --yes sends requests at all bit rates",
            "es gibt keinen Verkehr, deshalb ist die Bitrate unbekannt: Wählen Sie die Bitrate, oder erlauben Sie Anfragen auf allen Bitraten";
        NoPort: Usage "no-port" = "no port: give --port slcan:/dev/ttyACM0, slcan://HOST:PORT, can0, pcan or demo:is2, or set PLUMBLINE_PORT; `plumbline ports` lists the ports of this computer",
            "kein Anschluss: Wählen Sie slcan:/dev/ttyACM0, slcan://HOST:PORT, can0, pcan oder demo:is2";
        NoIdentity: Usage "no-identity" = "a store file needs an identity: give --from FILE, or --from-sensor for that of the connected sensor",
            "eine Speicherdatei braucht eine Identität: Geben Sie --from FILE an, oder --from-sensor für die des Sensors";
        UnknownCommand(name: String, meant: Meant): Usage "unknown-command" = "there is no command {name}: `plumbline --help` lists them{meant}",
            "es gibt keinen Befehl {name}: `plumbline --help` nennt alle{meant}";
        UnknownName(product: &'static str, name: String, meant: Meant): Usage "unknown-name" = "{product} has no parameter {name:?}: `plumbline parameters` lists all names{meant}",
            "{product} hat keinen Parameter {name:?}{meant}";
        NoName: Usage "unknown-name" = "a name begins with a letter", "ein Name beginnt mit einem Buchstaben";
        AmbiguousName(name: String, names: String): Usage "ambiguous-name" = "{name:?} can be {names}: write more of the name",
            "{name:?} kann {names} sein: Schreiben Sie mehr vom Namen";
        NoAssignment(text: String): Usage "bad-assignment" = "{text:?} is no assignment: write NAME=VALUE, for example cyclic-time=250ms",
            "{text:?} ist keine Zuweisung: Schreiben Sie NAME=WERT, zum Beispiel cyclic-time=250ms";
        GivenTwice(name: String): Usage "given-twice" = "{name} is given twice: give it once", "{name} ist zweimal angegeben: Geben Sie es einmal an";
        NoFrame(path: String): Usage "bad-value" = "no frame of {path} passes --filter, --interface and the address: nothing was sent",
            "kein Frame von {path} ist von dieser Schnittstelle: Nichts wurde gesendet",
            "no frame of {path} is of this interface: nothing was sent";
        Interfaces(path: String, names: String): Usage "bad-value" = "{path} has frames of the interfaces {names}, which were several buses: give one of them with --interface; nothing was sent",
            "{path} hat Frames der Schnittstellen {names}, also von mehreren Bussen: Wählen Sie eine im Feld Schnittstelle; nichts wurde gesendet",
            "{path} has frames of the interfaces {names}, which were several buses: write one of them into the field Interface; nothing was sent";
        Seconds: Usage "bad-value" = "--seconds is a time of 0 to 1000000000 s", "--seconds ist eine Zeit von 0 bis 1000000000 s";
        NotReadable(name: String): Usage "bad-value" = "{name} is not a readable number", "{name} ist keine lesbare Zahl";
        NoAngles: Usage "no-angles" = "the data sheet does not say which values are angles: give names, `plumbline parameters` lists them",
            "das Datenblatt sagt nicht, welche Werte Winkel sind: Die Werte stehen bei den Parametern";
        NoIdentifier(product: &'static str, commands: String): Usage "not-offered" = "{product} has no identifier here: use `plumbline set`, {commands}",
            "{product} hat hier keinen Identifier: Setzen Sie die Adresse bei den Parametern ({commands})";
        NoNodeId(product: &'static str, commands: String): Usage "not-offered" = "{product} has no node-ID here: use `plumbline set`, {commands}",
            "{product} hat hier keine Node-ID: Setzen Sie die Adresse bei den Parametern ({commands})";
        NoMacId(product: &'static str, commands: String): Usage "not-offered" = "{product} has no MAC ID: use `plumbline set`, {commands}",
            "{product} hat keine MAC ID: Setzen Sie die Adresse bei den Parametern ({commands})";
        NoJ1939Address(product: &'static str, commands: String): Usage "not-offered" = "{product} has no J1939 address here: use `plumbline set`, {commands}",
            "{product} spricht hier kein J1939: Setzen Sie die Adresse bei den Parametern ({commands})";
        NoCommand(product: &'static str, what: &'static str): Usage "not-offered" = "{product} has no {what}: `plumbline parameters` lists what it has",
            "{product} hat kein {what}: Die Parameter zeigen, was es hat";
        NoAxis(product: &'static str, axes: String): Usage "no-axis" = "{product} has no such axis: the axes are {axes}",
            "{product} hat diese Achse nicht: Die Achsen sind {axes}";
        OnlyTogether(product: &'static str, what: &'static str): Usage "no-axis" = "{product} has no such axis: both axes together: `plumbline {what}`",
            "{product} hat diese Achse nicht: beide Achsen zusammen: {what}";
        NotDescribed: Usage "not-offered" = "a data sheet does not describe this command: use `plumbline set` with the names that `plumbline parameters` lists",
            "ein Datenblatt beschreibt diesen Befehl nicht: Setzen Sie die Werte bei den Parametern";
        NoRateParameter: Usage "not-offered" = "J1939 has no parameter with the bit rate", "J1939 hat keinen Parameter mit der Bitrate";
        NoSave: Usage "not-offered" = "the device has no object that stores its parameters (1010h)",
            "das Gerät hat kein Objekt, das seine Parameter speichert (1010h)";
        J1939Save: Usage "not-offered" = "J1939 has no command that stores its parameters", "J1939 hat keinen Befehl, der die Parameter speichert";
        J1939Load: Usage "not-offered" = "J1939 has no command that loads its factory values", "J1939 hat keinen Befehl, der die Werkswerte lädt";
        NoSuchRate(product: &'static str, rate: NewRate, rates: Named): Usage "out-of-range" = "{product} does not have {rate}; it has {rates}",
            "{product} hat {rate} nicht; es hat {rates}";
        NotConfirmed(sensor: String, name: String): Usage "not-confirmed" = "nothing has changed ({sensor}): --yes={name} answers the question",
            "nichts hat sich geändert ({sensor}): Die Frage {name} wurde nicht bestätigt";
        NotTurned(sensor: String): Usage "not-confirmed" = "nothing has changed ({sensor}): the sensor must be turned, so only a user can answer the question",
            "nichts hat sich geändert ({sensor}): Der Sensor muss gedreht werden, deshalb kann nur ein Benutzer die Frage beantworten";
        NoOffset(product: &'static str): Usage "not-offered" = "{product} has no zero offset as a number, only the present position can become zero: bring it into the position that is to be zero, then `plumbline zero`",
            "{product} hat keinen Nullpunkt als Zahl, nur die jetzige Lage kann Null werden: Bringen Sie es in diese Lage, und nullen Sie dort";
        PeriodNotConfirmed(own: u32): Usage "not-confirmed" = "nothing has changed: --every {own} keeps the period, --yes=cyclic answers the question",
            "nichts hat sich geändert: --every {own} behält die Periode, --yes=cyclic beantwortet die Frage";
        TpdoNotConfirmed: Usage "not-confirmed" = "nothing has changed: --yes=cyclic answers the question",
            "nichts hat sich geändert: --yes=cyclic beantwortet die Frage";
        BadRequest(request: String): Usage "bad-request" = "{request:?} is not a valid request: use bytes like 0300 (GEMAC), INDEX:SUB like 1018:1 or 6000:0=0A00 (CANopen), 0E650172 (DeviceNet), FEEB (J1939)",
            "{request:?} ist keine gültige Anfrage: Verwenden Sie Bytes wie 0300 (GEMAC), INDEX:SUB wie 1018:1 oder 6000:0=0A00 (CANopen), 0E650172 (DeviceNet), FEEB (J1939)";
        NoSerial: Usage "no-serial" = "the sensor does not report a serial number, so it cannot have a name on this computer",
            "der Sensor nennt keine Seriennummer, deshalb kann er auf diesem Computer keinen Namen haben";
        BadLabel(start: String, longest: usize): Usage "bad-value" = "the name {start:?} is not permitted: choose one of 1 to {longest} characters on one line",
            "der Name {start:?} ist nicht erlaubt: Wählen Sie einen von 1 bis {longest} Zeichen in einer Zeile";
    }
}

texts! {
    /// The name that a user has probably meant, at the end of a text.
    Meant {
        Nothing = "", "";
        Name(name: String) = ". Did you mean {name}?", ". Meinten Sie {name}?";
    }
}
