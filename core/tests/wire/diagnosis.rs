//! The diagnostic data: each protocol reads the values, refuses writes, and answers other numbers with its error.

use crate::tester::devicenet::{MAC_3, power_up};
use crate::tester::{Tester, canopen, fsc, ims360, j1939};
use plumbline::can::{Frame, standard};
use plumbline::diagnosis::{LAST, ResetCauses};
use plumbline::node::{BusEvent, BusState, Node};
use plumbline::store::Usage;

const USAGE: Usage = Usage {
    minutes: 0x0102_0304,
    starts: 41,
    saves: 0x0A0B,
    erases: 7,
    coldest: -12_34,
    warmest: 56_78,
    shock: 6543,
};

/// The values 1 to 9 after a start with this usage, by the table of the module.
const VALUES: [u32; 9] = [
    0x08,
    42,
    0x0102_0304,
    -12_34_i32 as u32,
    56_78,
    6543,
    0x0A0B,
    7,
    0,
];

/// The node after a start by the watchdog, with this usage.
fn used<N: Node>(mut tester: Tester<N>) -> Tester<N> {
    tester.sent();
    tester.usage = USAGE;
    tester.causes = ResetCauses::WATCHDOG;
    tester.power_cycle();
    tester
}

#[test]
fn canopen_object_5f00h_has_each_value_and_is_read_only() {
    let mut t = used(canopen::power_up());
    t.sent();
    assert_eq!(t.read(0x5F00, 0), Ok(LAST.into()));
    for (sub, value) in (1..).zip(VALUES) {
        assert_eq!(t.read(0x5F00, sub), Ok(value), "sub-index {sub}");
    }
    assert_eq!(t.read(0x5F00, LAST + 1), Err(0x0609_0011));
    for other in [0x5EFF, 0x5F01, 0x5FFF] {
        assert_eq!(t.read(other, 0), Err(0x0602_0000), "{other:04X}h");
    }
    assert_eq!(t.write(0x5F00, 2, 4, 0), Err(0x0601_0002));
    assert_eq!(t.write(0x5F00, LAST + 1, 4, 0), Err(0x0609_0011));
    assert_eq!(t.read(0x5F00, 2), Ok(42));
}

/// Its image has no room.
#[test]
fn ims360_answers_as_its_original_in_both_protocols() {
    let mut t = used(ims360::booted());
    t.sent();
    assert_eq!(t.read(0x5F00, 1), Err(0x0602_0000));
    assert_eq!(t.write(0x5F00, 1, 4, 0), Err(0x0602_0000));
    let mut t = used(j1939::claimed());
    t.wait(250);
    t.sent();
    assert_eq!(t.parameter("40005F0200000000"), "80005F0200000206");
}

/// A transfer that runs can have the bytes 5Fh 00h in its data.
#[test]
fn segment_with_the_bytes_of_the_index_belongs_to_its_transfer() {
    let mut t = canopen::booted();
    t.sent();
    assert_eq!(t.exchange("60A#2100300018000000"), ["58A#6000300000000000"]);
    assert_eq!(t.exchange("60A#00415F0041414141"), ["58A#2000000000000000"]);
}

/// An initiate request ends it (CiA 301 7.2.4.3).
#[test]
fn request_for_5f00h_ends_the_running_transfer() {
    let mut t = canopen::booted();
    t.sent();
    assert_eq!(t.exchange("60A#4008100000000000"), ["58A#4108100006000000"]);
    assert_eq!(t.exchange("60A#40005F0000000000"), ["58A#4F005F000C000000"]);
    assert_eq!(t.exchange("60A#6000000000000000"), ["58A#8000000001000405"]);
}

#[test]
fn function_select_code_61h_has_each_value_and_is_refused_otherwise() {
    let mut t = used(fsc::is2());
    t.receive(Frame::data(standard(0x7FF), &[]).unwrap());
    t.sent();
    for (number, value) in (1..).zip(VALUES) {
        let reply = t.ask(&[0x61, number]);
        assert_eq!(reply[..3], [0x61, 0, number]);
        assert_eq!(reply[3..], value.to_le_bytes(), "number {number}");
    }
    assert_eq!(t.ask(&[0x61, 0])[3], LAST);
    for request in [&[0x61][..], &[0x61, LAST + 1], &[0x61, 2, 0], &[0x62, 2]] {
        let reply = t.ask(request);
        assert_eq!((reply.len(), reply[0]), (2, request[0]));
        assert_ne!(reply[1] & 0x08, 0, "CmdParamError");
    }
    // The read has the error bits of the status, and does not clear them.
    assert_eq!(t.ask(&[0x61, 2])[..2], [0x61, 0x08]);
    assert_ne!(t.ask(&[0x02])[1] & 0x08, 0);
}

#[test]
fn devicenet_class_c7h_has_each_value_and_is_not_settable() {
    let mut t = used(power_up(Some(MAC_3)));
    t.wait(2001);
    t.sent();
    t.allocate(1);
    for (attribute, value) in (1_u8..).zip(VALUES) {
        let bytes: String = value
            .to_le_bytes()
            .map(|byte| format!("{byte:02X}"))
            .concat();
        let reply = t.explicit(&format!("0EC701{attribute:02X}"));
        assert_eq!(reply, format!("8E{bytes}"), "attribute {attribute}");
    }
    assert_eq!(t.explicit("0EC70001"), "8E0100");
    assert_eq!(t.explicit("0EC70100"), "9414FF");
    assert_eq!(t.explicit("0EC7010D"), "9414FF");
    assert_eq!(t.explicit("0EC70102FF"), "9415FF");
    assert_eq!(t.explicit("0EC70201"), "9416FF");
    assert_eq!(t.explicit("10C70102000000"), "940EFF");
    assert_eq!(t.explicit("05C701"), "9408FF");
    // Another class that no product has.
    assert_eq!(t.explicit("0EC60101"), "9416FF");
}

#[test]
fn overruns_and_fault_confinement_are_counted_since_the_start() {
    let mut t = canopen::booted();
    t.sent();
    assert_eq!([10, 11, 12].map(|sub| t.read(0x5F00, sub)), [Ok(0); 3]);
    for state in [
        BusState::Warning,
        BusState::Passive,
        BusState::Warning,
        BusState::Passive,
        BusState::BusOff,
        BusState::Active,
    ] {
        t.bus(BusEvent::State(state));
    }
    for _ in 0..3 {
        t.bus(BusEvent::Overrun);
    }
    t.sent();
    assert_eq!(t.read(0x5F00, 10), Ok(3));
    assert_eq!(t.read(0x5F00, 11), Ok(2));
    assert_eq!(t.read(0x5F00, 12), Ok(1));
}
