//! What the tool asks before it continues. The terminal and the page ask the same questions.

use crate::calibrate::host;
use crate::ops::NewRate;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};
use texts::{Text, texts};

texts! {
    /// A question with what the user must know to answer it. The page gets it as an object with the field `id`, and sends the object back as a
    /// yes: a yes is for this question with this data only. The last ones the page asks in dialogs of its own.
    #[derive(Serialize, Deserialize)]
    #[serde(tag = "id", rename_all = "kebab-case", deny_unknown_fields)]
    Question {
        Silent = "There is no traffic. Send requests to all addresses at all bit rates?",
            "Es gibt keinen Verkehr. Auf allen Adressen und Bitraten fragen?";
        AllRates = "There is no traffic at any bit rate. Send requests at all bit rates? At a wrong rate the requests destroy the messages of other devices.",
            "Auf keiner Bitrate gibt es Verkehr. Auf allen Bitraten fragen? Auf einer falschen Bitrate zerstören die Anfragen die Nachrichten anderer Geräte.";
        AllAddresses = "There is traffic, but no sensor was recognised. Send requests to all addresses? Other devices can interpret a request as a command.",
            "Es gibt Verkehr, aber kein Sensor wurde erkannt. Auf allen Adressen fragen? Andere Geräte können eine Anfrage als Befehl verstehen.";
        Delivered = "There is traffic, but no sensor was recognised. Send requests to the factory addresses? Other devices can interpret a request as a command.",
            "Es gibt Verkehr, aber kein Sensor wurde erkannt. Auf den Adressen wie geliefert fragen? Andere Geräte können eine Anfrage als Befehl verstehen.";
        More = "Search for more sensors? The tool sends requests to all other addresses. Other devices can interpret a request as a command.",
            "Nach weiteren Sensoren suchen? Das Programm fragt auf allen anderen Adressen. Andere Geräte können eine Anfrage als Befehl verstehen.";
        Likely {protocol: String, address: String} = "Frames look like those of a sensor ({protocol}, {address}). Send requests to it? Another device can interpret the request as a command.",
            "Frames sehen aus wie die eines Sensors ({protocol}, {address}). Ihn fragen? Ein anderes Gerät kann die Anfrage als Befehl verstehen.";
        TakePart {rate: Rate} = "The adapter has no listen-only mode. Allow it to take part in the bus at {rate} while the tool listens? It acknowledges the messages of other devices, and at a wrong bit rate it destroys them.",
            "Der Adapter hat keine Betriebsart, in der er nur hört. Darf er am Bus teilnehmen ({rate}), während das Programm hört? Er bestätigt die Nachrichten anderer Geräte, und auf einer falschen Bitrate zerstört er sie.";
        OtherProduct {told: String, article: String, version: Version, product: String} = "The sensor identifies itself as {told} (article {article}{version}). Use the tables of {product} anyway?",
            "Der Sensor nennt sich {told} (Artikel {article}{version}). Trotzdem die Tabellen von {product} verwenden?";
        WhichProduct {article: String, products: String, product: String} = "The sensor has the article {article}, which fits several products ({products}), and does not report its software version. Is it {product}?",
            "Der Sensor hat den Artikel {article}, der zu mehreren Produkten passt ({products}), und nennt seine Softwareversion nicht. Ist es {product}?";
        DataSheet {doubts: Doubts} = "The data sheet {doubts}. Use it anyway?",
            "Das Datenblatt passt nicht zum Gerät: {doubts}. Trotzdem verwenden?";
        Downgrade {file: String, own: String} = "The firmware of the sensor has version {own}, the file has the older version {file}. Install the older one?",
            "Das Programm des Sensors hat Version {own}, die Datei die ältere Version {file}. Die Datei trotzdem laden?";
        #[serde(skip)]
        Change {change: Change, sensor: String, angles: String} = "{change}? {sensor}; {angles}", "{change}? {sensor}; {angles}";
        #[serde(skip)]
        Period(own: u32) = "The sensor sends its angles already, with a period of {own} ms, and other devices can need them. Change the period until the command ends?",
            "Der Sensor sendet seine Winkel schon, mit der Periode {own} ms, und andere Geräte können sie brauchen. Die Periode ändern, bis der Befehl endet?";
        #[serde(skip)]
        Tpdo(number: u16) = "TPDO {number} of the operational node is on, although no message of it is received now, and other devices can need it. Change it until the command ends?",
            "TPDO {number} des Knotens in Betrieb ist ein, obwohl jetzt keine Nachricht von ihm kommt, und andere Geräte können es brauchen. Es ändern, bis der Befehl endet?";
        #[serde(skip)]
        NotCarried(names: String) = "The new sensor does not take {names}. Write the other settings?",
            "Der neue Sensor nimmt {names} nicht. Die übrigen Einstellungen schreiben?";
        Turn {angles: AtRest} = "{angles}. Turn the sensor by 180 deg about the vertical axis, on the same place. Is it turned and at rest?",
            "{angles}. Drehen Sie den Sensor um 180 Grad um die senkrechte Achse, auf derselben Stelle. Ist er gedreht und in Ruhe?";
        Align {sensor: String, angles: AtRest} = "Compensate the mounting offset? {sensor}; {angles}",
            "Den Versatz der Montage zu Null machen? {sensor}; {angles}";
        #[serde(skip)]
        Overwrite(path: String) = "{path} exists. Replace it?", "{path} gibt es schon. Ersetzen?";
        #[serde(skip)]
        OverwriteOther {path: String, file: String, own: String} = "{path} has the settings of another sensor (product and serial number {file}; this one is {own}). Replace it?",
            "{path} hat die Einstellungen eines anderen Sensors (Produkt und Seriennummer {file}; dieser ist {own}). Ersetzen?";
        #[serde(skip)]
        Calibrate(question: host::Question) = "{question}", "{question}";
    }
}

texts! {
    /// An angle at rest, in a question.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case", deny_unknown_fields)]
    Angle {
        First {name: String, angle: f64, spread: f64} = "{name} {angle:.2} deg, spread {spread:.2} deg",
            "{name} {angle:.2} deg, Spanne {spread:.2} deg";
        Both {name: String, first: f64, turned: f64, spread: f64, mounting: f64, surface: f64} = "{name} {first:.2} deg, turned {turned:.2} deg, spread {spread:.2} deg; mounting {mounting:.2} deg, surface {surface:.2} deg",
            "{name} {first:.2} deg, gedreht {turned:.2} deg, Spanne {spread:.2} deg; Montage {mounting:.2} deg, Fläche {surface:.2} deg";
    }
}

texts! {
    /// The bit rate of a bus, in a question.
    #[derive(Serialize, Deserialize)]
    #[serde(untagged)]
    Rate {
        Named(name: String) = "{name}", "{name}";
        Interface = "the bit rate of the interface", "die Bitrate der Schnittstelle";
    }
}

texts! {
    /// The software version of a sensor, in a question.
    #[derive(Serialize, Deserialize)]
    #[serde(untagged)]
    Version {
        Reported(version: String) = ", software version {version}", ", Softwareversion {version}";
        Unknown = "", "";
    }
}

texts! {
    /// A change of the sensor that needs a yes.
    Change {
        Zero = "Make the present position zero", "Die jetzige Lage zu Null machen";
        Teach = "Make the present position the reference frame", "Die jetzige Lage zum Bezugssystem machen";
        LoadFactory = "Load the factory values", "Die Werkswerte laden";
        LoadFactoryAndRestart(address: String, rate: &'static str) = "Load the factory values and restart the sensor (it then has {address} and {rate}; the other devices on the bus must have the same rate)",
            "Die Werkswerte laden und den Sensor neu starten (er hat dann {address} und {rate}; die anderen Geräte am Bus müssen dieselbe Bitrate haben)";
        Rate(new: NewRate) = "Change the bit rate to {new} (the other devices on the bus must have the same rate)",
            "Die Bitrate auf {new} ändern (die anderen Geräte am Bus müssen dieselbe Bitrate haben)";
        Restore(file: String, own: String) = "The file is of a sensor with another serial number ({file}, this one has {own}). Write its settings to this sensor",
            "Die Datei ist von einem Sensor mit einer anderen Seriennummer ({file}, dieser hat {own}). Ihre Einstellungen in diesen Sensor schreiben";
    }
}

/// Whether an answer is a yes, in English or in German. Anything else is a no.
pub fn is_yes(answer: &str) -> bool {
    let answer = answer.trim().to_lowercase();
    matches!(answer.as_str(), "y" | "yes" | "j" | "ja")
}

/// What differs between a data sheet and its device.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct Doubt {
    /// The name of the entry.
    pub what: String,
    /// The number in the data sheet, in hexadecimal.
    pub wanted: String,
    /// The number of the device; None: it cannot be read.
    pub own: Option<String>,
}

/// The names of questions for `--yes`.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum Name {
    /// All of them
    All,
    /// Requests at addresses and bit rates that are not known to be a sensor's
    Ask,
    /// An adapter without listen-only mode takes part in the bus
    Listen,
    /// The tables of another product than the sensor reports
    Product,
    /// The data sheet of another device
    DataSheet,
    /// Zero of the angles
    Zero,
    /// The reference frame
    Teach,
    /// The factory values
    LoadFactory,
    /// Another bit rate
    Rate,
    /// The settings of another sensor
    Restore,
    /// Cyclic messages that other devices can need
    Cyclic,
    /// A file that exists
    Overwrite,
}

impl Change {
    /// The name for `--yes`.
    pub const fn name(&self) -> Name {
        match self {
            Self::Zero => Name::Zero,
            Self::Teach => Name::Teach,
            Self::LoadFactory | Self::LoadFactoryAndRestart(..) => Name::LoadFactory,
            Self::Rate(_) => Name::Rate,
            Self::Restore(..) => Name::Restore,
        }
    }
}

impl Question {
    /// The name for `--yes`; None: only a user can answer it.
    pub const fn name(&self) -> Option<Name> {
        Some(match self {
            Self::Silent
            | Self::AllRates
            | Self::AllAddresses
            | Self::Delivered
            | Self::More
            | Self::Likely { .. } => Name::Ask,
            Self::TakePart { .. } => Name::Listen,
            Self::OtherProduct { .. } => Name::Product,
            Self::DataSheet { .. } => Name::DataSheet,
            Self::Change { change, .. } => change.name(),
            Self::Align { .. } => Name::Zero,
            Self::NotCarried(_) => Name::Restore,
            Self::Period(_) | Self::Tpdo(_) => Name::Cyclic,
            Self::Overwrite(_) | Self::OverwriteOther { .. } => Name::Overwrite,
            Self::WhichProduct { .. }
            | Self::Downgrade { .. }
            | Self::Turn { .. }
            | Self::Calibrate(_) => return None,
        })
    }
}

impl Name {
    /// Whether these names contain this one.
    pub fn is_in(self, names: &[Self]) -> bool {
        names.contains(&Self::All) || names.contains(&self)
    }
}

impl Display for Name {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let value = self.to_possible_value();
        f.write_str(value.as_ref().map_or("", |value| value.get_name()))
    }
}

/// All angles at rest.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(transparent)]
pub struct AtRest(pub Vec<Angle>);

impl Display for AtRest {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let texts: Vec<String> = self.0.iter().map(Angle::to_string).collect();
        f.write_str(&texts.join("; "))
    }
}

impl Text for AtRest {
    fn german(&self) -> String {
        let texts: Vec<String> = self.0.iter().map(Angle::german).collect();
        texts.join("; ")
    }
}

/// All that differs; as a text, in a sentence after "the data sheet".
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Doubts(pub Vec<Doubt>);

impl Display for Doubts {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let texts: Vec<String> = self.0.iter().map(Doubt::to_string).collect();
        f.write_str(&texts.join("; it "))
    }
}

impl Text for Doubts {
    fn german(&self) -> String {
        let texts = self.0.iter().map(|Doubt { what, wanted, own }| {
            let own = own.as_deref().unwrap_or("nicht lesbar");
            format!("{what} {wanted} im Datenblatt, {own} im Gerät")
        });
        texts.collect::<Vec<_>>().join("; ")
    }
}

impl Display for Doubt {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { what, wanted, own } = self;
        write!(f, "is for {what} {wanted}, but the device ")?;
        match own {
            Some(own) => write!(f, "reports {own}"),
            None => f.write_str("does not let it be read"),
        }
    }
}
