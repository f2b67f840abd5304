//! What is measured: the models, the messages of their protocol, and the functions in their images.

use super::function::{Angles, NodeFunctions};
use plumbline::can::{Frame, standard};

/// A message of the tester: an 11-bit identifier and data.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Message(pub u16, pub &'static [u8]);

impl Message {
    /// As a frame.
    ///
    /// # Panics
    /// With an identifier or data that no frame has; these are constants.
    pub fn frame(self) -> Frame {
        Frame::data(standard(self.0), self.1).expect("at most eight bytes")
    }
}

/// What the scenario says in a protocol. Each of these messages is answered by one frame, if nothing else is said.
#[derive(Clone, Copy, Debug)]
pub struct Protocol {
    /// The functions of its node.
    pub node: NodeFunctions,
    /// Boot-up messages after each start.
    pub boot_up: usize,
    /// Asks for the inclination.
    pub read: Message,
    /// Writes a parameter.
    pub write: Message,
    /// Is answered with the angles, synchronously.
    pub sync: Message,
    /// Switches the filter off.
    pub filter_off: Message,
    /// Switches the Butterworth filter on, with different frequencies.
    pub butterworth: [Message; 3],
    /// Switches the critically damped filter on, with different frequencies.
    pub critically_damped: [Message; 3],
    /// Every other request that is there.
    pub others: &'static [Message],
    /// Cyclic mode on.
    pub cyclic: &'static [Message],
    /// Cyclic mode off.
    pub not_cyclic: Message,
    /// What the sensor needs to start at 1 Mbit/s and to recover from bus-off.
    pub set_up: &'static [Message],
    /// Saves the parameters.
    pub save: Message,
    /// Loads the factory values.
    pub load: Message,
    /// Restarts the sensor; this is answered by the boot-up messages only.
    pub restart: Message,
}

/// A model.
#[derive(Clone, Copy, Debug)]
pub struct Subject {
    /// Its name, and that of its image.
    pub name: &'static str,
    /// What it speaks.
    pub protocol: &'static Protocol,
    /// The functions that make its angles.
    pub angles: Angles,
}

/// Every model that is measured.
pub const SUBJECTS: &[Subject] = &[
    subject("is1", &FSC, Angles::ONE_AXIS),
    subject("is2", &FSC, Angles::TWO_AXES),
    subject("is1d", &FSC, Angles::ONE_AXIS),
    subject("is2d", &FSC, Angles::TWO_AXES),
];

const fn subject(name: &'static str, protocol: &'static Protocol, angles: Angles) -> Subject {
    Subject {
        name,
        protocol,
        angles,
    }
}

/// The model of this name.
pub fn find(name: &str) -> Option<&'static Subject> {
    SUBJECTS.iter().find(|subject| subject.name == name)
}

/// A request on the factory's Set-Parameter-ID.
const fn request(data: &'static [u8]) -> Message {
    Message(0x300, data)
}

/// GEMAC's function select codes (table 17 of the manual). One axis refuses the writes of two bytes to its second angle, which
/// is an answer too.
const FSC: Protocol = Protocol {
    node: NodeFunctions {
        receive: "Node for plumbline::fsc::sensor::Sensor<M>>::receive",
        poll: "Node for plumbline::fsc::sensor::Sensor<M>>::poll",
        transmit: "Node for plumbline::fsc::sensor::Sensor<M>>::transmit",
        sample: "Node for plumbline::fsc::sensor::Sensor<M>>::sample",
        image: "Node for plumbline::fsc::sensor::Sensor<M>>::image",
        stored: "Node for plumbline::fsc::sensor::Sensor<M>>::stored",
    },
    boot_up: 2,
    read: request(&[0x00]),
    // Cyclic time 20 ms.
    write: request(&[0x25, 20, 0]),
    sync: Message(0x100, &[]),
    filter_off: request(&[0x27, 0xD0, 0x07, 0]),
    // 0.1 Hz, 25 Hz, and 2 Hz, with which the samples are measured.
    butterworth: [
        request(&[0x27, 0x64, 0x00, 1]),
        request(&[0x27, 0xA8, 0x61, 1]),
        request(&[0x27, 0xD0, 0x07, 1]),
    ],
    // 0.1 Hz, 8 Hz, 2 Hz.
    critically_damped: [
        request(&[0x27, 0x64, 0x00, 2]),
        request(&[0x27, 0x40, 0x1F, 2]),
        request(&[0x27, 0xD0, 0x07, 2]),
    ],
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
        // A code that there is not.
        request(&[0x77]),
    ],
    cyclic: &[request(&[0x25, 5, 0]), request(&[0x26, 1])],
    not_cyclic: request(&[0x26, 0]),
    set_up: &[request(&[0x23, 9]), request(&[0x24, 1])],
    save: request(&[0x50, b'S', b'A', b'V', b'E']),
    load: request(&[0x40, b'L', b'O', b'A', b'D']),
    restart: request(&[0xFF, b'R', b'E', b'S', b'E', b'T']),
};
