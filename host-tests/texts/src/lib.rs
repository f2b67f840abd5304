//! Texts for people in English and in German, by the variants of an enum. A variant without one of its texts, or with data that one of
//! them does not say, does not compile. [`errors!`] adds an exit code and a code for programs.

mod cause;

pub use cause::{Cause, Kind};

use serde_json::{Value, json};
use std::fmt::Display;

/// The maximum length of a text of other programs and files.
pub const SHOWN: usize = 80;

/// A text of another program or of a file without control characters, because a terminal executes them.
pub fn shown(text: &str) -> String {
    let printable = text.trim().chars().filter(|letter| !letter.is_control());
    printable.take(SHOWN).collect()
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

same! { String &'static str u8 u16 u32 u64 i64 usize f64 }

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

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
