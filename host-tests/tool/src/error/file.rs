//! Errors of files.

use super::{Error, NumberError};
use bench::file::Unfit;
use texts::{errors, texts};

errors! {
    /// A file that cannot be read or written, or has the wrong content.
    FileError {
        BackupUnread(path: String, reason: String): Bus "no-file" = "cannot read {path} ({reason}): `plumbline backup` writes such a file",
            "{path} lässt sich nicht lesen ({reason}): `plumbline backup` schreibt eine solche Datei";
        Backup(path: String, why: Fault): Usage "bad-file" = "{path} is not valid: {why}; nothing was written",
            "{path} ist nicht gültig: {why}; nichts wurde geschrieben";
        PageBackup(why: Fault): Usage "bad-file" = "the file is not valid: {why}; `plumbline backup` writes a valid one",
            "die Datei ist nicht gültig: {why}; Sensor in Datei macht eine gültige";
        PageTooLong: Usage "bad-file" = "the file is not valid: it is too long", "die Datei ist nicht gültig: Sie ist zu lang";
        ImageUnread(path: String, reason: String): Bus "no-file" = "cannot read {path} ({reason}): `plumbline image` writes such a file",
            "{path} lässt sich nicht lesen ({reason}): `plumbline image` schreibt eine solche Datei";
        Image(path: String, why: Fault): Usage "bad-file" = "{path} is not valid: {why}", "{path} ist nicht gültig: {why}";
        KeyUnread(path: String, reason: String): Bus "no-file" = "cannot read {path} ({reason}): `plumbline key new` makes a key",
            "{path} lässt sich nicht lesen ({reason}): `plumbline key new` macht einen Schlüssel";
        Key(path: String, why: Fault): Usage "bad-file" = "{path} is not valid: {why}", "{path} ist nicht gültig: {why}";
        KeyExists(path: String): Usage "file-exists" = "{path} exists already, and a key is never replaced: choose another name",
            "{path} gibt es schon, und ein Schlüssel wird nie ersetzt: Wählen Sie einen anderen Namen";
        KeyUsedUp(path: String): Usage "key-used-up" = "the key in {path} has no signatures left: make another one with `plumbline key new`, and program it into the sensors with a probe",
            "der Schlüssel in {path} hat keine Unterschriften mehr: Machen Sie einen anderen mit `plumbline key new`, und programmieren Sie ihn mit einem Debugger in die Sensoren";
        Fault(why: Fault): Usage "bad-file" = "{why}", "{why}";
        Unwritten(path: String, reason: String): Bus "no-file" = "cannot write {path} ({reason}): choose another file or folder",
            "{path} lässt sich nicht schreiben ({reason}): Wählen Sie eine andere Datei oder einen anderen Ordner";
        OutputUnwritten(path: String, reason: String): Bus "no-file" = "cannot write {path} ({reason})",
            "{path} lässt sich nicht schreiben ({reason})";
        FolderUnwritten(path: String, reason: String): Bus "no-file" = "cannot write {path} ({reason}): choose another folder",
            "{path} lässt sich nicht schreiben ({reason}): Wählen Sie einen anderen Ordner";
        Store(why: String): Bus "no-file" = "{why}", "die Speicherdatei: {why}";
        Closed(reason: String): Bus "output-closed" = "cannot write the output: {reason}", "die Ausgabe lässt sich nicht schreiben: {reason}";
        NoOutput(reason: String): Bus "no-output" = "cannot write the output: {reason}", "die Ausgabe lässt sich nicht schreiben: {reason}";
        LogUnread(path: String, reason: String): Bus "no-file" = "cannot read {path} ({reason}): `plumbline log` writes such a file",
            "{path} lässt sich nicht lesen ({reason}): `plumbline log` schreibt eine solche Datei";
        NoLog(path: String): Usage "bad-file" = "{path} has no line of `candump -L`, for example (0.125000) can0 18A#0102",
            "{path} hat keine Zeile von `candump -L`, zum Beispiel (0.125000) can0 18A#0102";
        ListUnread(path: String, reason: String): Bus "no-file" = "cannot read {path} ({reason}): `plumbline send` takes a list of frames (TOML), or frames as 181#0102",
            "{path} lässt sich nicht lesen ({reason}): `plumbline send` nimmt eine Liste von Frames (TOML) oder Frames wie 181#0102";
        List(path: String, why: Fault): Usage "bad-file" = "{path} is not a list of frames: {why}. A list has, for each frame, [[send]] with frame = \"181#0102\" and, for a periodic one, every = 100 (ms); nothing was sent",
            "{path} ist keine Liste von Frames: {why}. Eine Liste hat für jeden Frame [[send]] mit frame = \"181#0102\" und, wenn er periodisch ist, every = 100 (ms); nichts wurde gesendet";
        OldUnread(path: String, reason: String): Bus "no-file" = "cannot read {path} ({reason}): `plumbline replace read` writes such a file of the old sensor",
            "{path} lässt sich nicht lesen ({reason}): `plumbline replace read` schreibt eine solche Datei des alten Sensors";
        PlanUnread(path: String, reason: String): Bus "no-file" = "cannot read {path} ({reason}): `plumbline commission` takes a plan (TOML) with [[sensor]], name, product and [sensor.parameters]",
            "{path} lässt sich nicht lesen ({reason}): `plumbline commission` nimmt einen Plan (TOML) mit [[sensor]], name, product und [sensor.parameters]";
        Plan(path: String, line: usize, why: Fault): Usage "bad-file" = "{path} line {line}: {why}; nothing was sent", "{path} Zeile {line}: {why}; nichts wurde gesendet";
        State(path: String, why: Fault): Usage "bad-file" = "{path}, the state of the commissioning: {why}; nothing was sent. Without this file the commissioning begins again",
            "{path}, der Stand der Inbetriebnahme: {why}; nichts wurde gesendet. Ohne diese Datei beginnt die Inbetriebnahme von vorn";
        Dcf(path: String): Usage "bad-file" = "{path} is the name of the DCF: give the backup another name, for example crane.toml",
            "{path} ist der Name der DCF: Geben Sie der Sicherung einen anderen Namen, zum Beispiel kran.toml";
        Exists(path: String): Usage "file-exists" = "{path} exists already: choose another name, or replace it with --yes=overwrite",
            "{path} gibt es schon: Wählen Sie einen anderen Namen, oder ersetzen Sie sie mit --yes=overwrite";
        Twice(path: String): Usage "same-file" = "the command names {path} twice, and would overwrite it: choose another name",
            "der Befehl nennt {path} zweimal und würde sie überschreiben: Wählen Sie einen anderen Namen";
        OtherProduct(wanted: &'static str, own: &'static str): Usage "wrong-file" = "the file belongs to {wanted}, but the sensor is {own}: nothing has changed. Take a file of this sensor, or choose another sensor; `plumbline scan` shows them",
            "die Datei gehört zu {wanted}, der Sensor ist aber {own}: Nichts hat sich geändert. Nehmen Sie eine Datei dieses Sensors, oder wählen Sie einen anderen Sensor",
            "the file belongs to {wanted}, but the sensor is {own}: nothing has changed. Take a file of this sensor, or choose another sensor";
        EdsUnread(path: String, reason: String): Bus "no-file" = "cannot read {path} ({reason}): --eds takes the EDS file of the maker of the device",
            "{path} lässt sich nicht lesen ({reason}): --eds nimmt die EDS-Datei des Herstellers des Geräts";
        Eds(path: String, why: Fault): Usage "bad-file" = "{path} is not a data sheet (EDS): {why}; nothing was written",
            "{path} ist kein Datenblatt (EDS): {why}; nichts wurde geschrieben";
        PageEds(name: String, why: Fault): Usage "bad-file" = "{name} is not a data sheet (EDS): {why}; choose the EDS file of the maker of the device",
            "{name} ist kein Datenblatt (EDS): {why}; wählen Sie die EDS-Datei des Herstellers des Geräts";
        DatabaseUnread(path: String, reason: String): Bus "no-file" = "cannot read {path} ({reason}): --dbc takes the CAN database (DBC) of a device",
            "{path} lässt sich nicht lesen ({reason}): --dbc nimmt die CAN-Datenbank (DBC) eines Geräts";
        Database(path: String, line: usize): Usage "bad-file" = "{path} is not a CAN database (DBC): line {line} is not valid, or has no message",
            "{path} ist keine CAN-Datenbank (DBC): Zeile {line} ist nicht gültig oder hat keine Nachricht";
        IdentityUnread(path: String, reason: String): Bus "no-file" = "cannot read {path} ({reason}): --from takes an EDS, a DCF or a sheet of values",
            "{path} lässt sich nicht lesen ({reason}): --from nimmt eine EDS, eine DCF oder ein Blatt mit Werten";
        Identity(path: String, why: Fault): Usage "bad-file" = "{path}: {why}; nothing was written", "{path}: {why}; nichts wurde geschrieben";
        ProgramUnread(path: String, reason: String): Bus "no-file" = "cannot read {path} ({reason}): it must be the ELF file of a program",
            "{path} lässt sich nicht lesen ({reason}): Es muss die ELF-Datei eines Programms sein";
        Bootloader(path: String, why: Fault): Usage "bad-file" = "{path} is not valid: {why}", "{path} ist nicht gültig: {why}";
        Program(path: String, why: Fault): Usage "bad-file" = "{path} is not a program for an update: {why}", "{path} ist kein Programm für ein Update: {why}";
        LabelsUnread(path: String, reason: String): Bus "no-file" = "cannot read the names in {path} ({reason}): repair or delete it",
            "die Namen in {path} lassen sich nicht lesen ({reason}): Reparieren oder löschen Sie die Datei";
        NoTable(maker: String): Bus "no-file" = "the file of the names has no table {maker}: repair or delete it",
            "die Datei der Namen hat keine Tabelle {maker}: Reparieren oder löschen Sie sie";
        NoFolder: Bus "no-file" = "this computer has no folder for settings of the user: give one with --config",
            "dieser Computer hat keinen Ordner für Einstellungen des Benutzers: Geben Sie einen mit --config an";
        FolderUnmade(path: String, reason: String): Bus "no-file" = "cannot create the folder {path} ({reason}): choose another one with --config",
            "der Ordner {path} lässt sich nicht anlegen ({reason}): Wählen Sie einen anderen mit --config";
    }
}

texts! {
    /// What is wrong with the content of a file.
    Fault {
        Reason(text: String) = "{text}", "{text}";
        NotRegular = "it is not a regular file", "sie ist keine gewöhnliche Datei";
        TooLong = "it is too long", "sie ist zu lang";
        NoText = "it is not a text in UTF-8 or UTF-16", "sie ist kein Text in UTF-8 oder UTF-16";
        LongerThan1MiB = "it is longer than 1 MiB", "sie ist länger als 1 MiB";
        NoElf(reason: String) = "it is not an ELF file of 32 bits, or it is damaged ({reason})", "sie ist keine ELF-Datei mit 32 Bit, oder sie ist beschädigt ({reason})";
        OtherMachine = "it is for another processor, not for ARM", "sie ist für einen anderen Prozessor, nicht für ARM";
        NoFirmware = "it does not name its board and its product: it is no firmware of Plumbline", "sie nennt ihre Platine und ihr Produkt nicht: Sie ist keine Firmware von Plumbline";
        NoBootloader(board: String) = "it is for the board {board}, which has no bootloader", "sie ist für die Platine {board}, die keinen Bootloader hat";
        OtherBootloader(board: &'static str) = "it is not a bootloader for the board {board}: `cargo build-{board} --bin bootloader` makes it", "sie ist kein Bootloader für die Platine {board}: `cargo build-{board} --bin bootloader` macht ihn";
        NotBehindBootloader = "it is not built with --features behind-bootloader", "sie ist nicht mit --features behind-bootloader gebaut";
        TooLargeForSlot(size: usize) = "it is larger than the {size} bytes behind the bootloader", "sie ist größer als die {size} Bytes hinter dem Bootloader";
        NoImage = "it is no image file: `plumbline image` makes one from an ELF file", "sie ist keine Image-Datei: `plumbline image` macht eine aus einer ELF-Datei";
        DamagedImage = "it is damaged", "sie ist beschädigt";
        NoKey = "it is no private key: `plumbline key new` makes one", "sie ist kein privater Schlüssel: `plumbline key new` macht einen";
        DamagedKey = "identifier, seed and root do not belong together", "identifier, seed und root gehören nicht zusammen";
        OtherBoard(number: u16) = "it is for the board number {number}, which this program does not know", "sie ist für die Platine Nummer {number}, die dieses Programm nicht kennt";
        NoSection(name: String) = "it has no section [{name}]", "sie hat keinen Abschnitt [{name}]";
        NoProduct = "it names no product", "sie nennt kein Produkt";
        Product(error: Box<Error>) = "{error}; a device with a data sheet needs --eds", "{error}; für ein Gerät mit Datenblatt öffnen Sie zuerst das Datenblatt (EDS)";
        NodeId = "its node-id is not from 1 to 127", "ihre Node-ID ist nicht von 1 bis 127";
        NoQuotes(name: String) = "{name:?} has no value in quotes", "{name:?} hat keinen Wert in Anführungszeichen";
        EmptyPlan = "it has no sensor: write [[sensor]] with name and product", "er hat keinen Sensor: Schreiben Sie [[sensor]] mit name und product";
        NameTwice(name: String) = "the name {name} is in the plan twice", "der Name {name} kommt im Plan zweimal vor";
        SerialTwice(serial: u32) = "the serial number {serial} is in the plan twice", "die Seriennummer {serial} kommt im Plan zweimal vor";
        AddressTwice(other: String) = "this sensor gets the same address as {other}: give it another one, or write alone = true at the top if each sensor is switched off before the next one is switched on",
            "dieser Sensor bekommt dieselbe Adresse wie {other}: Geben Sie ihm eine andere, oder schreiben Sie oben alone = true, wenn jeder Sensor ausgeschaltet wird, bevor der nächste eingeschaltet wird";
        AddressDelivered(other: String) = "{other}, which is before this sensor, has the factory address of this sensor: give {other} another address or put it last, or write alone = true at the top",
            "{other} steht davor und hat die Adresse, die dieser Sensor bei der Lieferung hat: Geben Sie {other} eine andere, oder stellen Sie ihn ans Ende, oder schreiben Sie oben alone = true";
        IdentifierTwice(other: String, name: String, id: String) = "{id} is the {name} of {other}, which is before this sensor: this sensor needs other identifiers, also as factory default; or write alone = true at the top if each sensor is switched off before the next one is switched on",
            "{id} ist {name} von {other}, der davor steht: Dieser Sensor braucht andere Identifier, auch bei der Lieferung; oder schreiben Sie oben alone = true, wenn jeder Sensor ausgeschaltet wird, bevor der nächste eingeschaltet wird";
        RateOnBus(name: String) = "{name} gets another bit rate than the bus, which it shares with other sensors: write alone = true at the top and switch each sensor off before the next one is switched on",
            "{name} bekommt eine andere Bitrate als der Bus, an dem auch andere Sensoren sind: Schreiben Sie oben alone = true, und schalten Sie jeden Sensor aus, bevor der nächste eingeschaltet wird";
        ZeroTwice(name: String) = "zero = true sets {name} too: leave out one of both", "zero = true setzt {name} auch: Lassen Sie eines von beiden weg";
        NoFastscan(product: &'static str) = "{product} has no fastscan by LSS: leave out find, and switch the sensors on one after the other",
            "{product} hat keinen Fastscan durch LSS: Lassen Sie find weg, und schalten Sie die Sensoren nacheinander ein";
        FastscanAddress(name: String) = "{name}, which is found by fastscan, keeps the factory node-ID: give it another node-id",
            "{name} wird durch Fastscan gefunden und behält die Node-ID der Lieferung: Geben Sie ihm eine andere node-id";
        FastscanJ1939(name: String) = "{name}, which is found by fastscan, needs a node-ID, and has none in J1939: leave out find, or can-protocol",
            "{name} wird durch Fastscan gefunden und braucht eine Node-ID, die es in J1939 nicht gibt: Lassen Sie find oder can-protocol weg";
        NoZero(product: &'static str) = "{product} cannot make its position zero", "{product} kann seine Lage nicht zu Null machen";
        ChangedPlan(name: String) = "the plan of {name}, which is done, was changed: give it its old plan or another name",
            "der Plan von {name}, der fertig ist, wurde geändert: Geben Sie ihm den alten Plan oder einen anderen Namen";
        Value(why: Box<NumberError>) = "{why}", "{why}";
        LongLine(line: usize) = "line {line} is too long", "Zeile {line} ist zu lang";
        BadLine(line: usize) = "line {line} is not a valid line of an EDS", "Zeile {line} ist keine gültige Zeile einer EDS";
        OpenQuote(line: usize) = "line {line} has an open quotation mark", "Zeile {line} hat ein offenes Anführungszeichen";
        OpenBracket(line: usize) = "line {line} has an open bracket, or no name in it", "Zeile {line} hat eine offene Klammer oder keinen Namen darin";
        NoSemicolon(line: usize) = "line {line} has no semicolon at the end of an entry", "Zeile {line} hat am Ende eines Eintrags kein Semikolon";
        NoPart(line: usize) = "line {line} is no part of the entry, or has no comma at its end", "Zeile {line} ist kein Teil des Eintrags oder hat am Ende kein Komma";
        SectionTwice(line: usize, name: String) = "line {line} has the section [{name}] again", "Zeile {line} hat den Abschnitt [{name}] noch einmal";
        NoEntryLine(line: usize) = "line {line} is no entry of an EDS", "Zeile {line} ist kein Eintrag einer EDS";
        EndsBefore(end: usize, line: usize) = "line {end} ends an entry, and line {line} is no part of another one: remove the line or the semicolon that is too much",
            "Zeile {end} beendet einen Eintrag, und Zeile {line} ist kein Teil eines anderen: Entfernen Sie die Zeile oder das Semikolon, das zu viel ist";
        OnlyCommas(line: usize, count: usize) = "line {line} has only commas, and its entry has not the number of fields of an EDS ({count}): remove the line, or complete the fields",
            "Zeile {line} hat nur Kommas, und ihr Eintrag hat nicht die Anzahl der Felder einer EDS ({count}): Entfernen Sie die Zeile, oder vervollständigen Sie die Felder";
        NoEnd(line: usize, entry: String) = "line {line}: the entry {entry} has no end", "Zeile {line}: Der Eintrag {entry} hat kein Ende";
        NoEntry = "it has no entry that can be read or written", "es hat keinen Eintrag, der gelesen oder geschrieben werden kann";
        TooMany(most: usize) = "it has more than {most} entries", "es hat mehr als {most} Einträge";
        TooManyFiles(most: usize) = "this program has read {most} different data sheets, which is the maximum: start it again",
            "dieses Programm hat {most} verschiedene Datenblätter gelesen, mehr geht nicht: Starten Sie es neu";
        NoDataSheet(product: &'static str) = "{product} has no data sheet: give a sheet of values with article, revision or serial",
            "{product} hat kein Datenblatt: Geben Sie ein Blatt mit Werten an, mit article, revision oder serial";
        OfProtocol(protocol: &'static str, product: &'static str, own: &'static str) = "it describes a {protocol} device, but {product} uses {own}",
            "es gehört zu einem {protocol}-Gerät, {product} spricht aber {own}";
        NoIdentity = "it has no identity", "es hat keine Identität";
        NoNumberIn(key: &'static str, text: String, section: &'static str) = "{key} = {text} in [{section}] is no number", "{key} = {text} in [{section}] ist keine Zahl";
        NoNumber(key: &'static str, text: String) = "{key} = {text} is no number", "{key} = {text} ist keine Zahl";
    }
}

impl From<Unfit> for Fault {
    fn from(unfit: Unfit) -> Self {
        match unfit {
            Unfit::NotRegular => Self::NotRegular,
            Unfit::TooLong => Self::TooLong,
            Unfit::NoText => Self::NoText,
        }
    }
}

impl From<NumberError> for Fault {
    fn from(why: NumberError) -> Self {
        Self::Value(Box::new(why))
    }
}

/// The sentence of another library.
impl From<String> for Fault {
    fn from(text: String) -> Self {
        Self::Reason(text)
    }
}
