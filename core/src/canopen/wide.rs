//! Objects of 64 bits: the server transports them as a text of eight bytes. Parameters have two rows, the lower 32 bits first.

use super::Abort;
use super::dictionary::Object;
use super::objects::is_busy;
use super::pdo::Entry;
use super::product::{ContextOf, ParametersOf, Product, TableOf};
use super::protocol::Services;
use super::row::{Kind, Row};
use super::sdo::Written;
use crate::application::{Application, Effect, Values};
use crate::param::{Parameter, ParameterId, Quantity, Table, number};
use crate::walk::each;

/// The size of the numbers in bytes.
pub(super) const SIZE: u8 = 8;

/// Whether an object has 64 bits.
pub(super) const fn has_wide(
    objects: &[Object],
    parameters: &[Parameter],
    quantities: &[Quantity],
) -> bool {
    each!(object in objects => {
        if object.data_type(parameters, quantities).is_wide() {
            return true;
        }
    });
    false
}

impl<P: Product> Services<P> {
    /// Whether the product has objects of 64 bits.
    pub(super) const WIDE: bool = has_wide(
        P::OBJECTS,
        <TableOf<P> as Table>::PARAMETERS,
        <P::Application as Application>::QUANTITIES,
    );

    /// Whether an object has 64 bits.
    pub(super) fn is_wide(row: &Row) -> bool {
        Self::WIDE && row.is_wide()
    }

    /// The mapped object with its size.
    pub(super) fn widened(row: &Row, entry: Entry) -> Entry {
        if Self::is_wide(row) {
            return Entry {
                size: SIZE,
                ..entry
            };
        }
        entry
    }

    /// The number in an object of 64 bits.
    pub(super) fn wide_number(cx: &ContextOf<P>, row: &Row) -> u64 {
        match row.kind() {
            Kind::Parameter => cx.parameters.get_wide(row.id()),
            _ => cx.values.wide(row.value_id()),
        }
    }

    /// Writes a parameter of 64 bits.
    pub(super) fn write_wide(
        &mut self,
        cx: &mut ContextOf<P>,
        row: &Row,
        data: &[u8],
    ) -> Result<Written, Abort> {
        let (lower, upper) = data.split_at_checked(4).ok_or(Abort::TooShort)?;
        let (lower, upper) = (number(lower), number(upper));
        let value = u64::from(upper) << 32 | u64::from(lower);
        let id = row.id();
        ParametersOf::<P>::check_wide(id, value)?;
        // The value in force is accepted in each state.
        if value == cx.parameters.get_wide(id) {
            return Ok(Written::Done);
        }
        if is_busy::<P>(self, cx, id) {
            return Err(Abort::DeviceState);
        }
        let before = cx.parameters;
        let first = cx.write(id, lower)?;
        let second = cx
            .write(next(id), upper)
            .inspect_err(|_| cx.parameters = before);
        let effect = match second? {
            Effect::None => first,
            Effect::Store => Effect::Store,
        };
        cx.apply();
        Ok(self.carry_out(cx, effect))
    }
}

/// The parameter with the upper 32 bits.
fn next(ParameterId(id): ParameterId) -> ParameterId {
    ParameterId(id.wrapping_add(1))
}
