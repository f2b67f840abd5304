//! Tests of the server with a test object dictionary.

use super::*;

/// A number at 2000h, a text at 2001h, a constant at 2002h, and a command at 2003h that needs a save.
#[derive(Default)]
struct Memory {
    number: u16,
    text: std::vec::Vec<u8>,
}

#[derive(Clone, Copy, PartialEq)]
enum Object {
    Number,
    Text,
    Constant,
    Command,
}

impl Objects for Memory {
    type Object = Object;
    type Text = Vec<u8, 16>;

    fn find(&self, address: Address) -> Result<Object, Abort> {
        match (address.index, address.sub) {
            (0x2000, 0) => Ok(Object::Number),
            (0x2001, 0) => Ok(Object::Text),
            (0x2002, 0) => Ok(Object::Constant),
            (0x2003, 0) => Ok(Object::Command),
            (0x2000..=0x2003, _) => Err(Abort::NoSubIndex),
            _ => Err(Abort::NoObject),
        }
    }

    fn check_read(&self, object: Object, _sub: u8) -> Result<(), Abort> {
        let readable = object != Object::Command;
        if readable {
            Ok(())
        } else {
            Err(Abort::WriteOnly)
        }
    }

    fn is_writable(object: Object) -> bool {
        object != Object::Constant
    }

    fn size(object: Object) -> u8 {
        match object {
            Object::Number => 2,
            Object::Text => 0,
            Object::Constant => 4,
            Object::Command => 1,
        }
    }

    fn number(&self, object: Object, _sub: u8) -> u32 {
        match object {
            Object::Number => self.number.into(),
            _ => 0x1234_5678,
        }
    }

    fn text(&self, _object: Object) -> Vec<u8, 16> {
        Vec::from_slice(&self.text).unwrap()
    }

    fn write(&mut self, _now: Instant, object: Object, data: &[u8]) -> Result<Written, Abort> {
        match (object, data) {
            (Object::Number, &[low, high]) => self.number = u16::from_le_bytes([low, high]),
            (Object::Text, text) => self.text = text.to_vec(),
            (Object::Command, _) => return Ok(Written::Storing),
            _ => return Err(Abort::Length),
        }
        Ok(Written::Done)
    }
}

type Tested = Server<Object, Vec<u8, 16>, crate::canopen::Absent>;

fn at(ms: u64) -> Instant {
    Instant::from_ticks(ms * 1000)
}

fn abort(index: u16, sub: u8, code: u32) -> Option<[u8; 8]> {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = code.to_le_bytes();
    Some([0x80, low, high, sub, a, b, c, d])
}

#[test]
fn number_is_transferred_in_one_frame() {
    let (mut server, mut memory) = (Tested::IDLE, Memory::default());
    let reply = server.serve(&mut memory, at(0), [0x2B, 0, 0x20, 0, 0x34, 0x12, 0, 0]);
    assert_eq!(reply, Some([0x60, 0, 0x20, 0, 0, 0, 0, 0]));
    assert_eq!(memory.number, 0x1234);
    let reply = server.serve(&mut memory, at(0), [0x40, 0, 0x20, 0, 0, 0, 0, 0]);
    assert_eq!(reply, Some([0x4B, 0, 0x20, 0, 0x34, 0x12, 0, 0]));
    assert_eq!(server.deadline().time(), None);
}

#[test]
fn text_is_transferred_in_segments() {
    let (mut server, mut memory) = (Tested::IDLE, Memory::default());
    let mut serve = |bytes| server.serve(&mut memory, at(0), bytes).unwrap();
    assert_eq!(serve([0x21, 1, 0x20, 0, 9, 0, 0, 0])[0], 0x60);
    assert_eq!(serve(*b"\x00abcdefg"), [0x20, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(serve(*b"\x1bhi\0\0\0\0\0"), [0x30, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(
        serve([0x40, 1, 0x20, 0, 0, 0, 0, 0]),
        [0x41, 1, 0x20, 0, 9, 0, 0, 0]
    );
    assert_eq!(serve([0x60, 0, 0, 0, 0, 0, 0, 0]), *b"\x00abcdefg");
    assert_eq!(serve([0x70, 0, 0, 0, 0, 0, 0, 0]), *b"\x1bhi\0\0\0\0\0");
    assert_eq!(memory.text, b"abcdefghi");
}

#[test]
fn empty_text_is_transferred_in_one_empty_segment() {
    let (mut server, mut memory) = (Tested::IDLE, Memory::default());
    let mut serve = |bytes| server.serve(&mut memory, at(0), bytes).unwrap();
    assert_eq!(
        serve([0x40, 1, 0x20, 0, 0, 0, 0, 0]),
        [0x41, 1, 0x20, 0, 0, 0, 0, 0]
    );
    assert_eq!(
        serve([0x60, 0, 0, 0, 0, 0, 0, 0]),
        [0x0F, 0, 0, 0, 0, 0, 0, 0]
    );
}

#[test]
fn wrong_request_is_aborted_with_its_code_and_changes_nothing() {
    let (mut server, mut memory) = (Tested::IDLE, Memory::default());
    let cases = [
        ([0x40, 4, 0x20, 0, 0, 0, 0, 0], 0x0602_0000),
        ([0x40, 0, 0x20, 1, 0, 0, 0, 0], 0x0609_0011),
        ([0x40, 3, 0x20, 0, 0, 0, 0, 0], 0x0601_0001),
        ([0x23, 2, 0x20, 0, 1, 2, 3, 4], 0x0601_0002),
        ([0x2F, 0, 0x20, 0, 1, 0, 0, 0], 0x0607_0013),
        ([0x23, 0, 0x20, 0, 1, 0, 0, 0], 0x0607_0012),
        ([0x21, 1, 0x20, 0, 17, 0, 0, 0], 0x0607_0012),
        ([0xA4, 0, 0x20, 0, 0, 0, 0, 0], 0x0504_0001),
    ];
    for (request, code) in cases {
        let [_, low, high, sub, ..] = request;
        let expected = abort(u16::from_le_bytes([low, high]), sub, code);
        assert_eq!(server.serve(&mut memory, at(0), request), expected);
        assert_eq!(server.deadline().time(), None);
    }
    assert_eq!((memory.number, memory.text.len()), (0, 0));
}

#[test]
fn segment_with_wrong_toggle_bit_aborts_transfer() {
    let (mut server, mut memory) = (Tested::IDLE, Memory::default());
    server.serve(&mut memory, at(0), [0x21, 1, 0x20, 0, 9, 0, 0, 0]);
    let reply = server.serve(&mut memory, at(0), *b"\x10abcdefg");
    assert_eq!(reply, abort(0x2001, 0, 0x0503_0000));
    let reply = server.serve(&mut memory, at(0), *b"\x00abcdefg");
    assert_eq!(reply, abort(0, 0, 0x0504_0001), "there is no transfer");
}

#[test]
fn transfer_without_next_segment_times_out() {
    let (mut server, mut memory) = (Tested::IDLE, Memory::default());
    server.serve(&mut memory, at(0), [0x21, 1, 0x20, 0, 9, 0, 0, 0]);
    assert_eq!(server.poll(at(999)), None);
    assert_eq!(server.deadline().time(), Some(at(1000)));
    assert_eq!(server.poll(at(1000)), abort(0x2001, 0, 0x0504_0000));
    assert_eq!(server.poll(at(1000)), None);
}

#[test]
fn write_with_save_is_answered_after_save() {
    let (mut server, mut memory) = (Tested::IDLE, Memory::default());
    let command = [0x2F, 3, 0x20, 0, 1, 0, 0, 0];
    assert_eq!(server.serve(&mut memory, at(0), command), None);
    assert_eq!(server.deadline().time(), None);
    assert_eq!(server.stored(true), Some([0x60, 3, 0x20, 0, 0, 0, 0, 0]));
    assert_eq!(server.stored(true), None);
    assert_eq!(server.serve(&mut memory, at(0), command), None);
    assert_eq!(server.stored(false), abort(0x2003, 0, 0x0606_0000));
    assert_eq!(server.serve(&mut memory, at(0), command), None);
    server.serve(&mut memory, at(0), [0x80, 3, 0x20, 0, 0, 0, 0, 0]);
    assert_eq!(server.stored(true), None, "the client has aborted");
}

#[test]
fn abort_of_client_ends_the_read_or_the_save() {
    let abort = |index: u16| {
        let [low, high] = index.to_le_bytes();
        [0x80, low, high, 0, 0, 0, 0x04, 0x05]
    };
    let command = [0x2F, 3, 0x20, 0, 1, 0, 0, 0];
    let read = [0x40, 1, 0x20, 0, 0, 0, 0, 0];
    // The aborted object, and which of read and save continue.
    for (object, reads, saves) in [
        (0x2001, false, true),
        (0x2003, true, false),
        (0x2000, false, true),
        (0x0000, false, false),
    ] {
        let mut server = Tested::IDLE;
        let mut memory = Memory {
            text: b"abcdefghi".to_vec(),
            ..Memory::default()
        };
        assert_eq!(server.serve(&mut memory, at(0), command), None);
        assert!(server.serve(&mut memory, at(0), read).is_some());
        assert_eq!(server.serve(&mut memory, at(0), abort(object)), None);
        assert_eq!(server.deadline().time().is_some(), reads, "{object:04X}");
        assert_eq!(server.stored(true).is_some(), saves, "{object:04X}");
        // After the save, its object is one like the others.
        assert!(server.serve(&mut memory, at(0), read).is_some());
        assert_eq!(server.serve(&mut memory, at(0), abort(0x2003)), None);
        assert_eq!(server.deadline(), Deadline::NEVER);
    }
}
