//! The messages of the scenario for a product with function select codes, made from its tables.

use super::super::rows::Row;
use super::{Filter, Message, Protocol, Step, is_filter, leak};
use bench::BusRate;
use plumbline::can::BitRate;
use plumbline::fsc::table::{Access, Function, Operation};
use plumbline::model::catalog::{Product, Written};
use plumbline::model::listing::fsc::Tables;
use plumbline::param::{Constraint, Parameter, ParameterId, Permitted, Relation};
use plumbline::time::millis;

/// A code that no product has.
const UNKNOWN: u8 = 0x77;

/// A product whose messages are made.
struct Source<'a> {
    product: &'a Product,
    tables: &'a Tables,
}

/// The messages for a product.
pub(super) fn messages(product: &Product, tables: &Tables) -> &'static Protocol {
    let source = Source { product, tables };
    let roles = &tables.roles;
    let rates = roles.bit_rates;
    let factory = source.parameter(roles.bit_rate).factory as usize;
    let detects = rates.get(factory).is_some_and(Option::is_none);
    let fast = rates.iter().position(|rate| *rate == Some(BitRate::M1));
    let fast = fast.and_then(|code| source.set(roles.bit_rate, code as u32));
    let save = source.operation(Operation::Save);
    let restart = source.operation(Operation::Alive);
    // A sensor that does not detect the bit rate gets that of the scenario.
    let preparation = if detects {
        Vec::new()
    } else {
        let asked = fast.into_iter().chain(save.iter().copied());
        let told = restart.iter().copied().map(Step::Told);
        asked.map(Step::Asked).chain(told).collect()
    };
    let recovery = source.set(roles.bus_off_recovery, 1);
    let time = |milliseconds| source.set(roles.cyclic_time, milliseconds);
    let mode = |code| source.set(roles.cyclic_mode, code);
    let read = source.inclination();
    let filters = source.filters();
    // The first one is off. The others have the same order, and the first of these has the complex sections (Butterworth).
    let slowest_filter = filters.get(1).and_then(|on| on.settings.first()).copied();
    leak(Protocol {
        modules: &["plumbline::fsc::"],
        bus: if detects {
            BusRate::Fixed(BitRate::M1)
        } else {
            BusRate::Follow
        },
        preparation: preparation.leak(),
        boot_up: 2,
        begin: &[],
        online: millis(0),
        connection: &[],
        emergency: None,
        read,
        write: time(20).unwrap_or(read),
        read_code: 1,
        sync: Message(source.parameter(roles.sync_id).factory, &[]),
        sync_code: 1,
        filters: filters.leak(),
        slowest_filter,
        others: source.others().leak(),
        services: &[],
        j1939: None,
        cyclic: Vec::from_iter(time(5).into_iter().chain(mode(1))).leak(),
        not_cyclic: Vec::from_iter(mode(0)).leak(),
        set_up: Vec::from_iter(fast.into_iter().chain(recovery)).leak(),
        saves: save,
        saves_later: millis(0),
        load: source.operation(Operation::Load),
        restart,
    })
}

impl Source<'_> {
    fn parameter(&self, ParameterId(id): ParameterId) -> &Parameter {
        &self.product.parameters[usize::from(id)]
    }

    fn request(&self, code: u8, data: &[u8]) -> Message {
        let id = self.parameter(self.tables.roles.set_id).factory;
        Message(id, [&[code], data].concat().leak())
    }

    /// Writes the parameters of a code: their factory values, except where `number` has another one.
    fn write(&self, access: &Access, number: impl Fn(ParameterId) -> Option<u32>) -> Message {
        let mut data = Vec::new();
        for id in access.parameters {
            let parameter = self.parameter(*id);
            let bytes = number(*id).unwrap_or(parameter.factory).to_le_bytes();
            data.extend(&bytes[..usize::from(parameter.data_type.size())]);
        }
        self.request(access.write, &data)
    }

    /// Writes one parameter, and the factory values of those that have the same code.
    fn set(&self, id: ParameterId, number: u32) -> Option<Message> {
        let mut access = self.tables.access.iter();
        let access = access.find(|access| access.parameters.contains(&id))?;
        Some(self.write(access, |other| (other == id).then_some(number)))
    }

    /// The function with this operation and its signature; none without such a function.
    fn operation(&self, operation: Operation) -> &'static [Message] {
        let mut functions = self.tables.functions.iter();
        let function = functions.find(|function| function.operation == operation);
        let request = |function: &Function| self.request(function.code, function.signature);
        Vec::from_iter(function.map(request)).leak()
    }

    fn inclination(&self) -> Message {
        let mut functions = self.tables.functions.iter();
        let function = functions.find(|function| function.operation == Operation::Inclination);
        self.request(function.map_or(0, |function| function.code), &[])
    }

    /// The filters that a named parameter selects, each with the lowest and the highest cut-off frequency, and with that of the
    /// factory, at which the samples are measured.
    fn filters(&self) -> Vec<Filter> {
        let is_kind = |id: &&ParameterId| {
            let parameter = self.parameter(**id);
            is_filter(parameter) && parameter.permitted == Permitted::Named
        };
        let mut accesses = self.tables.access.iter();
        let found =
            accesses.find_map(|access| Some((access, *access.parameters.iter().find(is_kind)?)));
        let Some((access, kind)) = found else {
            return Vec::new();
        };
        let filter = |&(code, name): &(u32, &str)| {
            let write = |high: Option<bool>| {
                self.write(access, |id| match high {
                    _ if id == kind => Some(code),
                    Some(high) => self.end(id, (kind, code), high),
                    None => None,
                })
            };
            let row = format!("load_{}", name.to_lowercase().replace(' ', "_"));
            Some(Filter {
                settings: vec![write(Some(false)), write(Some(true)), write(None)].leak(),
                load: Row::find(&row)?.key,
            })
        };
        self.parameter(kind)
            .meanings
            .iter()
            .filter_map(filter)
            .collect()
    }

    /// The lowest or the highest value of a parameter, while another one has this value.
    fn end(&self, id: ParameterId, (kind, code): (ParameterId, u32), high: bool) -> Option<u32> {
        let Permitted::Range(lowest, highest) = self.parameter(id).permitted else {
            return None;
        };
        let limit = |constraint: &Constraint| match constraint.relation {
            Relation::AtMost {
                parameter,
                high,
                other,
                number,
            } if parameter == id && other == kind && u32::from(number) == code => Some(high.into()),
            _ => None,
        };
        let limits = self.product.constraints.iter().filter_map(limit);
        let highest = limits.fold(highest, i64::min);
        Some(if high { highest } else { lowest } as u32)
    }

    /// All functions that only reply, all codes that read and write parameters, the zero point from the present position, and an
    /// unknown code.
    fn others(&self) -> Vec<Message> {
        let Tables {
            access, functions, ..
        } = self.tables;
        let replies =
            |function: &&Function| !matches!(function.operation, Operation::Load | Operation::Save);
        let functions = functions.iter().filter(replies);
        let mut messages =
            Vec::from_iter(functions.map(|function| self.request(function.code, &[])));
        messages.extend(access.iter().map(|access| self.request(access.read, &[])));
        messages.extend(access.iter().map(|access| self.write(access, |_| None)));
        let adjustments = self.product.guide.zero.iter();
        for (id, written) in adjustments.flat_map(|adjustment| adjustment.writes) {
            let codes = || access.iter().filter(|access| access.parameters == [*id]);
            if *written == Written::Nothing {
                messages.extend(codes().map(|access| self.request(access.write, &[])));
            }
            // Another number than that of the factory.
            messages.extend(codes().map(|access| self.write(access, |_| Some(100))));
        }
        messages.push(self.request(UNKNOWN, &[]));
        messages
    }
}
