//! Tests of the state machine with a device of its own.

use super::*;
use proptest::prelude::*;

/// A device with the identity 1, 2, 3, 4 that permits the node-IDs 1 to 9 and 255, and 125 kbit/s.
struct Unit {
    active: u8,
    pending: u8,
    rate: Option<BitRate>,
}

impl Unit {
    fn with_node_id(node_id: u8) -> Self {
        Self {
            active: node_id,
            pending: node_id,
            rate: None,
        }
    }
}

impl Device for Unit {
    fn identity(&self, place: u8) -> u32 {
        u32::from(place) + 1
    }

    fn node_id(&self) -> u8 {
        self.active
    }

    fn pending_node_id(&self) -> u8 {
        self.pending
    }

    fn set_node_id(&mut self, node_id: u8) -> bool {
        let permitted = matches!(node_id, 1..=9 | 255);
        if permitted {
            self.pending = node_id;
        }
        permitted
    }

    fn set_bit_rate(&mut self, rate: BitRate) -> bool {
        let known = rate == BitRate::K125;
        self.rate = known.then_some(rate).or(self.rate);
        known
    }
}

fn request(command: u8, data: &[u8]) -> [u8; 8] {
    let mut bytes = [0; 8];
    bytes[0] = command;
    bytes[1..=data.len()].copy_from_slice(data);
    bytes
}

#[test]
fn store_and_activate_are_passed_to_the_node_in_configuration_only() {
    let (mut slave, mut unit) = (Slave::WAITING, Unit::with_node_id(5));
    let store = request(0x17, &[]);
    let activate = request(0x15, &[0x10, 0x27]);
    for bytes in [store, activate] {
        assert_eq!(slave.serve(&mut unit, bytes), Outcome::None);
    }
    slave.serve(&mut unit, request(0x04, &[1]));
    assert_eq!(slave.serve(&mut unit, store), Outcome::Store);
    let delay = Outcome::Activate(millis(10_000));
    assert_eq!(slave.serve(&mut unit, activate), delay);
    assert_eq!(Slave::stored(true), [0x17, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(Slave::stored(false), [0x17, 2, 0, 0, 0, 0, 0, 0]);
}

#[test]
fn refused_settings_do_not_change_the_device() {
    let (mut slave, mut unit) = (Slave::WAITING, Unit::with_node_id(5));
    slave.serve(&mut unit, request(0x04, &[1]));
    for (bytes, error) in [
        (request(0x11, &[9]), 0),
        (request(0x11, &[10]), 1),
        (request(0x13, &[0, 4]), 0),
        (request(0x13, &[0, 3]), 1),
        (request(0x13, &[0, 5]), 1),
        (request(0x13, &[0, 9]), 1),
        (request(0x13, &[1, 4]), 1),
    ] {
        let answer = Outcome::Reply(request(bytes[0], &[error]));
        assert_eq!(slave.serve(&mut unit, bytes), answer);
    }
    assert_eq!((unit.pending, unit.rate), (9, Some(BitRate::K125)));
}

/// Any frame; half of them have a command of LSS.
fn any_frame() -> impl Strategy<Value = [u8; 8]> {
    let commands = vec![
        command::SWITCH_GLOBAL,
        command::NODE_ID,
        command::BIT_TIMING,
        command::ACTIVATE,
        command::STORE,
        command::SELECT,
        command::SELECT_LAST,
        command::IDENTIFY,
        command::IDENTIFY_LAST,
        command::IDENTIFY_UNCONFIGURED,
        command::FASTSCAN,
        command::INQUIRE,
        command::INQUIRE_LAST,
        command::INQUIRE_NODE_ID,
    ];
    let command = prop_oneof![any::<u8>(), prop::sample::select(commands)];
    // Small numbers reach more states.
    let data = prop_oneof![
        any::<[u8; 7]>(),
        any::<[u8; 7]>().prop_map(|data| data.map(|byte| byte % 3))
    ];
    (command, data).prop_map(|(command, data)| request(command, &data))
}

proptest! {
    /// Any frames: the configuration state is entered only by a switch or a complete scan, and the device changes only in it.
    #[test]
    fn settings_change_only_in_configuration(
        frames in prop::collection::vec(any_frame(), 0..100),
        unconfigured: bool,
    ) {
        let node_id = if unconfigured { UNCONFIGURED } else { 5 };
        let (mut slave, mut unit) = (Slave::WAITING, Unit::with_node_id(node_id));
        for bytes in frames {
            let before = (slave.is_configuring(), unit.pending, unit.rate);
            let outcome = slave.serve(&mut unit, bytes);
            if !before.0 {
                prop_assert_eq!((unit.pending, unit.rate), (before.1, before.2));
                prop_assert!(matches!(outcome, Outcome::None | Outcome::Reply(_)));
            }
            if !before.0 && slave.is_configuring() {
                prop_assert!([0x04, 0x43, 0x51].contains(&bytes[0]));
            }
        }
    }
}
