//! The messages of the scenario for a product with DeviceNet, made from its tables: explicit, poll, cyclic and change-of-state
//! connections.

use super::{Filter, Message, Protocol, Step, is_filter, leak};
use bench::BusRate;
use plumbline::devicenet::choice::{CHANGE, CYCLIC, EXPLICIT, POLL, SUPPRESS};
use plumbline::devicenet::identifiers::{group_2, group_2_id};
use plumbline::devicenet::service::{ALLOCATE, GET, RELEASE, RESET, SET};
use plumbline::devicenet::{Attribute, Source as Kind};
use plumbline::model::catalog::Product;
use plumbline::model::listing::devicenet::Tables;
use plumbline::param::{Parameter, ParameterId, Permitted};
use plumbline::time::millis;

/// The MAC ID of the master.
const MASTER: u8 = 0x0A;

/// Classes of the protocol.
const IDENTITY: u8 = 1;
const NETWORK: u8 = 3;
const ASSEMBLY: u8 = 4;
const CONNECTION: u8 = 5;
const ACKNOWLEDGE_HANDLER: u8 = 0x2B;

/// The data of a fragment of an explicit message.
const FRAGMENT: usize = 6;

/// A product whose messages are made.
struct Source<'a> {
    product: &'a Product,
    tables: &'a Tables,
}

/// The messages for a product.
pub(super) fn messages(product: &Product, tables: &Tables) -> &'static Protocol {
    let source = Source { product, tables };
    let rates = tables.roles.bit_rates.iter().enumerate();
    let fastest = rates.max_by_key(|(_, rate)| rate.bits_per_second());
    let fastest = fastest.map_or(0, |(code, _)| code as u8);
    // No connection times out.
    let lasting = |instance| source.explicit(&[SET, CONNECTION, instance, 9, 0, 0]);
    let poll = source.message(group_2::POLL, &[]);
    let written = source.written();
    let set = |(attribute, number)| source.set(attribute, number);
    let filters = source.filters();
    // All filters are on.
    let slowest_filter = filters.get(1).and_then(|on| on.settings.last()).copied();
    leak(Protocol {
        modules: &["plumbline::devicenet::"],
        bus: BusRate::Follow,
        preparation: vec![
            Step::Asked(source.explicit(&[SET, NETWORK, 1, 2, fastest])),
            Step::Asked(source.explicit(&[RESET, IDENTITY, 1])),
        ]
        .leak(),
        boot_up: 1,
        begin: &[],
        // Until the check for a duplicate MAC ID is over.
        online: millis(2200),
        connection: vec![
            source.message(
                group_2::UNCONNECTED,
                &[MASTER, ALLOCATE, NETWORK, 1, EXPLICIT | POLL, MASTER],
            ),
            lasting(1),
            lasting(2),
            // The first poll also ends the wait for it.
            poll,
        ]
        .leak(),
        emergency: None,
        read: source.read(),
        write: written.map_or(poll, |[factory, _]| set(factory)),
        // Header and service.
        read_code: 2,
        sync: poll,
        sync_code: 0,
        filters: filters.leak(),
        slowest_filter,
        others: source.others().leak(),
        services: &[],
        j1939: None,
        cyclic: vec![
            source.allocate(CYCLIC | SUPPRESS),
            source.explicit(&[SET, CONNECTION, 4, 9, 5, 0]),
        ]
        .leak(),
        not_cyclic: vec![source.release(CYCLIC)].leak(),
        // Recovery from bus-off.
        set_up: vec![source.explicit(&[SET, NETWORK, 1, 3, 1])].leak(),
        // A changed parameter is saved.
        saves: Vec::from_iter(
            written
                .into_iter()
                .flat_map(|[factory, other]| [set(other), set(factory)]),
        )
        .leak(),
        saves_later: millis(500),
        load: vec![source.explicit(&[RESET, IDENTITY, 1, 1])].leak(),
        restart: vec![source.explicit(&[RESET, IDENTITY, 1])].leak(),
    })
}

/// An attribute that can be set: its class, the attribute, its parameter.
#[derive(Clone, Copy)]
struct Settable<'a> {
    class: u8,
    number: u8,
    parameter: &'a Parameter,
}

impl Source<'_> {
    /// A message of group 2 to the factory MAC ID.
    fn message(&self, number: u16, data: &[u8]) -> Message {
        let ParameterId(mac_id) = self.tables.roles.mac_id;
        let mac_id = self.product.parameters[usize::from(mac_id)].factory;
        let id = group_2_id(mac_id as u8, number);
        Message(id.into(), data.to_vec().leak())
    }

    /// A request on the explicit connection.
    fn explicit(&self, body: &[u8]) -> Message {
        self.message(group_2::REQUEST, &[&[MASTER], body].concat())
    }

    fn get(&self, class: u8, instance: u8, attribute: u8) -> Message {
        self.explicit(&[GET, class, instance, attribute])
    }

    fn set(&self, attribute: Settable, number: u32) -> Message {
        let Settable {
            class,
            number: place,
            parameter,
        } = attribute;
        let size = usize::from(parameter.data_type.size());
        let data = &number.to_le_bytes()[..size];
        self.explicit(&[&[SET, class, 1, place], data].concat())
    }

    fn allocate(&self, choice: u8) -> Message {
        self.explicit(&[ALLOCATE, NETWORK, 1, choice, MASTER])
    }

    fn release(&self, choice: u8) -> Message {
        self.explicit(&[RELEASE, NETWORK, 1, choice])
    }

    /// The attributes of the vendor with their classes.
    fn attributes(&self) -> impl Iterator<Item = (u8, &Attribute)> {
        let objects = self.tables.objects.iter();
        objects.flat_map(|object| {
            object
                .attributes
                .iter()
                .map(|attribute| (object.class, attribute))
        })
    }

    /// The parameters that the master can set.
    fn settable(&self) -> impl Iterator<Item = Settable<'_>> {
        self.attributes()
            .filter_map(|(class, attribute)| match attribute.source {
                Kind::Parameter(ParameterId(id)) if attribute.settable => Some(Settable {
                    class,
                    number: attribute.number,
                    parameter: &self.product.parameters[usize::from(id)],
                }),
                _ => None,
            })
    }

    /// The parameters of a range with its ends.
    fn ranges(&self) -> impl Iterator<Item = (Settable<'_>, [u32; 2])> {
        self.settable().filter_map(|attribute| {
            let Permitted::Range(low, high) = attribute.parameter.permitted else {
                return None;
            };
            Some((attribute, [low as u32, high as u32]))
        })
    }

    /// Those of filters.
    fn filter_ranges(&self) -> impl Iterator<Item = (Settable<'_>, [u32; 2])> {
        self.ranges()
            .filter(|(attribute, _)| is_filter(attribute.parameter))
    }

    /// All filters off, then all just below their highest values: at the highest weight a recursive filter calculates nothing.
    fn filters(&self) -> Vec<Filter> {
        let filter = |load, number: fn([u32; 2]) -> u32| Filter {
            settings: self.set_filters(number).leak(),
            load,
        };
        let off = filter("load_off", |[low, _]| low);
        let on = filter("load_average", |[_, high]| high - 1);
        let on = (!on.settings.is_empty()).then_some(on);
        [off].into_iter().chain(on).collect()
    }

    /// Sets each filter to a number that follows from its lowest and highest values.
    fn set_filters(&self, number: fn([u32; 2]) -> u32) -> Vec<Message> {
        let filters = self.filter_ranges();
        let set = filters.map(|(attribute, ends)| self.set(attribute, number(ends)));
        set.collect()
    }

    /// Reads the first measured value.
    fn read(&self) -> Message {
        let mut attributes = self.attributes();
        let value = attributes.find(|(_, attribute)| matches!(attribute.source, Kind::Value(_)));
        value.map_or(self.get(IDENTITY, 1, 1), |(class, attribute)| {
            self.get(class, 1, attribute.number)
        })
    }

    /// A filter with its factory value and another one; without a filter, another parameter of a range.
    fn written(&self) -> Option<[(Settable<'_>, u32); 2]> {
        let mut found = self.filter_ranges().chain(self.ranges());
        found.next().map(|(attribute, [_, high])| {
            let factory = attribute.parameter.factory;
            let other = if factory < high {
                factory + 1
            } else {
                factory - 1
            };
            [(attribute, factory), (attribute, other)]
        })
    }

    /// Reads all attributes; the product name comes in fragments. Sets each parameter to all values that have a name, then to that of
    /// the factory.
    fn others(&self) -> Vec<Message> {
        let mut messages = Vec::new();
        messages.extend((1..=6).map(|attribute| self.get(IDENTITY, 1, attribute)));
        messages.push(self.get(IDENTITY, 1, 7));
        // The service, the length, and the name. The last fragment has no answer.
        let fragments = (2 + self.tables.identity.name.len()).div_ceil(FRAGMENT);
        for fragment in 1..fragments {
            let count = fragment as u8 - 1;
            messages.push(self.message(group_2::REQUEST, &[0x80 | MASTER, 0xC0 | count, 0]));
        }
        messages.extend((1..=5).map(|attribute| self.get(NETWORK, 1, attribute)));
        let assemblies = self.tables.assemblies.iter();
        messages.extend(assemblies.map(|assembly| self.get(ASSEMBLY, assembly.instance, 3)));
        messages.push(self.get(CONNECTION, 2, 14));
        messages.push(self.get(ACKNOWLEDGE_HANDLER, 1, 1));
        let attributes = self.attributes();
        messages.extend(attributes.map(|(class, attribute)| self.get(class, 1, attribute.number)));
        // Twice, so that each of them meets all settings of the others.
        for attribute in self.settable().chain(self.settable()) {
            let meanings = attribute.parameter.meanings.iter();
            messages.extend(meanings.map(|(number, _)| self.set(attribute, *number)));
        }
        messages.extend(
            self.settable()
                .map(|attribute| self.set(attribute, attribute.parameter.factory)),
        );
        // The filters at their highest values hold the angle, so a COS connection without acknowledgement compares the values and sends
        // no other message. Its first message follows the second answer.
        let hold = self.set_filters(|[_, high]| high);
        messages.extend(&hold);
        messages.push(self.allocate(CHANGE | SUPPRESS));
        messages.push(self.explicit(&[SET, CONNECTION, 4, 9, 0, 0]));
        messages.extend(&hold);
        messages.push(self.release(CHANGE));
        // An object that does not exist.
        messages.push(self.get(0x77, 1, 1));
        messages
    }
}
