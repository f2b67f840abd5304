//! The measured products, the messages of their protocol, and the functions in their images.

use super::function::{Angles, FIR_STEP, STEP, TUNE};
use bench::BusRate;
use plumbline::can::{BitRate, Frame, standard};
use plumbline::model::catalog::{self, PRODUCTS, Product, Settings, Start, start, with};
use plumbline::node::Node;
use std::any::TypeId;
use stm32_sim::chip::Chip;

/// A message of the tester: an 11-bit identifier and data.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Message(pub u16, pub &'static [u8]);

impl Message {
    /// The message as a frame.
    ///
    /// # Panics
    /// An invalid identifier or data length; messages are constants.
    pub fn frame(self) -> Frame {
        Frame::data(standard(self.0), self.1).expect("at most eight bytes")
    }
}

/// A filter setting, and the rows that it fills.
#[derive(Clone, Copy, Debug)]
pub struct Filter {
    /// The messages that set it, with different frequencies. Samples are counted with the last one.
    pub settings: &'static [Message],
    /// The row of its samples.
    pub sample: &'static str,
    /// The row of one step of the low-pass, and its function.
    pub step: Option<(&'static str, &'static str)>,
    /// The row of a change of the setting, and its function.
    pub tune: Option<(&'static str, &'static str)>,
}

/// The messages of the scenario in a protocol. Each of them has a reply of one frame, unless stated otherwise.
#[derive(Clone, Copy, Debug)]
pub struct Protocol {
    /// The path of its code in core.
    pub module: &'static str,
    /// The bit rate of the wire; 1 Mbit/s after the preparation.
    pub bus: BusRate,
    /// Messages after which a sensor with blank memory answers a synchronous message with one frame.
    pub preparation: &'static [Message],
    /// Boot-up messages after each start.
    pub boot_up: usize,
    /// The identifier of frames that report faults, which are not replies.
    pub emergency: Option<u16>,
    /// Requests the inclination.
    pub read: Message,
    /// Writes a parameter.
    pub write: Message,
    /// The first bytes of its reply that tell it from other replies.
    pub read_code: usize,
    /// A synchronous message, whose reply contains the angles.
    pub sync: Message,
    /// The first bytes of its reply that tell it from other frames of this identifier.
    pub sync_code: usize,
    /// A request that is answered before the first measurement; its reply begins with as many bytes as that of `read`.
    pub starting: Message,
    /// Each filter.
    pub filters: &'static [Filter],
    /// Sets the filter with the longest computing time.
    pub slowest_filter: Message,
    /// All other requests of the protocol.
    pub others: &'static [Message],
    /// Switches cyclic mode on.
    pub cyclic: &'static [Message],
    /// Switches cyclic mode off.
    pub not_cyclic: Message,
    /// Settings for a start at 1 Mbit/s, recovery from bus-off, and the activity during a save.
    pub set_up: &'static [Message],
    /// Saves the parameters.
    pub save: Message,
    /// Loads the factory values.
    pub load: Message,
    /// Restarts the sensor; the boot-up messages follow.
    pub restart: Message,
}

/// A product that is measured.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredProduct {
    /// The name of its figures: that of the product, on the Nucleo with a prefix.
    pub label: &'static str,
    /// The microcontroller that runs its image.
    pub chip: Chip,
    /// Its name, and that of its image.
    pub name: &'static str,
    /// Its protocol.
    pub protocol: &'static Protocol,
    /// The functions that calculate its angles.
    pub angles: Angles,
    /// The times of its answers are measured also against saves and boot: one product of each protocol.
    pub swept: bool,
}

impl From<&Product> for MeasuredProduct {
    fn from(product: &Product) -> Self {
        let axes = with(product.name, &Settings::default(), |node| node.readout());
        let has_y = axes.is_some_and(|readout| readout.y.is_some());
        Self {
            label: product.name,
            chip: Chip::F103,
            name: product.name,
            swept: ["is2", "jn2101"].contains(&product.name),
            protocol: match product.protocol {
                catalog::Protocol::Fsc(_) => &FSC,
                catalog::Protocol::Canopen(_) => &CANOPEN,
            },
            angles: if has_y {
                Angles::TWO_AXES
            } else {
                Angles::ONE_AXIS
            },
        }
    }
}

/// The figures on the Nucleo, and their products.
const ON_NUCLEO: [(&str, &str); 2] = [("nucleo-is2", "is2"), ("nucleo-jn2101", "jn2101")];

/// The product whose figures on the Nucleo have this label.
fn on_nucleo((label, name): (&'static str, &'static str)) -> Option<MeasuredProduct> {
    let product = MeasuredProduct::from(catalog::find(name)?);
    Some(MeasuredProduct {
        label,
        chip: Chip::F446,
        swept: false,
        ..product
    })
}

/// Every product that has its own figures: not those that differ from a budgeted product only by constants. Then those with budgets on
/// the Nucleo.
pub fn all(is_budgeted: impl Fn(&str) -> bool) -> Vec<MeasuredProduct> {
    let own = |product: &&Product| {
        let other = budgeted(product.name, &is_budgeted);
        other.is_none_or(|other| other == product.name)
    };
    let mut measured: Vec<_> = PRODUCTS
        .iter()
        .filter(own)
        .map(MeasuredProduct::from)
        .collect();
    let on_nucleo = ON_NUCLEO.into_iter().filter_map(on_nucleo);
    measured.extend(on_nucleo.filter(|product| is_budgeted(product.label)));
    measured
}

/// The product whose budgets hold for the product of this name: itself, or another one with the same node, from which it differs
/// only by constants. None if there is no such product.
pub fn budgeted(name: &str, is_budgeted: impl Fn(&str) -> bool) -> Option<&'static str> {
    let products = PRODUCTS.iter().map(|product| product.name);
    let mut candidates = products.filter(|other| is_budgeted(other) && node(other) == node(name));
    let own = candidates.clone().find(|other| *other == name);
    own.or_else(|| candidates.next())
}

/// The type of the node of a product.
fn node(name: &str) -> Option<TypeId> {
    struct Type;

    impl Start for Type {
        type Output = TypeId;

        fn start<N: Node + 'static>(self, _: N) -> TypeId {
            TypeId::of::<N>()
        }
    }

    start(name, &Settings::default(), Type)
}

/// The product of this name.
pub fn find(name: &str) -> Option<MeasuredProduct> {
    catalog::find(name).map(MeasuredProduct::from)
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

/// A request with the factory's Set-Parameter-ID.
const fn request(data: &'static [u8]) -> Message {
    Message(0x300, data)
}

/// The Butterworth filter at 0.1 Hz.
const BUTTERWORTH: Message = request(&[0x27, 0x64, 0x00, 1]);

/// GEMAC's function select codes (table 17 of the manual). A one-axis product refuses the two writes to its second angle; this is
/// also a reply.
const FSC: Protocol = Protocol {
    module: "plumbline::fsc::",
    // The sensor detects the bit rate.
    bus: BusRate::Fixed(BitRate::M1),
    preparation: &[],
    boot_up: 2,
    emergency: None,
    read: request(&[0x00]),
    // Cyclic time 20 ms.
    write: request(&[0x25, 20, 0]),
    read_code: 1,
    sync: Message(0x100, &[]),
    sync_code: 1,
    starting: request(&[0x00]),
    filters: &[
        Filter {
            settings: &[request(&[0x27, 0xD0, 0x07, 0])],
            sample: "sample_off",
            step: None,
            tune: None,
        },
        // 0.1 Hz, 25 Hz, and 2 Hz, at which the samples are measured.
        Filter {
            settings: &[
                BUTTERWORTH,
                request(&[0x27, 0xA8, 0x61, 1]),
                request(&[0x27, 0xD0, 0x07, 1]),
            ],
            sample: "sample_butterworth",
            step: Some(("step_butterworth", STEP)),
            tune: Some(("tune_butterworth", TUNE)),
        },
        // 0.1 Hz, 8 Hz, 2 Hz.
        Filter {
            settings: &[
                request(&[0x27, 0x64, 0x00, 2]),
                request(&[0x27, 0x40, 0x1F, 2]),
                request(&[0x27, 0xD0, 0x07, 2]),
            ],
            sample: "sample_critically_damped",
            step: Some(("step_critically_damped", STEP)),
            tune: Some(("tune_critically_damped", TUNE)),
        },
    ],
    slowest_filter: BUTTERWORTH,
    others: &[
        request(&[0x02]),
        request(&[0x03]),
        request(&[0x04]),
        request(&[0x10]),
        request(&[0x11]),
        request(&[0x12]),
        request(&[0x13]),
        request(&[0x14]),
        request(&[0x15]),
        request(&[0x16]),
        request(&[0x17]),
        request(&[0x18]),
        request(&[0x19]),
        request(&[0x20, 0x00, 0x03, 0, 0]),
        request(&[0x21, 0x01, 0x03, 0, 0]),
        request(&[0x22, 0x00, 0x01, 0, 0]),
        // Automatic zero point adjustment, then a number.
        request(&[0x28]),
        request(&[0x29]),
        request(&[0x28, 0x64, 0x00]),
        request(&[0x29, 0x64, 0x00]),
        request(&[0xFF]),
        // An unknown code.
        request(&[0x77]),
    ],
    cyclic: &[request(&[0x25, 5, 0]), request(&[0x26, 1])],
    not_cyclic: request(&[0x26, 0]),
    set_up: &[request(&[0x23, 9]), request(&[0x24, 1])],
    save: request(&[0x50, b'S', b'A', b'V', b'E']),
    load: request(&[0x40, b'L', b'O', b'A', b'D']),
    restart: request(&[0xFF, b'R', b'E', b'S', b'E', b'T']),
};

/// An SDO request to the factory node id of the JN2101.
const fn sdo(data: &'static [u8; 8]) -> Message {
    Message(0x60A, data)
}

/// "save" to 1010h:01.
const SAVE: Message = sdo(b"\x23\x10\x10\x01save");

/// The FIR filter at 10 Hz (2043h).
const TEN_HERTZ: Message = sdo(&[0x2F, 0x43, 0x20, 0, 1, 0, 0, 0]);

const fn fir(setting: &'static [Message], sample: &'static str) -> Filter {
    Filter {
        settings: setting,
        sample,
        step: Some(("step_fir", FIR_STEP)),
        tune: None,
    }
}

/// CANopen with the objects of the JN2101 (section 14 of its manual).
const CANOPEN: Protocol = Protocol {
    module: "plumbline::canopen::",
    bus: BusRate::Follow,
    preparation: &[
        // 1000 kbit/s.
        sdo(&[0x2B, 0x01, 0x20, 0, 0xE8, 0x03, 0, 0]),
        // Operational after each boot-up message.
        sdo(&[0x23, 0x80, 0x1F, 0, 8, 0, 0, 0]),
        // The second TPDO by its timer only, which is switched off.
        sdo(&[0x2B, 0x01, 0x18, 5, 0, 0, 0, 0]),
        sdo(&[0x2F, 0x01, 0x18, 2, 254, 0, 0, 0]),
        SAVE,
        // Reset node, after which both settings are in effect.
        Message(0x000, &[0x81, 0]),
    ],
    boot_up: 1,
    emergency: Some(0x08A),
    // Longitudinal, 16 bits.
    read: sdo(&[0x40, 0x10, 0x60, 0, 0, 0, 0, 0]),
    // The timer of the first TPDO, 20 ms; it is effective only with another transmission type.
    write: sdo(&[0x2B, 0x00, 0x18, 5, 20, 0, 0, 0]),
    // Command, index and subindex.
    read_code: 4,
    sync: Message(0x080, &[]),
    sync_code: 0,
    // The device type.
    starting: sdo(&[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]),
    filters: &[
        Filter {
            settings: &[sdo(&[0x2F, 0x43, 0x20, 0, 0, 0, 0, 0])],
            sample: "sample_off",
            step: None,
            tune: None,
        },
        fir(&[TEN_HERTZ], "sample_fir_10"),
        fir(&[sdo(&[0x2F, 0x43, 0x20, 0, 2, 0, 0, 0])], "sample_fir_5"),
        fir(&[sdo(&[0x2F, 0x43, 0x20, 0, 3, 0, 0, 0])], "sample_fir_1"),
        fir(
            &[sdo(&[0x2F, 0x43, 0x20, 0, 4, 0, 0, 0])],
            "sample_fir_half",
        ),
    ],
    slowest_filter: TEN_HERTZ,
    others: &[
        sdo(&[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x01, 0x10, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x03, 0x10, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x05, 0x10, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x18, 0x10, 1, 0, 0, 0, 0]),
        sdo(&[0x40, 0x18, 0x10, 4, 0, 0, 0, 0]),
        sdo(&[0x40, 0x20, 0x60, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x10, 0x61, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x20, 0x61, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x80, 0x40, 0, 0, 0, 0, 0]),
        sdo(&[0x40, 0x81, 0x40, 0, 0, 0, 0, 0]),
        // The programming key, in segments; the last request is beyond its end.
        sdo(&[0x40, 0x00, 0x30, 0, 0, 0, 0, 0]),
        sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x70, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x70, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x70, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x70, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]),
        sdo(&[0x70, 0, 0, 0, 0, 0, 0, 0]),
        // Terminating resistor and heating, off and on.
        sdo(&[0x2F, 0x45, 0x20, 0, 0, 0, 0, 0]),
        sdo(&[0x2F, 0x45, 0x20, 0, 1, 0, 0, 0]),
        sdo(&[0x2F, 0x41, 0x20, 0, 0, 0, 0, 0]),
        sdo(&[0x2F, 0x41, 0x20, 0, 1, 0, 0, 0]),
        // All other angle definitions, then that of the factory.
        sdo(&[0x2F, 0x44, 0x20, 0, 1, 0, 0, 0]),
        sdo(&[0x2F, 0x44, 0x20, 0, 2, 0, 0, 0]),
        sdo(&[0x2F, 0x44, 0x20, 0, 3, 0, 0, 0]),
        sdo(&[0x2F, 0x44, 0x20, 0, 0, 0, 0, 0]),
        // Teach-in and zero point, on and off.
        sdo(&[0x2F, 0x42, 0x20, 0, 1, 0, 0, 0]),
        sdo(&[0x2F, 0x42, 0x20, 0, 2, 0, 0, 0]),
        sdo(&[0x2F, 0x46, 0x20, 0, 1, 0, 0, 0]),
        sdo(&[0x2F, 0x46, 0x20, 0, 2, 0, 0, 0]),
        // Heartbeat, off.
        sdo(&[0x2B, 0x17, 0x10, 0, 0, 0, 0, 0]),
        // An object that does not exist.
        sdo(&[0x40, 0x77, 0x77, 0, 0, 0, 0, 0]),
    ],
    // The first TPDO every 5 ms.
    cyclic: &[
        sdo(&[0x2B, 0x00, 0x18, 5, 5, 0, 0, 0]),
        sdo(&[0x2F, 0x00, 0x18, 2, 254, 0, 0, 0]),
    ],
    not_cyclic: sdo(&[0x2F, 0x00, 0x18, 2, 1, 0, 0, 0]),
    // The self-test, which runs during the saves.
    set_up: &[sdo(&[0x2F, 0x04, 0x40, 1, 1, 0, 0, 0])],
    save: SAVE,
    load: sdo(b"\x23\x11\x10\x01load"),
    restart: sdo(&[0x2F, 0x02, 0x20, 0, 1, 0, 0, 0]),
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn product_that_differs_by_constants_has_budgets_of_another() {
        let has = |name: &str| ["is1", "is2tk"].contains(&name);
        assert_eq!(budgeted("is1", has), Some("is1"));
        assert_eq!(budgeted("is1d", has), Some("is1"));
        assert_eq!(budgeted("is2dm", has), Some("is2tk"));
        // Another node, so it needs budgets of its own.
        for name in ["is2", "is1tk", "jn2101"] {
            assert_eq!(budgeted(name, has), None);
        }
        let measured = all(has).into_iter().map(|product| product.name);
        let without = ["is1d", "is2dm"];
        assert!(measured.clone().all(|name| !without.contains(&name)));
        assert_eq!(measured.count(), PRODUCTS.len() - without.len());
    }
}
