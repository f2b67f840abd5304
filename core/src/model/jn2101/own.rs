//! The functions of the own objects of the JN2101: sensor reset, factory reset and the programming key.

use super::application::Jn2101Application;
use super::{Jn2101Product, NAME, objects, programming_key};
use crate::canopen::dictionary::communication;
use crate::canopen::{Abort, Initial, Own, Text, Then};
use crate::node::Context;
use crate::param::{ParameterId, ParameterSet, Parameters};

/// Whether the last factory reset has succeeded.
pub struct State {
    restored: bool,
}

impl Initial for State {
    const INITIAL: Self = Self { restored: false };
}

type Scope<'a> = crate::canopen::Scope<'a, Jn2101Product>;
type Values = Parameters<Jn2101Product>;

/// In the order of the object dictionary.
pub(super) const FUNCTIONS: [Own<Jn2101Product>; 3] = [
    Own::number(0x2002, 0, |_, _| 0).written(reset),
    Own::number(0x207F, 0, |state: &State, _| state.restored.into())
        .written(restore)
        .after_save(restored),
    Own::text(0x3000, 0, key)
        .written(write_key)
        .after_save(key_stored),
];

/// The parameters of the communication profile.
const COMMUNICATION: ParameterSet = communication(objects::OBJECTS);

/// Sensor reset (2002h): 1 resets the node, 0 does nothing.
fn reset(_: &mut Scope, data: &[u8]) -> Result<Then, Abort> {
    match data {
        [0] => Ok(Then::Reply),
        [1] => Ok(Then::Reset),
        _ => Err(Abort::TooHigh),
    }
}

/// The stored parameters that the factory reset (207Fh) restores.
fn restorable() -> impl Iterator<Item = ParameterId> {
    Values::rows()
        .filter(|(id, row)| row.is_stored() && !COMMUNICATION.contains(*id))
        .map(|(id, _)| id)
}

fn restore(scope: &mut Scope, data: &[u8]) -> Result<Then, Abort> {
    if scope.cx.is_saving() {
        return Err(Abort::DeviceState);
    }
    if data != [1] {
        return Err(Abort::Value);
    }
    let mut parameters = *scope.stored;
    parameters.copy(&Values::factory(), restorable());
    scope.save(parameters)
}

/// The factory values take effect at the end of the save.
fn restored(scope: &mut Scope, succeeded: bool) {
    if succeeded {
        scope.cx.parameters.copy(&Values::factory(), restorable());
    }
    scope.state.restored = succeeded;
}

/// The programming key of the present parameters (section 9.11).
fn key(_: &State, node: &Context<Jn2101Application>) -> Text<NAME> {
    programming_key::compose(&node.parameters)
}

fn write_key(scope: &mut Scope, text: &[u8]) -> Result<Then, Abort> {
    let mut written = scope.cx.parameters;
    programming_key::write(text, &mut written).ok_or(Abort::Value)?;
    if scope.cx.is_saving() && written == scope.cx.parameters {
        return Ok(Then::Reply);
    }
    let mut parameters = *scope.stored;
    parameters.copy(&written, programming_key::IDS);
    if parameters == *scope.stored && !scope.cx.is_saving() {
        scope.cx.parameters.copy(&written, programming_key::IDS);
        scope.cx.apply();
        return Ok(Then::Reply);
    }
    scope.save(parameters)
}

/// The parameters of a key take effect at the end of the save.
fn key_stored(scope: &mut Scope, succeeded: bool) {
    if succeeded {
        scope.cx.parameters.copy(scope.stored, programming_key::IDS);
    }
}
