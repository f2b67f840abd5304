//! Why a command failed: an exit code, a code for programs, and one sentence for people that names the next step.

mod broker;
mod calibration;
mod file;
mod number;
mod page;
mod request;
mod sensor;

pub use broker::BrokerError;
pub use calibration::CalibrationError;
pub use file::{Fault, FileError};
pub use number::NumberError;
pub use page::{BadRequest, Forbidden, PageError};
pub use request::{Meant, RequestError};
pub use sensor::{Differing, Next, Place, Rates, Reason, Refusal, SensorError, Silence, What};

use crate::note::Note;
use crate::question::Question;
use adapter::AdapterError;
use adapter::unread::Unread;
use serde_json::{Value, json};
use std::fmt::{self, Display, Formatter};
use texts::{Cause, Kind, Text, texts};

/// The error of an operation, with its subject.
#[derive(Clone, PartialEq, Debug)]
pub enum Error {
    /// An adapter or its port.
    Adapter(AdapterError),
    /// A bridge to other programs.
    Broker(BrokerError),
    /// A unit that is calibrated.
    Calibration(CalibrationError),
    /// A file.
    File(FileError),
    /// The text of a value.
    Number(NumberError),
    /// The server of the page.
    Page(PageError),
    /// A request that the sensor has refused.
    Refused(Refusal),
    /// The command line.
    Request(RequestError),
    /// A sensor that is not as it should be.
    Sensor(SensorError),
    /// No answer in time.
    Silent(Silence),
    /// The page must answer one of these questions, and give the request again. A terminal asks at once.
    Asks(Asks),
    /// The document of the command is printed, so this error is not a second document.
    AfterDocument(Box<Error>),
    /// Another error with what follows from it.
    Explained(Box<Explained>),
}

/// The questions that the page must answer.
#[derive(Clone, PartialEq, Debug)]
pub struct Asks(pub Vec<Question>);

/// Another error with what follows from it.
#[derive(Clone, PartialEq, Debug)]
pub struct Explained {
    error: Error,
    why: Why,
}

texts! {
    /// What follows from an error.
    Why {
        NotTaken(error: Error) = "the present position was not taken: the sensor has no valid angle now (its accelerometer clips, fails or gives no values), or it cannot use this position; {error}",
            "die jetzige Lage wurde nicht übernommen: Der Sensor hat jetzt keinen gültigen Winkel (sein Beschleunigungsmesser ist übersteuert, gestört oder gibt keine Werte), oder er kann diese Lage nicht verwenden; {error}";
        NotRestored(error: Error, name: String, value: String, raw: u32) = "{error}; the tool could not restore {name}, which was {value}: `plumbline set {name}=raw:{raw}`, or switch the sensor off and on",
            "{error}; {name} konnte nicht zurückgesetzt werden und war {value} (raw:{raw}): Setzen Sie {name}, oder schalten Sie den Sensor aus und ein",
            "{error}; the tool could not restore {name}, which was {value} (raw:{raw}): set {name}, or switch the sensor off and on";
        Remembered(error: Error) = "{error}. Bit rate and address can be those of the last command: give them, or find the sensor with `plumbline scan`",
            "{error}. Bitrate und Adresse können die des letzten Befehls sein: Geben Sie sie an, oder suchen Sie den Sensor mit `plumbline scan`";
        NotChanged(error: Error) = "{error}; nothing has changed: choose a rate that the adapter has",
            "{error}; nichts hat sich geändert: Wählen Sie eine Bitrate, die der Adapter hat";
        Interrupted(error: Error, count: usize, total: usize, kept: Kept) = "{error}. The restore was interrupted: {count} of {total} settings are written{kept}. Check power and wiring, then repeat the same command",
            "{error}. Die Wiederherstellung ist unterbrochen: {count} von {total} Einstellungen sind geschrieben{kept}. Prüfen Sie Versorgung und Verdrahtung, und wiederholen Sie denselben Befehl";
        Unread(told: Note) = "no answer was read: {told}", "keine Antwort wurde gelesen: {told}";
    }
}

texts! {
    /// What the sensor has of the settings of an interrupted restore.
    Kept {
        Written = ", and the sensor keeps them", ", und der Sensor behält sie";
        NotStored = ", but not stored, so a sensor that was switched off has its old ones", ", aber nicht gespeichert, deshalb hat ein Sensor, der aus war, seine alten";
    }
}

impl Error {
    /// A reference to what has failed.
    fn cause(&self) -> &dyn Cause {
        match self {
            Self::Adapter(own) => own,
            Self::Broker(own) => own,
            Self::Calibration(own) => own,
            Self::File(own) => own,
            Self::Number(own) => own,
            Self::Page(own) => own,
            Self::Refused(own) => own,
            Self::Request(own) => own,
            Self::Sensor(own) => own,
            Self::Silent(own) => own,
            Self::Asks(own) => own,
            Self::AfterDocument(own) => own.cause(),
            Self::Explained(own) => &**own,
        }
    }

    /// Who or what has failed.
    pub fn kind(&self) -> Kind {
        self.cause().kind()
    }

    /// A short code for programs, for example `out-of-range`.
    pub fn code(&self) -> &'static str {
        self.cause().code()
    }

    /// Whether the adapter has no listen-only mode.
    pub fn lacks_listen_only(&self) -> bool {
        use AdapterError::{KindListens, NoListenOnly, NotListening};
        let is = |own: &AdapterError| {
            matches!(own, NoListenOnly(_) | KindListens(..) | NotListening(..))
        };
        matches!(self, Self::Adapter(own) if is(own))
    }

    /// Whether the adapter does not have the bit rate.
    pub fn is_rate_refused(&self) -> bool {
        matches!(
            self,
            Self::Adapter(AdapterError::NoTiming(..) | AdapterError::RateRefused(..))
        )
    }

    /// The user has stopped the command.
    pub fn is_stopped(&self) -> bool {
        self.kind() == Kind::Stopped
    }

    /// The questions that the page must answer first.
    pub fn questions(&self) -> &[Question] {
        match self {
            Self::Asks(Asks(questions)) => questions,
            _ => &[],
        }
    }

    /// The same after the document of the command was printed.
    pub fn after_document(self) -> Self {
        Self::AfterDocument(Box::new(self))
    }

    /// The same with what follows from it.
    pub fn explained(self, why: impl FnOnce(Self) -> Why) -> Self {
        let why = why(self.clone());
        Self::Explained(Box::new(Explained { error: self, why }))
    }

    /// The same with what the adapter says and the tool cannot read, if nobody answers: the answers can be among it.
    pub fn with_unread(self, unread: &Unread) -> Self {
        match (Note::unread(unread), self.kind()) {
            (Some(told), Kind::Silent) => self.explained(|_| Why::Unread(told)),
            _ => self,
        }
    }

    /// The document that `--json` prints.
    pub fn json(&self) -> Value {
        let mut error = json!({"code": self.code(), "message": self.to_string()});
        if let Self::Asks(Asks(questions)) = self {
            error["questions"] = json!(questions);
        }
        json!({"error": error})
    }
}

impl std::error::Error for Error {}

impl Display for Error {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.cause().fmt(f)
    }
}

impl Text for Error {
    fn german(&self) -> String {
        self.cause().german()
    }

    fn page(&self) -> String {
        self.cause().page()
    }
}

impl Display for Asks {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let texts: Vec<String> = self.0.iter().map(Question::to_string).collect();
        f.write_str(&texts.join("\n"))
    }
}

impl Text for Asks {
    fn german(&self) -> String {
        let texts: Vec<String> = self.0.iter().map(Question::german).collect();
        texts.join("\n")
    }
}

impl Cause for Asks {
    fn kind(&self) -> Kind {
        Kind::Usage
    }

    fn code(&self) -> &'static str {
        "asks"
    }
}

impl Display for Explained {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.why.fmt(f)
    }
}

impl Text for Explained {
    fn german(&self) -> String {
        self.why.german()
    }

    fn page(&self) -> String {
        self.why.page()
    }
}

impl Cause for Explained {
    fn kind(&self) -> Kind {
        self.error.kind()
    }

    fn code(&self) -> &'static str {
        self.error.code()
    }
}

macro_rules! from {
    ($($variant:ident $own:ident;)*) => {
        $(impl From<$own> for Error {
            fn from(own: $own) -> Self {
                Self::$variant(own)
            }
        })*
    };
}

from! {
    Adapter AdapterError;
    Broker BrokerError;
    Calibration CalibrationError;
    File FileError;
    Number NumberError;
    Page PageError;
    Refused Refusal;
    Request RequestError;
    Sensor SensorError;
    Silent Silence;
    Asks Asks;
}

/// What to do on the page if nobody answers.
const NO_ANSWER: &str = "check power and wiring, choose Bit rate: automatic and press Connect, or press Find sensors. All causes are in the chapter \"No answer\" of EXCHANGE.md";
const NO_ANSWER_DE: &str = "Prüfen Sie Versorgung und Verdrahtung, wählen Sie Bitrate: automatisch und drücken Sie Verbinden, oder drücken Sie Sensoren suchen. Alle Ursachen stehen im Kapitel \"Niemand antwortet\" von AUSTAUSCH.md";

/// What to do on the page if the sensor is not found.
const NOT_FOUND: &str = "check power, wiring and terminators. Press Find sensors and switch the sensor off and on meanwhile, or check the box Send requests as well. All causes are in the chapter \"No answer\" of EXCHANGE.md";
const NOT_FOUND_DE: &str = "Prüfen Sie Versorgung, Verdrahtung und Abschlusswiderstände. Drücken Sie Sensoren suchen, und schalten Sie dabei den Sensor aus und ein, oder kreuzen Sie Auch Anfragen senden an. Alle Ursachen stehen im Kapitel \"Niemand antwortet\" von AUSTAUSCH.md";
