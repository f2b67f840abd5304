//! The kind of an error, and its code for programs.

use crate::Text;

/// The kind of an error, which selects the exit code.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// The sensor refused: exit code 1.
    Refused,
    /// The command line, a name or a value is wrong: exit code 2.
    Usage,
    /// Nobody answers: exit code 3.
    Silent,
    /// The bus, the adapter or a file failed: exit code 4.
    Bus,
    /// The user pressed Ctrl-C: exit code 130.
    Stopped,
}

impl Kind {
    /// The exit code: 1 to 4, or 130.
    pub const fn exit_code(self) -> u8 {
        match self {
            Self::Refused => 1,
            Self::Usage => 2,
            Self::Silent => 3,
            Self::Bus => 4,
            Self::Stopped => 130,
        }
    }
}

/// What all errors tell.
pub trait Cause: Text {
    /// Who or what has failed.
    fn kind(&self) -> Kind;

    /// A short code for programs, for example `out-of-range`.
    fn code(&self) -> &'static str;
}

/// Declares an enum of errors: `Variant(data: Type): Kind "code" = "English", "German";`, see [`texts!`](crate::texts!).
#[macro_export]
macro_rules! errors {
    ($(#[$meta:meta])* $name:ident {
        $($variant:ident $(($($field:ident: $type:ty),*))?: $kind:ident $code:literal = $($text:literal),+;)*
    }) => {
        $crate::texts! {
            $(#[$meta])*
            $name { $($variant $(($($field: $type),*))? = $($text),+;)* }
        }

        impl std::error::Error for $name {}

        impl $crate::Cause for $name {
            fn kind(&self) -> $crate::Kind {
                match self { $(Self::$variant { .. } => $crate::Kind::$kind,)* }
            }

            fn code(&self) -> &'static str {
                match self { $(Self::$variant { .. } => $code,)* }
            }
        }
    };
}
