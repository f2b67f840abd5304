//! The description of the functions of a product in the compact form that the device uses.
//!
//! ```text
//!  row    | code      | operation | index of the first item | bits 0..2 number of items, 7 own, 6 cyclic time, 5 constrained |
//!  item   | source    | size in bytes |
//!  source   0 to 127 parameters, 128 to 247 published values, from 248 the others
//! ```
//!
//! A group contains the codes with the same upper four bits. It has a row for each code from its first to its last one. Codes
//! between them that the product does not have are filler rows.

use super::table::{Access, Function, Operation, Roles, Source};
use crate::param::{Constraint, Parameter, ParameterId, ParameterSet, Quantity, ValueId};
use crate::walk::{at, each, put};

pub use super::consistency::check;

/// The index of no row: a group without codes begins there. All rows are before it.
pub(super) const LAST: usize = 0xF0;

/// The function select codes of a product.
#[derive(Clone, Copy, Debug)]
pub struct Codes {
    /// For each group, the index of the row for the code n0h, modulo 256. This row need not exist.
    groups: &'static [u8; 16],
    rows: &'static [Row],
    items: &'static [Item],
}

impl Codes {
    /// The parts that [`project!(functions)`](crate::project) has projected.
    pub const fn new(
        groups: &'static [u8; 16],
        rows: &'static [Row],
        items: &'static [Item],
    ) -> Self {
        Self {
            groups,
            rows,
            items,
        }
    }

    /// The row of a code; None if the product does not have the code.
    pub(super) fn find(&self, code: u8) -> Option<Row> {
        let group = self.groups.get(usize::from(code >> 4))?;
        let row = self.rows.get(usize::from(group.wrapping_add(code & 15)))?;
        (row.code == code).then_some(*row)
    }

    /// The fields of a row.
    pub(super) fn items(&self, row: Row) -> &'static [Item] {
        let (first, count) = (usize::from(row.first), usize::from(row.form & COUNT));
        self.items.get(first..first + count).unwrap_or(&[])
    }

    /// The row of the function with this operation, which each product has.
    pub(super) const fn row_of(&self, operation: Operation) -> Row {
        each!(row in self.rows => {
            if row.operation as u8 == operation as u8 && !row.is_filler() {
                return *row;
            }
        });
        Row::filler(0)
    }
}

/// The compact form of a function select code, or a filler for a code that the product does not have.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Row {
    pub(super) code: u8,
    pub(super) operation: Operation,
    first: u8,
    form: u8,
}

impl Row {
    /// Whether a request only reads.
    pub(super) fn is_read(self) -> bool {
        matches!(self.operation, Operation::Read | Operation::Inclination)
    }
}

/// Bits of `form`: the number of items.
const COUNT: u8 = 7;
/// Bit of `form`: the row writes parameters that only the protocol uses.
const OWN: u8 = 1 << 7;
/// Bit of `form`: the row writes the cyclic time.
const CYCLIC_TIME: u8 = 1 << 6;
/// Bit of `form`: the row writes a parameter that is part of a constraint.
const CONSTRAINED: u8 = 1 << 5;

impl Row {
    /// The row at the position of a code that does not exist. Its code is the next one of the group, which is searched at the next
    /// position, so no search finds it.
    const fn filler(position: u8) -> Self {
        Self {
            code: position & 0xF0 | position.wrapping_add(1) & 0x0F,
            operation: Operation::Read,
            first: u8::MAX,
            form: 0,
        }
    }

    const fn is_filler(&self) -> bool {
        self.first == u8::MAX
    }

    /// Whether it writes parameters that only the protocol uses.
    pub(super) const fn is_own(self) -> bool {
        self.form & OWN != 0
    }

    /// Whether it writes the cyclic time.
    pub(super) const fn is_cyclic_time(self) -> bool {
        self.form & CYCLIC_TIME != 0
    }

    /// Whether it writes parameters that must be consistent with others.
    pub(super) const fn is_constrained(self) -> bool {
        self.form & CONSTRAINED != 0
    }

    /// Whether it has several fields.
    pub(super) const fn has_several(self) -> bool {
        self.form & COUNT > 1
    }

    /// A reply with code and status only.
    pub(super) const fn bare(code: u8) -> Self {
        Self {
            code,
            operation: Operation::Read,
            first: 0,
            form: 0,
        }
    }
}

/// A field of a request or a reply.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Item {
    source: u8,
    /// The size in bytes: 1, 2 or 4.
    pub(super) size: u8,
}

const VALUES: u8 = 128;
const COUNTER: u8 = 248;
const PRODUCT_NUMBER: u8 = COUNTER + 1;
const REVISION: u8 = COUNTER + 2;
const SERIAL_NUMBER: u8 = COUNTER + 3;
const SOFTWARE_VERSION: u8 = COUNTER + 4;
const ACTIVE_SET_ID: u8 = COUNTER + 5;

impl Item {
    pub(super) const fn new(
        source: Source,
        parameters: &[Parameter],
        quantities: &[Quantity],
    ) -> Self {
        let size = source.data_type(parameters, quantities).size();
        let source = match source {
            Source::Parameter(id) => id.0,
            Source::Value(id) => VALUES + id.0,
            Source::Counter => COUNTER,
            Source::ProductNumber => PRODUCT_NUMBER,
            Source::Revision => REVISION,
            Source::SerialNumber => SERIAL_NUMBER,
            Source::SoftwareVersion => SOFTWARE_VERSION,
            Source::ActiveSetId => ACTIVE_SET_ID,
        };
        Self { source, size }
    }

    /// The source of the number.
    pub(super) const fn source(self) -> Source {
        match self.source {
            0..VALUES => Source::Parameter(ParameterId(self.source)),
            VALUES..COUNTER => Source::Value(ValueId(self.source - VALUES)),
            COUNTER => Source::Counter,
            PRODUCT_NUMBER => Source::ProductNumber,
            REVISION => Source::Revision,
            SERIAL_NUMBER => Source::SerialNumber,
            SOFTWARE_VERSION => Source::SoftwareVersion,
            _ => Source::ActiveSetId,
        }
    }

    /// The parameter, if the source is one.
    pub(super) const fn parameter(self) -> Option<ParameterId> {
        match self.source() {
            Source::Parameter(id) => Some(id),
            _ => None,
        }
    }
}

/// The signature of the function with this operation, which each product has.
pub(super) const fn signature_of(
    functions: &'static [Function],
    operation: Operation,
) -> &'static [u8] {
    each!(function in functions => {
        if function.operation as u8 == operation as u8 {
            return function.signature;
        }
    });
    &[]
}

/// The codes and rows of a group.
#[derive(Clone, Copy)]
struct Group {
    /// The lower four bits of the first code; 16 if the group is empty.
    first: usize,
    /// The lower four bits of the last code.
    last: usize,
    start: usize,
}

/// The groups, and the total number of rows.
const fn layout(access: &[Access], functions: &[Function]) -> ([Group; 16], usize) {
    let mut groups = [Group {
        first: 16,
        last: 0,
        start: 0,
    }; 16];
    let mut place = 0;
    while place < 2 * access.len() + functions.len() {
        let (code, ..) = code_at(access, functions, place);
        let mut group = *at(&groups, code as usize / 16);
        let row = code as usize % 16;
        group.first = if row < group.first { row } else { group.first };
        group.last = if row > group.last { row } else { group.last };
        put(&mut groups, code as usize / 16, group);
        place += 1;
    }
    let (unplaced, mut count) = (groups, 0);
    each!(place, group in &unplaced => {
        if group.first < 16 {
            put(&mut groups, place, Group { start: count, ..*group });
            count += group.last - group.first + 1;
        }
    });
    (groups, count)
}

/// The code, operation and number of fields at a position: first the codes that read and write, then the others.
const fn code_at(
    access: &[Access],
    functions: &[Function],
    place: usize,
) -> (u8, Operation, usize) {
    if place < 2 * access.len() {
        let access = at(access, place / 2);
        let count = access.parameters.len();
        return match place % 2 {
            0 => (access.read, Operation::Read, count),
            _ => (access.write, Operation::Write, count),
        };
    }
    let function = at(functions, place - 2 * access.len());
    (function.code, function.operation, function.reply.len())
}

/// For each group, the index of its row n0h, as in [`Codes`]. The group of a code is its upper four bits.
pub const fn groups(access: &[Access], functions: &[Function]) -> [u8; 16] {
    let (layout, _) = layout(access, functions);
    let mut groups = [LAST as u8; 16];
    each!(place, group in &layout => {
        if group.first < 16 {
            put(&mut groups, place, (group.start as u8).wrapping_sub(group.first as u8));
        }
    });
    groups
}

/// The number of rows of [`rows`], with the fillers.
pub const fn row_count(access: &[Access], functions: &[Function]) -> usize {
    let (_, count) = layout(access, functions);
    count
}

/// The rows of all groups, in the order of their codes.
pub const fn rows<const N: usize>(
    access: &[Access],
    functions: &[Function],
    roles: &Roles,
    constraints: &[Constraint],
) -> [Row; N] {
    let (layout, _) = layout(access, functions);
    let mut rows = [Row::filler(0); N];
    each!(place, group in &layout => {
        let mut row = group.first;
        while row <= group.last {
            let position = (place << 4 | row) as u8;
            put(&mut rows, group.start + row - group.first, Row::filler(position));
            row += 1;
        }
    });
    let (mut place, mut first) = (0, 0);
    while place < 2 * access.len() + functions.len() {
        let (code, operation, count) = code_at(access, functions, place);
        let is_access = place < 2 * access.len();
        let mut form = count as u8;
        if is_access {
            form |= flags(at(access, place / 2).parameters, roles, constraints);
        }
        let group = at(&layout, code as usize / 16);
        let row = Row {
            code,
            operation,
            first,
            form,
        };
        put(
            &mut rows,
            group.start + code as usize % 16 - group.first,
            row,
        );
        // The read and the write row have the same fields.
        if !is_access || place % 2 == 1 {
            first += count as u8;
        }
        place += 1;
    }
    rows
}

/// The flags of a row that writes these parameters.
const fn flags(parameters: &[ParameterId], roles: &Roles, constraints: &[Constraint]) -> u8 {
    let own = roles.own();
    let constrained = ParameterSet::constrained(constraints);
    let mut flags = 0;
    each!(id in parameters => {
        if own.contains(*id) {
            flags |= OWN;
        }
        if constrained.contains(*id) {
            flags |= CONSTRAINED;
        }
        if id.0 == roles.cyclic_time.0 {
            flags |= CYCLIC_TIME;
        }
    });
    flags
}

/// The number of items of [`items`]: the fields of all replies together.
pub const fn item_count(access: &[Access], functions: &[Function]) -> usize {
    let mut count = 0;
    each!(access in access => { count += access.parameters.len() });
    each!(function in functions => { count += function.reply.len() });
    count
}

/// Projects the fields.
pub const fn items<const N: usize>(
    access: &[Access],
    functions: &[Function],
    parameters: &[Parameter],
    quantities: &[Quantity],
) -> [Item; N] {
    let mut items = [Item { source: 0, size: 0 }; N];
    let mut place = 0;
    each!(access in access => {
        each!(id in access.parameters => {
            let item = Item::new(Source::Parameter(*id), parameters, quantities);
            put(&mut items, place, item);
            place += 1;
        });
    });
    each!(function in functions => {
        each!(field in function.reply => {
            put(&mut items, place, Item::new(field.source, parameters, quantities));
            place += 1;
        });
    });
    items
}

#[cfg(test)]
mod tests;
