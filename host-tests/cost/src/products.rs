//! The measured products, and the messages of the scenario. They are made from the tables of a product. For two products with CANopen they
//! are written, with the filters and services that only these have (`ims360`, `jn2101`).

mod canopen;
mod devicenet;
mod fsc;
mod ims360;
mod j1939;
mod jn2101;

use bench::BusRate;
use ims360::IMS360;
use jn2101::JN2101;
use plumbline::can::{Frame, extended, standard};
use plumbline::canopen::dictionary::Object;
use plumbline::model::catalog::{self, Product, bases};
use plumbline::param::Parameter;
use plumbline::time::Duration;
use stm32_sim::board::Board;

/// A message of the tester: an identifier, of 29 bits above 7FFh, and data.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Message(pub u32, pub &'static [u8]);

impl Message {
    /// The message as a frame.
    ///
    /// # Panics
    /// An invalid identifier or data length; messages are constants.
    pub fn frame(self) -> Frame {
        let frame = match u16::try_from(self.0) {
            Ok(id) if id <= 0x7FF => Frame::data(standard(id), self.1),
            _ => Frame::data(extended(self.0), self.1),
        };
        frame.expect("at most eight bytes")
    }

    /// Whether these objects contain the object of the SDO request.
    fn names(self, objects: &[Object]) -> bool {
        let [_, low, high, sub, ..] = *self.1 else {
            return false;
        };
        let address = (u16::from_le_bytes([low, high]), sub);
        let mut objects = objects.iter();
        objects.any(|object| (object.index, object.sub) == address)
    }
}

/// A filter setting, and the row that it fills.
#[derive(Clone, Copy, Debug)]
pub struct Filter {
    /// The messages that set it, with different frequencies. The load is that of the last one.
    pub settings: &'static [Message],
    /// The row of its load.
    pub load: &'static str,
}

/// A message of a sequence.
#[derive(Clone, Copy, Debug)]
pub enum Step {
    /// It has a reply of one frame.
    Asked(Message),
    /// The sensor does not reply to it.
    Told(Message),
}

/// Messages with a reply of one frame each.
const fn asked<const N: usize>(messages: [Message; N]) -> [Step; N] {
    let mut steps = [Step::Asked(Message(0, &[])); N];
    let mut place = 0;
    while place < N {
        steps[place] = Step::Asked(messages[place]);
        place += 1;
    }
    steps
}

/// Messages made from tables, in the form of those that are constants.
fn leak(protocol: Protocol) -> &'static Protocol {
    Box::leak(Box::new(protocol))
}

/// Whether a parameter sets a filter of the measurement: its name says so.
fn is_filter(parameter: &Parameter) -> bool {
    parameter.name.to_lowercase().contains("filter")
}

/// A request within a sequence, and the row that it fills.
#[derive(Clone, Copy, Debug)]
pub struct Service {
    /// The row of the request.
    pub row: &'static str,
    /// The messages before the request.
    pub before: &'static [Step],
    /// The request, whose reply is one frame.
    pub message: Message,
    /// The messages after its reply.
    pub after: &'static [Step],
}

/// The messages of the scenario in J1939. The sensor has its address at 1 Mbit/s.
#[derive(Clone, Copy, Debug)]
pub struct J1939 {
    /// Requests of the other protocol. The last one restarts the sensor, which claims its address.
    pub change: &'static [Message],
    /// Switches the process data off.
    pub off: Message,
    /// Switches SSI2 on, every 10 ms.
    pub on: Message,
    /// A claim of its address with a higher NAME, which it answers with its own claim.
    pub contention: Message,
    /// Each row of a request to its answer of one frame.
    pub requests: &'static [(&'static str, Message)],
}

/// The messages of the scenario in a protocol. Each of them has a reply of one frame, unless stated otherwise.
#[derive(Clone, Copy, Debug)]
pub struct Protocol {
    /// The paths of its code in core.
    pub modules: &'static [&'static str],
    /// The bit rate of the wire; 1 Mbit/s after the preparation.
    pub bus: BusRate,
    /// Messages after which a sensor with blank memory answers a synchronous message with one frame.
    pub preparation: &'static [Step],
    /// Boot-up messages after each start.
    pub boot_up: usize,
    /// Messages without a reply after a start with saved parameters, so that the sensor answers the synchronous message.
    pub begin: &'static [Message],
    /// The time from the first boot-up message until the sensor answers requests.
    pub online: Duration,
    /// Requests before all others after each start: they allocate connections.
    pub connection: &'static [Message],
    /// The identifier of frames that report faults, which are not replies.
    pub emergency: Option<u16>,
    /// Requests the inclination, the most frequent request.
    pub read: Message,
    /// Writes a parameter to RAM.
    pub write: Message,
    /// The first bytes of its reply that tell it from other replies.
    pub read_code: usize,
    /// A synchronous message, whose reply contains the angles.
    pub sync: Message,
    /// The first bytes of its reply that tell it from other frames of this identifier.
    pub sync_code: usize,
    /// All filters of the product.
    pub filters: &'static [Filter],
    /// Sets the filter with the longest computing time; None: the product has one filter.
    pub slowest_filter: Option<Message>,
    /// All other requests of the protocol.
    pub others: &'static [Message],
    /// Requests that need other messages before and after them.
    pub services: &'static [Service],
    /// The messages of J1939, if the product has this protocol as well.
    pub j1939: Option<&'static J1939>,
    /// Switches cyclic mode on; empty: the product has none.
    pub cyclic: &'static [Message],
    /// Switches cyclic mode off.
    pub not_cyclic: &'static [Message],
    /// Settings for a start at 1 Mbit/s, recovery from bus-off, and the activity during a save.
    pub set_up: &'static [Message],
    /// Each of these messages saves the parameters. They are sent in turn. Empty: the product stores nothing.
    pub saves: &'static [Message],
    /// The time from the answer to the end of a save that begins later.
    pub saves_later: Duration,
    /// Loads the factory values of all parameters.
    pub load: &'static [Message],
    /// Restarts the sensor; the boot-up messages follow.
    pub restart: &'static [Message],
}

/// A product that is measured.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredProduct {
    /// The name of its figures: that of the product, on the Nucleo with a prefix.
    pub label: &'static str,
    /// The board that runs its image.
    pub board: Board,
    /// Its name, and that of its image.
    pub name: &'static str,
    /// The messages of its protocol.
    pub protocol: &'static Protocol,
    /// The times of its answers are measured also against saves and boot: products with CANopen, and one with FSC, which has two axes
    /// and no heater.
    pub swept: bool,
    /// The set point of its heater in 0.01 degC; None if it has none.
    pub set_point: Option<i16>,
}

impl MeasuredProduct {
    /// A product that is measured with these messages, on the Blue Pill.
    pub fn with(product: &Product, protocol: &'static Protocol) -> Self {
        let saves = !protocol.saves.is_empty();
        Self {
            label: product.name,
            board: Board::BluePill,
            name: product.name,
            protocol,
            swept: match product.protocol {
                catalog::Protocol::Fsc(_) => {
                    product.heater.is_none() && product.quantities.len() == 2
                }
                catalog::Protocol::Canopen(_) => saves,
                catalog::Protocol::Devicenet(_) | catalog::Protocol::J1939(_) => false,
            },
            set_point: product.heater.map(|heater| heater.set_point),
        }
    }

    /// A product with the messages that are written for it, otherwise with those made from its tables.
    pub fn of(product: &Product) -> Self {
        let protocol = match &product.protocol {
            catalog::Protocol::Fsc(tables) => fsc::messages(product, tables),
            catalog::Protocol::Devicenet(tables) => devicenet::messages(product, tables),
            catalog::Protocol::J1939(tables) => j1939::messages(product, tables),
            catalog::Protocol::Canopen(tables) => {
                let is_written = |own: &&'static Protocol| {
                    let node_id = product.parameters[usize::from(tables.node_id.0)].factory;
                    let Message(id, _) = own.write;
                    let both = own.j1939.is_some() == tables.j1939.is_some();
                    let filter = own.slowest_filter;
                    both && id == 0x600 + node_id
                        && filter.is_some_and(|message| message.names(tables.objects))
                };
                let mut written = [&JN2101, &IMS360].into_iter();
                let found = written.find(is_written);
                found.unwrap_or_else(|| canopen::messages(product, tables))
            }
        };
        Self::with(product, protocol)
    }
}

/// The figures on the Nucleo, and their products.
const ON_NUCLEO: [(&str, &str); 3] = [
    ("nucleo-is2", "is2"),
    ("nucleo-jn2101", "jn2101"),
    ("nucleo-ims360", "ims360"),
];

/// The product whose figures on the Nucleo have this label.
fn on_nucleo((label, name): (&'static str, &'static str)) -> Option<MeasuredProduct> {
    let product = find(name)?;
    Some(MeasuredProduct {
        label,
        board: Board::NucleoF446,
        swept: false,
        ..product
    })
}

/// Every product that has figures of its own: not those that differ from an earlier one of the catalogue only by constants. The
/// products that are measured on the Nucleo follow.
pub fn all() -> Vec<MeasuredProduct> {
    let on_nucleo = ON_NUCLEO.into_iter().filter_map(on_nucleo);
    bases().map(MeasuredProduct::of).chain(on_nucleo).collect()
}

/// The product of this name.
pub fn find(name: &str) -> Option<MeasuredProduct> {
    catalog::find(name).map(MeasuredProduct::of)
}

/// The product of this name on the Blue Pill, or on the Nucleo if it is measured there.
pub fn of_model(name: &str, nucleo: bool) -> Option<MeasuredProduct> {
    if !nucleo {
        return find(name);
    }
    let mut measured = ON_NUCLEO.into_iter();
    measured
        .find(|(_, product)| *product == name)
        .and_then(on_nucleo)
}

#[cfg(test)]
mod tests {
    use super::super::recorded::Recorded;
    use super::super::rows::ROWS;
    use super::*;

    /// A filter that is not found is not measured, and the answers are not those with the slowest filter.
    #[test]
    fn messages_set_each_filter_whose_load_is_recorded() {
        let recorded = Recorded::of_the_project().expect("the file is valid");
        for product in all() {
            let is_load = |key: &str| key.starts_with("load_");
            let rows = ROWS.iter().filter(|row| is_load(row.key));
            let expected = rows.filter(|row| recorded.of(product.label, row).is_some());
            let mut expected: Vec<&str> = expected.map(|row| row.key).collect();
            let filters = product.protocol.filters.iter();
            let mut measured: Vec<&str> = filters.map(|filter| filter.load).collect();
            expected.sort_unstable();
            measured.sort_unstable();
            assert_eq!(measured, expected, "{}", product.label);
            let slowest = product.protocol.slowest_filter;
            assert_eq!(slowest.is_some(), measured.len() > 1, "{}", product.label);
        }
    }

    #[test]
    fn product_that_differs_by_constants_is_not_measured() {
        let measured: Vec<&str> = all().into_iter().map(|product| product.label).collect();
        for name in ["is1", "is2", "is1dm", "is2dm", "jn2101", "nucleo-ims360"] {
            assert!(measured.contains(&name), "{name}");
        }
        for name in ["is1d", "is2d", "is2tk"] {
            assert!(!measured.contains(&name), "{name}");
        }
    }
}
