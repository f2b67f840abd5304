//! Log messages: by defmt with feature `defmt`, otherwise none.

/// Defines a macro that passes its arguments to the macro of defmt with the same name.
macro_rules! level {
    ($dollar:tt $name:ident) => {
        macro_rules! $name {
                    ($dollar format:literal $dollar(, $dollar argument:expr)* $dollar(,)?) => {{
                        #[cfg(feature = "defmt")]
                        defmt::$name!($dollar format $dollar(, $dollar argument)*);
                        #[cfg(not(feature = "defmt"))]
                        { $dollar(let _ = &$dollar argument;)* }
                    }};
                }
    };
}

level!($ debug);
level!($ info);
level!($ warn);
level!($ error);

#[cfg(feature = "defmt")]
use defmt_rtt as _;
