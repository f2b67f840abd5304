//! Walks through tables in `const fn`s, which have neither iterators nor `get`.
//!
//! They are evaluated at compile time only. There a place outside of a table is a compile error.

/// Runs a block for each item of a slice: `each!(row in rows => { ... })`. The block can also have the place of the item:
/// `each!(place, row in rows => { ... })`.
macro_rules! each {
    ($item:pat in $items:expr => $body:block) => {
        crate::walk::each!(_, $item in $items => $body)
    };
    ($place:pat, $item:pat in $items:expr => $body:block) => {{
        let mut next = 0_usize;
        let mut rest: &[_] = $items;
        while let [item, others @ ..] = rest {
            let ($place, $item) = (next, item);
            next += 1;
            rest = others;
            $body
        }
    }};
}
pub(crate) use each;

/// The item at a place.
#[track_caller]
#[expect(clippy::indexing_slicing, reason = "evaluated at compile time only")]
pub(crate) const fn at<T>(items: &[T], place: usize) -> &T {
    &items[place]
}

/// The item at a place; None outside of the table.
pub(crate) const fn get<T>(items: &[T], place: usize) -> Option<&T> {
    if place < items.len() {
        Some(at(items, place))
    } else {
        None
    }
}

/// Sets the item at a place.
#[track_caller]
#[expect(clippy::indexing_slicing, reason = "evaluated at compile time only")]
pub(crate) const fn put<T: Copy>(items: &mut [T], place: usize, item: T) {
    items[place] = item;
}

/// Copies as many bytes as both have. Other than `copy_from_slice`, it has no panic path if the compiler does not inline it.
pub(crate) fn copy(to: &mut [u8], from: &[u8]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
}

/// Whether two names are the same.
pub(crate) const fn equal(one: &str, other: &str) -> bool {
    let (one, other) = (one.as_bytes(), other.as_bytes());
    each!(place, letter in one => {
        if one.len() != other.len() || *at(other, place) != *letter {
            return false;
        }
    });
    one.len() == other.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn block_runs_for_each_item_until_it_breaks() {
        const SQUARES: [usize; 4] = {
            let mut squares = [0; 4];
            each!(place, number in &[1, 2, 3, 4] => {
                if *number == 2 {
                    continue;
                }
                if *number == 4 {
                    break;
                }
                put(&mut squares, place, *number * *number);
            });
            squares
        };
        assert_eq!(SQUARES, [1, 0, 9, 0]);
        assert_eq!(*at(&SQUARES, 2), 9);
    }
}
