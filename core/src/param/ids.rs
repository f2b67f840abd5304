//! The macro that numbers the ids of parameters and values.

use super::{ParameterId, ValueId};
use crate::walk::{at, each, put};

/// Numbers the ids of the rows of a table, in their order, without a gap and without a duplicate.
///
/// | row            | constant                                                                              |
/// |----------------|---------------------------------------------------------------------------------------|
/// | `NAME`         | an id                                                                                 |
/// | `NAME(9)`      | the first of nine ids, for example of a mapping                                       |
/// | `NAME[3]`      | an array of three ids                                                                 |
/// | `NAME[4](9)`   | an array with the first of nine ids, four times                                       |
///
/// ```
/// use plumbline::param::ParameterId;
///
/// plumbline::ids! { pub ParameterId:
///     /// Node-ID (2000h).
///     NODE_ID,
///     OFFSETS[2],
///     TPDO(4),
///     BIT_RATE,
/// }
/// assert_eq!(OFFSETS, [ParameterId(1), ParameterId(2)]);
/// assert_eq!((TPDO, BIT_RATE), (ParameterId(3), ParameterId(7)));
/// ```
#[macro_export]
macro_rules! ids {
    ($visibility:vis $id:ident: $($rows:tt)*) => {
        $crate::ids!(@rows ($visibility $id) [$($rows)*] $($rows)*);
    };
    (@rows $head:tt $all:tt $($(#[$note:meta])* $name:ident $([$count:literal])? $(($width:literal))?),* $(,)?) => {
        $($crate::ids!(@row $head [$(#[$note])*] $name [$($count)?] ($($width)?) $all);)*
    };
    (@row ($visibility:vis $id:ident) [$($note:tt)*] $name:ident [] $width:tt $all:tt) => {
        $($note)*
        $visibility const $name: $crate::param::$id =
            $crate::param::$id($crate::param::ids::first($crate::ids!(@table $all), stringify!($name)));
    };
    (@row ($visibility:vis $id:ident) [$($note:tt)*] $name:ident [$count:literal] $width:tt $all:tt) => {
        $($note)*
        $visibility const $name: [$crate::param::$id; $count] = $crate::ids!(@array $id)(
            $crate::param::ids::first($crate::ids!(@table $all), stringify!($name)),
            $crate::ids!(@width $width),
        );
    };
    (@table [$($(#[$note:meta])* $name:ident $([$count:literal])? $(($width:literal))?),* $(,)?]) => {
        &[$((stringify!($name), 1 $(* $count)? $(* $width)?)),*]
    };
    (@array ParameterId) => { $crate::param::ids::parameters };
    (@array ValueId) => { $crate::param::ids::values };
    (@width ()) => { 1 };
    (@width ($width:literal)) => { $width };
}

/// The first id of the row with this name; each row has a name and its number of ids.
#[doc(hidden)]
#[track_caller]
pub const fn first(rows: &[(&str, usize)], name: &str) -> u8 {
    let mut first = 0;
    each!((other, count) in rows => {
        if is_same(other, name) {
            break;
        }
        first += *count;
    });
    assert!(first <= u8::MAX as usize, "there are more than 256 ids");
    first as u8
}

const fn is_same(one: &str, other: &str) -> bool {
    let (one, other) = (one.as_bytes(), other.as_bytes());
    let mut is_same = one.len() == other.len();
    each!(place, letter in one => { is_same = is_same && *letter == *at(other, place) });
    is_same
}

/// `N` ids from `first` on, each `width` after the one before.
#[doc(hidden)]
pub const fn parameters<const N: usize>(first: u8, width: u8) -> [ParameterId; N] {
    let mut ids = [ParameterId(first); N];
    let mut place = 0;
    while place < N {
        put(&mut ids, place, ParameterId(first + place as u8 * width));
        place += 1;
    }
    ids
}

/// `N` ids of published values, as in [`parameters`].
#[doc(hidden)]
pub const fn values<const N: usize>(first: u8, width: u8) -> [ValueId; N] {
    let mut ids = [ValueId(first); N];
    let mut place = 0;
    while place < N {
        put(&mut ids, place, ValueId(first + place as u8 * width));
        place += 1;
    }
    ids
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_numbered_without_gap() {
        crate::ids! { ParameterId:
            A,
            /// A note.
            B(4),
            C[2],
            D[2](9),
            E,
        }
        assert_eq!((A, B, E), (ParameterId(0), ParameterId(1), ParameterId(25)));
        assert_eq!(C, [ParameterId(5), ParameterId(6)]);
        assert_eq!(D, [ParameterId(7), ParameterId(16)]);
    }

    #[test]
    fn ids_of_values_have_type_value_id() {
        crate::ids! { ValueId: X, FORCE[3] }
        assert_eq!(X, ValueId(0));
        assert_eq!(FORCE, [1, 2, 3].map(ValueId));
    }
}
