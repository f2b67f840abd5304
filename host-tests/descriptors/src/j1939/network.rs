//! The messages of the protocol itself: address claim, requests, acknowledgements, transport protocol, parameters.
//!
//! A message between two nodes has the factory address of the sensor, and FEh instead of the address of the other node.

use plumbline::j1939::identifier::{
    ACKNOWLEDGEMENT, ADDRESS_CLAIMED, COMMANDED_ADDRESS, GLOBAL, NO_ADDRESS, PRIORITY,
    PROPRIETARY_A, Pgn, REQUEST, SOFTWARE_IDENTIFICATION, TRANSPORT_CONTROL, TRANSPORT_DATA,
};

/// The address of the other node in messages to the sensor.
const OTHER: u8 = NO_ADDRESS;

/// The priority of the transport protocol.
const LOWEST: u8 = 7;

/// The direction of a message.
#[derive(Clone, Copy)]
pub enum Sent {
    /// The sensor, to this address.
    To(u8),
    /// Another node, to the sensor or to all.
    From,
}

impl Sent {
    /// The destination and the source in the identifier.
    pub fn addresses(self, sensor: u8) -> (u8, u8) {
        match self {
            Self::To(destination) => (destination, sensor),
            Self::From => (sensor, OTHER),
        }
    }
}

/// A signal: name, first bit, number of bits, names of values.
type Field = (&'static str, u8, u8, &'static str);

/// A message of the network management or of the transport protocol.
pub struct Layout {
    pub name: &'static str,
    pub pgn: Pgn,
    pub priority: u8,
    pub sent: Sent,
    pub size: u8,
    pub comment: &'static str,
    pub fields: &'static [Field],
}

const CONTROLS: &str = "16 \"RTS\" 17 \"CTS\" 19 \"end of message\" 32 \"BAM\" 255 \"abort\"";
const ANSWERS: &str = "0 \"positive\" 1 \"negative\" 2 \"access denied\" 3 \"busy\"";

const CONTROL: &[Field] = &[
    ("Control", 0, 8, CONTROLS),
    // Depend on the control byte: size and number of packets, packets and next packet, or the reason of an abort.
    ("Parameters", 8, 32, ""),
    ("TransportedPGN", 40, 24, ""),
];

const PACKET: &[Field] = &[("SequenceNumber", 0, 8, ""), ("Packet", 8, 56, "")];

/// The bytes of an SDO (CiA 301).
const OBJECT: &[Field] = &[
    ("Command", 0, 8, ""),
    ("Index", 8, 16, ""),
    ("Subindex", 24, 8, ""),
    ("Contents", 32, 32, ""),
];

const NAME: [Field; 9] = [
    ("IdentityNumber", 0, 21, ""),
    ("ManufacturerCode", 21, 11, ""),
    ("ECUInstance", 32, 3, ""),
    ("FunctionInstance", 35, 5, ""),
    ("Function", 40, 8, ""),
    ("VehicleSystem", 49, 7, ""),
    ("VehicleSystemInstance", 56, 4, ""),
    ("IndustryGroup", 60, 3, ""),
    ("ArbitraryAddressCapable", 63, 1, ""),
];

/// NAME and the new address.
const COMMAND: [Field; 10] = {
    let [a, b, c, d, e, f, g, h, i] = NAME;
    [a, b, c, d, e, f, g, h, i, ("NewAddress", 64, 8, "")]
};

const fn layout(name: &'static str, pgn: Pgn, sent: Sent, fields: &'static [Field]) -> Layout {
    Layout {
        name,
        pgn,
        priority: PRIORITY,
        sent,
        size: 8,
        comment: "",
        fields,
    }
}

/// All messages besides process data and DM1.
pub const MESSAGES: &[Layout] = &[
    Layout {
        comment: "At the start, on request and in contention; from the address FEh: cannot claim. Those of other nodes are received",
        ..layout("AddressClaimed", ADDRESS_CLAIMED, Sent::To(GLOBAL), &NAME)
    },
    Layout {
        comment: "On request",
        ..layout(
            "SoftwareIdentification",
            SOFTWARE_IDENTIFICATION,
            Sent::To(GLOBAL),
            &[("Fields", 0, 8, ""), ("Text", 8, 56, "")],
        )
    },
    layout(
        "Acknowledgement",
        ACKNOWLEDGEMENT,
        Sent::To(GLOBAL),
        &[
            ("Answer", 0, 8, ANSWERS),
            ("GroupFunction", 8, 8, ""),
            ("Requester", 32, 8, ""),
            ("AcknowledgedPGN", 40, 24, ""),
        ],
    ),
    Layout {
        size: 3,
        comment: "To the sensor or to all nodes; it may be longer",
        ..layout(
            "Request",
            REQUEST,
            Sent::From,
            &[("RequestedPGN", 0, 24, "")],
        )
    },
    Layout {
        priority: LOWEST,
        comment: "Messages of more than 8 bytes to all nodes (BAM) or to one node: DM1 with several codes, component and ECU identification",
        ..layout(
            "TransportControl",
            TRANSPORT_CONTROL,
            Sent::To(GLOBAL),
            CONTROL,
        )
    },
    Layout {
        priority: LOWEST,
        ..layout("TransportData", TRANSPORT_DATA, Sent::To(GLOBAL), PACKET)
    },
    Layout {
        priority: LOWEST,
        ..layout(
            "TransportControlReceived",
            TRANSPORT_CONTROL,
            Sent::From,
            CONTROL,
        )
    },
    Layout {
        priority: LOWEST,
        ..layout("TransportDataReceived", TRANSPORT_DATA, Sent::From, PACKET)
    },
    Layout {
        size: 9,
        comment: "By the transport protocol",
        ..layout("CommandedAddress", COMMANDED_ADDRESS, Sent::From, &COMMAND)
    },
    Layout {
        comment: "The bytes of an SDO request (CiA 301) for an object",
        ..layout("ObjectRequest", PROPRIETARY_A, Sent::From, OBJECT)
    },
    Layout {
        comment: "The bytes of an SDO response",
        ..layout("ObjectResponse", PROPRIETARY_A, Sent::To(OTHER), OBJECT)
    },
];
