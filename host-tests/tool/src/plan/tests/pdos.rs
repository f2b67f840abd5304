//! PDOs of a node that has a data sheet: they change only while they are off, as CiA 301, 7.5.2.35 to 7.5.2.38, demands.

use super::*;
use crate::eds::parse;
use crate::note::Note;
use crate::sheet::Address;

/// The object that cannot be mapped.
const UNMAPPABLE: u32 = 0x2001_0008;

/// An index, a sub-index and a value.
type Object = (u16, u8, u32);

/// An RPDO and a TPDO that are valid.
const VALUES: [Object; 9] = [
    (0x1400, 1, 0x20A),
    (0x1400, 2, 254),
    (0x1600, 0, 1),
    (0x1600, 1, 0x2000_0008),
    (0x1800, 1, 0x18A),
    (0x1800, 3, 0),
    (0x1800, 6, 0),
    (0x1A00, 0, 1),
    (0x1A00, 1, 0x2000_0008),
];

impl Node {
    fn object(&self, index: u16, sub: u8) -> u32 {
        let [low, high] = index.to_le_bytes();
        u32::from_le_bytes(self.objects[&[low, high, sub]])
    }

    /// Whether a PDO cannot take a value now.
    pub fn refuses(&self, [low, high, sub]: [u8; 3], value: u32) -> bool {
        let index = u16::from_le_bytes([low, high]);
        let communication = match index {
            0x1400 | 0x1600 => 0x1400,
            0x1800 | 0x1A00 => 0x1800,
            _ => return false,
        };
        let is_valid = |cob_id: u32| cob_id >> 31 == 0;
        let cob_id = self.object(communication, 1);
        let count = self.object(communication + 0x200, 0);
        match (index, sub) {
            (0x1400 | 0x1800, 1) => is_valid(cob_id) && is_valid(value) && value != cob_id,
            (0x1400, _) => false,
            (0x1800, 3 | 6) | (_, 0) => is_valid(cob_id),
            _ => is_valid(cob_id) || count != 0 || Some(value) == self.unmappable,
        }
    }
}

/// The data sheet of the node.
fn data_sheet() -> Sheet {
    let mut text = "[DeviceInfo]\nProductName=Drive\n".to_owned();
    for (index, sub, _) in VALUES {
        if !text.contains(&format!("[{index:X}]")) {
            text += &format!("[{index:X}]\nParameterName=PDO\nObjectType=9\n");
        }
        text +=
            &format!("[{index:X}sub{sub}]\nParameterName=Entry {sub}\nDataType=7\nAccessType=rw\n");
    }
    parse(text.as_bytes()).unwrap()
}

/// Writes objects of the node. Returns the result, the objects afterwards, and how often the node has refused.
fn written(changes: &[Object]) -> (Result<(), Error>, Vec<Object>, usize) {
    written_with(data_sheet(), changes)
}

/// The same with another data sheet.
fn written_with(sheet: Sheet, changes: &[Object]) -> (Result<(), Error>, Vec<Object>, usize) {
    let (result, node, _) = written_to(sheet, &[], 0, changes);
    let node = node.borrow();
    let after = VALUES.map(|(index, sub, _)| (index, sub, node.object(index, sub)));
    (result, after.to_vec(), node.refusals)
}

/// The same to a node with some other values, which stores for some ms. Returns the result, the node, and the notes.
fn written_to(
    sheet: Sheet,
    others: &[Object],
    stores: u32,
    changes: &[Object],
) -> (Result<(), Error>, Rc<RefCell<Node>>, Vec<Note>) {
    let start = Instant::from_ticks(0);
    let objects = VALUES.iter().chain(others).map(|(index, sub, value)| {
        let [low, high] = index.to_le_bytes();
        ([low, high, *sub], value.to_le_bytes())
    });
    let node = Rc::new(RefCell::new(Node {
        now: start,
        state: PRE_OPERATIONAL,
        stores: after(start, millis(stores)),
        forbids_operational: false,
        heartbeat: start,
        objects: objects.collect(),
        frames: VecDeque::new(),
        commands: Vec::new(),
        unmappable: Some(UNMAPPABLE),
        refusals: 0,
    }));
    let mut session = session(&node, sheet);
    let entries = session.sheet.entries.clone();
    let values = changes.iter().map(|(index, sub, raw)| {
        let (index, sub) = (*index, *sub);
        let mut own = entries.iter();
        let own = own.find(|entry| entry.address == Address::Object { index, sub });
        (own.unwrap().clone(), *raw)
    });
    let values: Values = values.collect();
    let result = write(&mut session, &values);
    (result, node, session.notes)
}

#[test]
fn note_of_a_disabled_pdo_is_printed_once_if_the_write_is_repeated() {
    let off = [(0x1800, 1, 0x8000_018A)];
    let (result, node, notes) = written_to(data_sheet(), &off, 700, &[(0x1800, 3, 100)]);
    assert_eq!(result, Ok(()));
    assert!(node.borrow().refusals > 3);
    assert_eq!(notes.len(), 1, "{notes:?}");
}

#[test]
fn constant_cob_id_is_not_written() {
    let mut sheet = data_sheet();
    for entry in &mut sheet.entries {
        let address = Address::Object {
            index: 0x1800,
            sub: 1,
        };
        entry.writable &= entry.address != address;
    }
    let (result, after, refusals) = written_with(sheet, &[(0x1800, 3, 100)]);
    // This node permits the inhibit time only while the PDO is off; that is its own answer.
    assert_eq!((result.unwrap_err().code(), refusals), ("refused", 1));
    assert_eq!(after, VALUES);
    assert_eq!(after[4], (0x1800, 1, 0x18A));
}

#[test]
fn pdo_is_off_while_it_changes_and_is_on_afterwards() {
    for changes in [
        &[(0x1400, 1, 0x30A)][..],
        &[(0x1600, 1, 0x2002_0008)],
        &[(0x1400, 1, 0x30A), (0x1400, 2, 1), (0x1600, 1, 0x2002_0008)],
        &[(0x1600, 0, 0)],
        &[(0x1400, 1, 0x8000_020A)],
        &[(0x1800, 1, 0x28A)],
        &[(0x1800, 3, 100)],
        &[(0x1800, 6, 5), (0x1A00, 1, 0x2002_0008)],
        &[(0x1400, 1, 0x30A), (0x1800, 1, 0x28A), (0x1800, 3, 100)],
    ] {
        let (result, after, refusals) = written(changes);
        assert_eq!(result, Ok(()), "{changes:X?}");
        assert_eq!(refusals, 0, "{changes:X?}");
        let expected = VALUES.map(|(index, sub, value)| {
            let mut changes = changes.iter();
            let own = changes.find(|(i, s, _)| (*i, *s) == (index, sub));
            (index, sub, own.map_or(value, |(_, _, raw)| *raw))
        });
        assert_eq!(after, expected, "{changes:X?}");
    }
}

#[test]
fn pdo_with_a_mapping_that_is_refused_is_as_before() {
    for changes in [
        &[(0x1400, 1, 0x30A), (0x1600, 1, UNMAPPABLE)][..],
        &[
            (0x1800, 1, 0x30A),
            (0x1800, 3, 100),
            (0x1A00, 1, UNMAPPABLE),
        ],
    ] {
        let (result, after, _) = written(changes);
        assert_eq!(result.unwrap_err().code(), "refused", "{changes:X?}");
        assert_eq!(after, VALUES, "{changes:X?}");
    }
}
