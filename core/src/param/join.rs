//! Tables from several arrays of rows.

use crate::walk::{each, put};

/// Joins arrays of parameters, one table from several.
#[macro_export]
macro_rules! parameters {
    ($($part:expr),* $(,)?) => {
        &$crate::param::join::join::<
            $crate::param::Parameter,
            { 0 $(+ $part.len())* },
        >(&[$(&$part),*], $crate::param::Parameter::plain())
    };
}

/// Joins slices to one array with as many elements as all of them have; `filler` is overwritten.
#[track_caller]
pub const fn join<T: Copy, const N: usize>(parts: &[&[T]], filler: T) -> [T; N] {
    let (mut joined, mut place) = ([filler; N], 0);
    each!(part in parts => {
        each!(row in part => {
            put(&mut joined, place, *row);
            place += 1;
        });
    });
    assert!(place == N, "the table has another number of rows");
    joined
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[should_panic = "another number of rows"]
    fn join_to_another_number_of_rows_is_refused() {
        let _: [u8; 3] = join(&[&[1], &[2]], 0);
    }
}
