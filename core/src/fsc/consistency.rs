//! Checks that the description of a product is consistent. The compiler evaluates them where the tables are written. A mistake is a compile
//! error that names the row.

use super::projection::{Item, LAST};
use super::status::StatusMasks;
use super::table::{Access, Field, Function, Operation, Own, Product, Roles, Source};
use super::wire::IDENTIFIERS;
use crate::application::{Application, Values};
use crate::mistake::Mistake;
use crate::param::projection::{check_quantities, exists, has_quantity, highest, permits};
use crate::param::{Parameter, ParameterId, Persistence, Quantity, Table};
use crate::walk::{at, each, put};

/// The maximum number of data bytes of a reply after code and status.
const DATA_MAX: u32 = 6;

/// Checks the tables of a product.
#[track_caller]
pub const fn check<P: Product>() {
    let parameters = <<P::Application as Application>::Table as Table>::PARAMETERS;
    let quantities = <P::Application as Application>::QUANTITIES;
    check_quantities(
        quantities,
        <<P::Application as Application>::Values as Values>::CAPACITY,
    );
    check_codes(P::ACCESS, P::FUNCTIONS);
    each!(access in P::ACCESS => { check_access(access, &P::ROLES, parameters, quantities) });
    each!(function in P::FUNCTIONS => { check_function(function, parameters, quantities) });
    check_operations(P::FUNCTIONS);
    check_own(P::FUNCTIONS, P::OWN);
    check_roles(&P::ROLES, parameters);
    check_persistence(parameters);
    StatusMasks::of(&P::STATUS);
}

/// Checks that each code has one function, and that there are not too many.
#[track_caller]
pub(super) const fn check_codes(access: &[Access], functions: &[Function]) {
    let mut used = [false; 256];
    each!(access in access => {
        take(&mut used, access.read, access.mistake());
        let written = Mistake::code(access.write, access.name).at(access.origin);
        take(&mut used, access.write, written);
    });
    each!(function in functions => { take(&mut used, function.code, function.mistake()) });
    let (mut rows, mut group) = (0, 0);
    while group < 16 {
        let (_, rest) = used.split_at(16 * group);
        let (codes, _) = rest.split_at(16);
        let (mut first, mut end) = (0, 0);
        each!(place, is_used in codes => {
            if *is_used {
                first = if end == 0 { place } else { first };
                end = place + 1;
            }
        });
        rows += end - first;
        group += 1;
    }
    Mistake::item("FUNCTIONS").unless(
        rows < LAST,
        "there are too many codes: each group of 16 needs a row from its first to its last code",
    );
}

#[track_caller]
const fn take(used: &mut [bool; 256], code: u8, mistake: Mistake) {
    mistake.unless(!*at(used, code as usize), "another row has this code");
    put(used, code as usize, true);
}

/// Checks the codes that read and write parameters.
#[track_caller]
pub(super) const fn check_access(
    access: &Access,
    roles: &Roles,
    parameters: &[Parameter],
    quantities: &[Quantity],
) {
    let mistake = access.mistake();
    let own = roles.own();
    mistake.unless(!access.parameters.is_empty(), "it reads no parameter");
    let mut bytes = 0;
    each!(place, id in access.parameters => {
        bytes += check_source(mistake, Source::Parameter(*id), parameters, quantities);
        mistake.unless(
            own.contains(*id) == own.contains(*at(access.parameters, 0)),
            "it writes parameters of the protocol and of the application",
        );
        each!(other in access.parameters.split_at(place).0 => {
            mistake.unless(other.0 != id.0, "it has a parameter twice");
        });
    });
    check_length(mistake, bytes);
}

/// Checks a code that does not access parameters.
#[track_caller]
const fn check_function(function: &Function, parameters: &[Parameter], quantities: &[Quantity]) {
    let mistake = function.mistake();
    mistake.unless(
        !matches!(function.operation, Operation::Write),
        "only the rows of ACCESS write parameters",
    );
    mistake.unless(
        function.reply.is_empty() || !matches!(function.operation, Operation::Own),
        "the reply of an own operation comes from its function",
    );
    mistake.unless(
        function.signature.len() <= 7,
        "a request has at most 7 bytes after the code",
    );
    mistake.unless(
        !function.signature.is_empty() || !matches!(function.operation, Operation::Alive),
        "without a signature, each request restarts the sensor",
    );
    mistake.unless(
        function.signature.is_empty()
            || matches!(
                function.operation,
                Operation::Load | Operation::Save | Operation::Alive
            ),
        "only the operations Load, Save and Alive have a signature",
    );
    check_reply(mistake, function.reply, parameters, quantities);
}

/// Checks the fields of a reply.
#[track_caller]
const fn check_reply(
    mistake: Mistake,
    reply: &[Field],
    parameters: &[Parameter],
    quantities: &[Quantity],
) {
    let mut bytes = 0;
    each!(place, field in reply => {
        bytes += check_source(mistake, field.source, parameters, quantities);
        mistake.unless(
            place + 1 == reply.len() || !matches!(field.source, Source::Counter),
            "the cyclic counter must be the last field",
        );
    });
    check_length(mistake, bytes);
    mistake.unless(reply.len() < 8, "a reply has at most 7 fields");
}

#[track_caller]
const fn check_length(mistake: Mistake, bytes: u32) {
    if bytes > DATA_MAX {
        mistake
            .text("its data has ")
            .number(bytes)
            .text(" bytes, a reply has room for ")
            .number(DATA_MAX)
            .fail();
    }
}

/// Checks that the source of a field exists. Returns its size in bytes.
#[track_caller]
const fn check_source(
    mistake: Mistake,
    source: Source,
    parameters: &[Parameter],
    quantities: &[Quantity],
) -> u32 {
    match source {
        Source::Parameter(id) => exists(mistake, parameters, id),
        Source::Value(id) => has_quantity(mistake, quantities, id),
        _ => {}
    }
    let size = Item::new(source, parameters, quantities).size as u32;
    mistake.unless(size <= 4, "a field has at most 32 bits");
    size
}

/// The operations that each product has once.
const ONCE: [(Operation, &str); 4] = [
    (
        Operation::Inclination,
        "a product has one function with the operation Inclination",
    ),
    (
        Operation::Load,
        "a product has one function with the operation Load",
    ),
    (
        Operation::Save,
        "a product has one function with the operation Save",
    ),
    (
        Operation::Alive,
        "a product has one function with the operation Alive",
    ),
];

/// Checks that each product has the operations that the protocol needs.
#[track_caller]
const fn check_operations(functions: &[Function]) {
    each!((operation, text) in &ONCE => {
        let mut exists = false;
        each!(function in functions => {
            if function.operation as u8 == *operation as u8 {
                function.mistake().unless(!exists, text);
                exists = true;
            }
        });
        Mistake::item("FUNCTIONS").unless(exists, text);
    });
}

/// Checks that each code with [`Operation::Own`] has its function.
#[track_caller]
const fn check_own<A: Application>(functions: &[Function], own: &[Own<A>]) {
    let mut rest = own;
    each!(function in functions => {
        if let Operation::Own = function.operation {
            let mistake = function.mistake();
            let text = "OWN has no function for this code, or not in the order of FUNCTIONS";
            let [first, others @ ..] = rest else {
                mistake.text(text).fail();
            };
            mistake.unless(first.code == function.code, text);
            rest = others;
        }
    });
    if let [first, ..] = rest {
        Mistake::code(first.code, "OWN")
            .text("FUNCTIONS has no code with an own operation for it")
            .fail();
    }
}

/// Checks the parameters of the protocol.
#[track_caller]
const fn check_roles(roles: &Roles, parameters: &[Parameter]) {
    let identifiers = [roles.set_id, roles.reply_id, roles.sync_id];
    each!(place, id in &identifiers => {
        let parameter = role(parameters, *id);
        let mistake = parameter.mistake();
        mistake.unless(
            IDENTIFIERS.contain(parameter.factory) && IDENTIFIERS.contain(highest(parameter)),
            "it permits a number that is no identifier",
        );
        each!(other in identifiers.split_at(place).0 => {
            mistake.unless(
                role(parameters, *other).factory != parameter.factory,
                "the identifiers of requests, replies and sync frames differ",
            );
        });
    });
    let bit_rate = role(parameters, roles.bit_rate);
    let mistake = bit_rate.mistake();
    if highest(bit_rate) as usize >= roles.bit_rates.len() {
        mistake
            .text("`bit_rates` has no row for the permitted number ")
            .number(highest(bit_rate))
            .fail();
    }
    role(parameters, roles.bus_off_recovery);
    role(parameters, roles.cyclic_mode);
    let time = role(parameters, roles.cyclic_time);
    time.mistake()
        .unless(!permits(time, 0), "the cyclic time permits 0 ms");
}

/// The parameter of a role. It is an unsigned number.
#[track_caller]
const fn role(parameters: &[Parameter], id: ParameterId) -> &Parameter {
    exists(Mistake::item("ROLES"), parameters, id);
    let parameter = at(parameters, id.0 as usize);
    parameter.mistake().unless(
        !parameter.data_type.is_signed() && !parameter.data_type.is_wide(),
        "a parameter of the protocol is an unsigned number of up to 32 bits",
    );
    parameter
}

/// Checks that no parameter is stored when it is written: this protocol has a save command.
#[track_caller]
const fn check_persistence(parameters: &[Parameter]) {
    each!(parameter in parameters => {
        parameter.mistake().unless(
            !matches!(parameter.persistence, Persistence::AtOnce),
            "a parameter is stored on save, or never",
        );
    });
}
