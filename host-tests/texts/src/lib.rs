//! Texts for people in English and in German, by the variants of an enum. A variant without one of its texts, or with data that one of
//! them does not say, does not compile. [`errors!`] adds an exit code and a code for programs.

mod cause;

pub use cause::{Cause, Kind};

use serde_json::{Value, json};
use std::fmt::{Display, Formatter};

/// The maximum length of a text of other programs and files.
pub const SHOWN: usize = 80;

/// The maximum length of a sentence of another library, which can list what is permitted.
const TOLD: usize = 160;

/// A text of another program or of a file without control characters, because a terminal executes them.
pub fn shown(text: &str) -> String {
    cut(text, SHOWN)
}

/// The same of a sentence about such a text.
pub fn told(sentence: &str) -> String {
    cut(sentence, TOLD)
}

fn cut(text: &str, longest: usize) -> String {
    let printable = text.trim().chars().filter(|letter| !letter.is_control());
    printable.take(longest).collect()
}

/// A text in the languages of the tool. `Display` is the English text of the command line.
pub trait Text: Display {
    /// The texts of the page.
    fn texts(&self) -> Value {
        json!({"en": self.page(), "de": self.german()})
    }

    /// The German text, which only the page shows.
    fn german(&self) -> String;

    /// The English text of the page, which names its controls where the command line names a command.
    fn page(&self) -> String {
        self.to_string()
    }
}

impl<T: Text> Text for Box<T> {
    fn german(&self) -> String {
        (**self).german()
    }

    fn page(&self) -> String {
        (**self).page()
    }
}

/// Data in a text.
pub trait Field {
    /// What a text of the page shows.
    type Shown<'a>
    where
        Self: 'a;

    /// The data in a German text.
    fn german(&self) -> Self::Shown<'_>;

    /// The data in an English text of the page.
    fn page(&self) -> Self::Shown<'_>;
}

impl<T: Text> Field for T {
    type Shown<'a>
        = String
    where
        T: 'a;

    fn german(&self) -> String {
        Text::german(self)
    }

    fn page(&self) -> String {
        Text::page(self)
    }
}

/// Implements [`Field`] for types that are the same in all languages: names and numbers.
#[macro_export]
macro_rules! same {
    ($($own:ty)*) => {
        $(impl $crate::Field for $own {
            type Shown<'a> = &'a $own;

            fn german(&self) -> &$own {
                self
            }

            fn page(&self) -> &$own {
                self
            }
        })*
    };
}

same! { String &'static str u8 u16 u32 u64 i64 usize }

/// A number as a language writes it.
pub struct Decimal {
    number: f64,
    point: &'static str,
}

impl Display for Decimal {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let text = match f.precision() {
            Some(digits) => format!("{:.digits$}", self.number),
            None => self.number.to_string(),
        };
        f.write_str(&text.replace('.', self.point))
    }
}

impl Field for f64 {
    type Shown<'a> = Decimal;

    fn german(&self) -> Decimal {
        Decimal {
            number: *self,
            point: ",",
        }
    }

    fn page(&self) -> Decimal {
        Decimal {
            number: *self,
            point: ".",
        }
    }
}

/// Declares an enum with its texts: `Variant(data: Type) = "English", "German";`. A third text is the English one of the page.
/// Data in braces, `Variant {data: Type}`, have their names in documents.
#[macro_export]
macro_rules! texts {
    ($(#[$meta:meta])* $name:ident {
        $($(#[$own:meta])* $variant:ident $(($($field:ident: $type:ty),*))? $({$($part:ident: $kind:ty),*})?
            = $english:literal, $german:literal $(, $page:literal)?;)*
    }) => {
        $(#[$meta])*
        #[derive(Clone, PartialEq, Debug)]
        pub enum $name {
            $(#[doc = concat!("```text\n", $english, "\n```")]
            $(#[$own])*
            $variant $(($($type),*))? $({$(#[doc = concat!("`{", stringify!($part), "}`")] $part: $kind),*})?,)*
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                match self {
                    $(Self::$variant $(($($field),*))? $({$($part),*})? => write!(f, $english),)*
                }
            }
        }

        impl $crate::Text for $name {
            fn german(&self) -> String {
                match self {
                    $(Self::$variant $(($($field),*))? $({$($part),*})? => {
                        $($(let $field = $crate::Field::german($field);)*)?
                        $($(let $part = $crate::Field::german($part);)*)?
                        format!($german)
                    })*
                }
            }

            fn page(&self) -> String {
                match self {
                    $(Self::$variant $(($($field),*))? $({$($part),*})? => {
                        $($(let $field = $crate::Field::page($field);)*)?
                        $($(let $part = $crate::Field::page($part);)*)?
                        $crate::texts!(@page $english $(, $page)?)
                    })*
                }
            }
        }
    };
    (@page $english:literal) => { format!($english) };
    (@page $english:literal, $page:literal) => { format!($page) };
}

/// Declares types that count things: `Name = "singular" "plural", "German singular" "German plural";`. Their text is the number with the
/// noun. A sentence with one of them has no verb that depends on the number.
#[macro_export]
macro_rules! counted {
    ($($(#[$meta:meta])* $name:ident = $one:literal $several:literal, $german:literal $germans:literal;)*) => {
        $($(#[$meta])*
        #[derive(Clone, Copy, PartialEq, Eq, Debug)]
        pub struct $name(pub u64);

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                let noun = if self.0 == 1 { $one } else { $several };
                write!(f, "{} {noun}", self.0)
            }
        }

        impl $crate::Text for $name {
            fn german(&self) -> String {
                let noun = if self.0 == 1 { $german } else { $germans };
                format!("{} {noun}", self.0)
            }
        }

        impl From<usize> for $name {
            fn from(count: usize) -> Self {
                Self(count as u64)
            }
        })*
    };
}

#[cfg(test)]
mod tests {
    use super::Text;

    counted! {
        Samples = "sample" "samples", "Messwert" "Messwerte";
    }

    #[test]
    fn one_thing_has_the_singular_in_both_languages() {
        for (count, english, german) in [
            (0, "0 samples", "0 Messwerte"),
            (1, "1 sample", "1 Messwert"),
            (2, "2 samples", "2 Messwerte"),
        ] {
            let samples = Samples(count);
            assert_eq!([samples.to_string(), samples.page()], [english, english]);
            assert_eq!(Text::german(&samples), german);
        }
    }

    texts! {
        /// A time with its digits, or with as many as it has.
        Time {
            Rounded(s: f64) = "in {s:.1} s", "in {s:.1} s";
            Exact(s: f64) = "in {s} s", "in {s} s";
        }
    }

    #[test]
    fn number_in_a_german_text_has_a_decimal_comma() {
        for (time, english, german) in [
            (Time::Rounded(-2.54), "in -2.5 s", "in -2,5 s"),
            (Time::Exact(0.125), "in 0.125 s", "in 0,125 s"),
            (Time::Exact(2.0), "in 2 s", "in 2 s"),
        ] {
            let texts = [time.to_string(), time.page(), time.german()];
            assert_eq!(texts, [english, english, german]);
        }
    }
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
