//! The messages of the scenario for a product with CANopen, made from its tables: for a product without messages of its own.

use super::{Filter, Message, Protocol, Service, Step, leak};
use bench::BusRate;
use plumbline::can::BitRate;
use plumbline::canopen::dictionary::{Access, Object, Service as Provided, Target};
use plumbline::model::catalog::Product;
use plumbline::model::listing::canopen::Tables;
use plumbline::param::{ParameterId, Persistence};
use plumbline::time::millis;

/// The first index of the manufacturer's objects.
const MAKER: u16 = 0x2000;

/// The first TPDO: its communication parameter, and the sub-indices of the transmission type and the event timer.
const TPDO: u16 = 0x1800;
const TYPE: u8 = 2;
const TIMER: u8 = 5;

/// NMT: starts all nodes, resets all nodes.
const START: Message = Message(0x000, &[1, 0]);
const RESET: Message = Message(0x000, &[0x81, 0]);

/// The services that save, and that load factory values.
const SAVE: &[Provided] = &[Provided::Store, Provided::StoreGroup];
const LOAD: &[Provided] = &[Provided::RestoreCommunication, Provided::RestoreGroup];

/// A product whose messages are made.
struct Source<'a> {
    product: &'a Product,
    tables: &'a Tables,
}

/// The messages for a product.
pub(super) fn messages(product: &Product, tables: &Tables) -> &'static Protocol {
    let source = Source { product, tables };
    let filter = Filter {
        settings: &[],
        load: "load_off",
    };
    let [cyclic, not_cyclic] = source.cyclic();
    let node_id = source.node_id() as u16;
    let emergency = source.parameter(0x1014, 0).map(|_| 0x080 + node_id);
    let sync = source.parameter(0x1005, 0);
    let sync = sync.map_or(0x080, |id| source.factory(id) & 0x7FF);
    let mut load = source.command(LOAD, b"load");
    // Its reply is the boot-up message.
    load.push(RESET);
    leak(Protocol {
        modules: &["plumbline::canopen::"],
        bus: BusRate::Follow,
        preparation: steps(&source.preparation()),
        boot_up: 1,
        begin: &[START],
        online: millis(0),
        connection: &[],
        emergency,
        read: source.read(),
        write: source.written(),
        read_code: 4,
        sync: Message(sync, &[]),
        sync_code: 0,
        filters: vec![filter].leak(),
        slowest_filter: None,
        others: source.others().leak(),
        services: source.services(),
        j1939: None,
        cyclic,
        not_cyclic,
        set_up: &[],
        saves: source.command(SAVE, b"save").leak(),
        saves_later: millis(0),
        load: load.leak(),
        restart: &[],
    })
}

/// The messages with a reply, then the start, which has none.
fn steps(messages: &[Message]) -> &'static [Step] {
    let asked = messages.iter().map(|message| Step::Asked(*message));
    asked.chain([Step::Told(START)]).collect::<Vec<_>>().leak()
}

impl Source<'_> {
    fn factory(&self, ParameterId(id): ParameterId) -> u32 {
        self.product.parameters[usize::from(id)].factory
    }

    fn node_id(&self) -> u32 {
        self.factory(self.tables.node_id)
    }

    /// An SDO request.
    fn sdo(&self, data: [u8; 8]) -> Message {
        Message(0x600 + self.node_id(), data.to_vec().leak())
    }

    fn upload(&self, object: &Object) -> Message {
        let [low, high] = object.index.to_le_bytes();
        self.sdo([0x40, low, high, object.sub, 0, 0, 0, 0])
    }

    fn size(&self, object: &Object) -> u8 {
        let Product {
            parameters,
            quantities,
            ..
        } = self.product;
        object.data_type(parameters, quantities).size()
    }

    fn download(&self, object: &Object, value: u32) -> Message {
        let [low, high] = object.index.to_le_bytes();
        let [a, b, c, d] = value.to_le_bytes();
        let command = 0x23 | (4 - self.size(object).min(4)) << 2;
        self.sdo([command, low, high, object.sub, a, b, c, d])
    }

    fn object(&self, index: u16, sub: u8) -> Option<&Object> {
        let mut objects = self.tables.objects.iter();
        objects.find(|object| (object.index, object.sub) == (index, sub))
    }

    /// The parameter at an address.
    fn parameter(&self, index: u16, sub: u8) -> Option<ParameterId> {
        match self.object(index, sub)?.target {
            Target::Parameter(id) | Target::CobId(id) | Target::FreeCobId(id) => Some(id),
            _ => None,
        }
    }

    /// A write of an object, if it is a parameter that can be written.
    fn set(&self, index: u16, sub: u8, value: u32) -> Option<Message> {
        self.parameter(index, sub)?;
        let object = self.object(index, sub)?;
        (object.access == Access::Rw).then(|| self.download(object, value))
    }

    /// The bit rate, the first TPDO by SYNC, the others silent; then a save, if the product has one, and a reset of the node.
    fn preparation(&self) -> Vec<Message> {
        let mut messages = Vec::new();
        let is_rate = |object: &&Object| object.target == Target::Parameter(self.tables.bit_rate);
        let rate = self.tables.objects.iter().find(is_rate);
        let fast = self.tables.bit_rates.iter();
        let fast = fast.clone().find(|(_, rate)| *rate == BitRate::M1);
        if let (Some(object), Some((code, _))) = (rate, fast) {
            messages.push(self.download(object, *code));
        }
        messages.extend(self.set(TPDO, TYPE, 1));
        for index in (TPDO + 1..).take_while(|index| self.object(*index, 1).is_some()) {
            messages.extend(self.set(index, TIMER, 0));
            messages.extend(self.set(index, TYPE, 254));
        }
        messages.extend(self.command(SAVE, b"save"));
        messages.push(RESET);
        messages
    }

    /// Switches the event timer of the first TPDO on, and off.
    fn cyclic(&self) -> [&'static [Message]; 2] {
        let on = [self.set(TPDO, TIMER, 5), self.set(TPDO, TYPE, 254)];
        let off = self.set(TPDO, TYPE, 1);
        match on {
            [Some(timer), Some(own)] => [vec![timer, own].leak(), Vec::from_iter(off).leak()],
            _ => [&[], &[]],
        }
    }

    /// Reads the first measured value.
    fn read(&self) -> Message {
        let is_value = |object: &&Object| matches!(object.target, Target::Value(_));
        let mut objects = self.tables.objects.iter();
        let value = objects.find(is_value).unwrap_or(&self.tables.objects[0]);
        self.upload(value)
    }

    /// Writes the event timer of the first TPDO, or another parameter.
    fn written(&self) -> Message {
        let timer = self.set(TPDO, TIMER, 20);
        let other = || self.writes().into_iter().next();
        timer.or_else(other).unwrap_or_else(|| self.read())
    }

    /// Writes the factory value into each parameter of the manufacturer and of the device profile, except what moves the node to another
    /// address, bit rate or protocol.
    fn writes(&self) -> Vec<Message> {
        let selector = self.tables.j1939.as_ref().and_then(|j1939| j1939.selector);
        let moving = [
            Some(self.tables.node_id),
            Some(self.tables.bit_rate),
            selector.map(|(id, _)| id),
        ];
        let is_written = |object: &&Object| match object.target {
            Target::Parameter(id) => {
                let persistence = self.product.parameters[usize::from(id.0)].persistence;
                object.index >= MAKER
                    && object.access.is_writable()
                    && (1..=4).contains(&self.size(object))
                    && persistence != Persistence::AtOnce
                    && !moving.contains(&Some(id))
            }
            _ => false,
        };
        let objects = self.tables.objects.iter().filter(is_written);
        let write = |object: &Object| match object.target {
            Target::Parameter(id) => self.download(object, self.factory(id)),
            _ => self.upload(object),
        };
        objects.map(write).collect()
    }

    /// Reads every object, the first segment of each text, and an object that does not exist; writes all parameters.
    fn others(&self) -> Vec<Message> {
        let mut messages = Vec::new();
        for object in self.tables.objects {
            messages.push(self.upload(object));
            if self.size(object) == 0 {
                messages.push(self.sdo([0x60, 0, 0, 0, 0, 0, 0, 0]));
            }
        }
        messages.push(self.sdo([0x40, 0x77, 0x77, 0, 0, 0, 0, 0]));
        messages.extend(self.set(0x1017, 0, 0));
        messages.extend(self.writes());
        messages
    }

    /// The LSS inquiry of the node-ID, in the state LSS configuration.
    fn services(&self) -> &'static [Service] {
        const SWITCH: [[u8; 8]; 2] = [[0x04, 1, 0, 0, 0, 0, 0, 0], [0x04, 0, 0, 0, 0, 0, 0, 0]];
        const LSS: u32 = 0x7E5;
        if !self.tables.lss {
            return &[];
        }
        &[Service {
            row: "lss_median",
            before: &[Step::Told(Message(LSS, &SWITCH[0]))],
            message: Message(LSS, &[0x5E, 0, 0, 0, 0, 0, 0, 0]),
            after: &[Step::Told(Message(LSS, &SWITCH[1]))],
        }]
    }

    /// The first object with one of these services, written with its signature; none without such an object.
    fn command(&self, services: &[Provided], signature: &[u8; 4]) -> Vec<Message> {
        let is_one = |object: &&Object| object.service().is_some_and(|own| services.contains(&own));
        let object = self.tables.objects.iter().find(is_one);
        let write = |object| self.download(object, u32::from_le_bytes(*signature));
        Vec::from_iter(object.map(write))
    }
}
