//! A library with the entry points of PCAN-Basic and one adapter, USBBUS1, on the bus of a virtual sensor (slcan over TCP). Each read
//! advances the clock of the sensor by 20 ms, or up to the next frame: so a busy computer loses no answer. `pcan.rs` compiles the library,
//! and the program loads it.
//!
//! Variables of the environment: `PCAN_TEST_BUS` is the address of the sensor, `PCAN_TEST_FAULT` a fault.

use std::collections::VecDeque;
use std::ffi::{c_char, c_void};
use std::io::{BufReader, Read, Write};
use std::net::TcpStream;
use std::sync::Mutex;

const USBBUS1: u16 = 0x51;
const OK: u32 = 0;
const EMPTY: u32 = 0x20;
const QUEUE_FULL: u32 = 0x80;
const QUEUE_OVERRUN: u32 = 0x40;
const BUS_OFF: u32 = 0x10;
const IN_USE: u32 = 0x400;
const NO_CHANNEL: u32 = 0x1400;
const NOT_INITIALIZED: u32 = 0x400_0000;
const LISTEN_ONLY: u8 = 8;
const CONDITION: u8 = 13;

#[repr(C)]
#[derive(Clone, Copy)]
pub struct Message {
    id: u32,
    kind: u8,
    length: u8,
    data: [u8; 8],
}

/// The open channel.
struct Channel {
    stream: BufReader<TcpStream>,
    received: VecDeque<Message>,
    sent: u32,
    reads: u32,
    /// The controller has switched itself off the bus, until it is initialized again.
    is_off: bool,
}

static CHANNEL: Mutex<Option<Channel>> = Mutex::new(None);
static LISTENS: Mutex<bool> = Mutex::new(false);
/// The fault that happens once has happened.
static HAS_HAPPENED: Mutex<bool> = Mutex::new(false);

fn has_fault(name: &str) -> bool {
    std::env::var("PCAN_TEST_FAULT").is_ok_and(|fault| fault == name)
}

/// Whether this fault happens now; it happens once.
fn happens(name: &str) -> bool {
    has_fault(name) && !std::mem::replace(&mut *HAS_HAPPENED.lock().unwrap(), true)
}

/// Sends a line of slcan.
fn say(stream: &mut TcpStream, line: &str) {
    stream.write_all(format!("{line}\r").as_bytes()).unwrap();
}

/// The next line, without its end.
fn line(stream: &mut BufReader<TcpStream>) -> String {
    let mut bytes = Vec::new();
    loop {
        let mut byte = [0];
        stream.read_exact(&mut byte).unwrap();
        match byte[0] {
            b'\r' | 7 => return String::from_utf8(bytes).unwrap(),
            other => bytes.push(other),
        }
    }
}

/// A line with a frame.
fn frame(line: &str) -> Option<Message> {
    let extended = match line.as_bytes().first()? {
        b't' | b'r' => 0,
        b'T' | b'R' => 2,
        _ => return None,
    };
    let remote = u8::from(line.starts_with(['r', 'R']));
    let digits = if extended == 0 { 3 } else { 8 };
    let number = |text: &str| u32::from_str_radix(text, 16).unwrap();
    let (id, rest) = line[1..].split_at(digits);
    let length = number(&rest[..1]) as u8;
    let mut data = [0; 8];
    for (byte, pair) in data.iter_mut().zip(rest[1..].as_bytes().chunks_exact(2)) {
        *byte = number(std::str::from_utf8(pair).unwrap()) as u8;
    }
    let kind = extended | remote;
    Some(Message {
        id: number(id),
        kind,
        length,
        data,
    })
}

#[unsafe(no_mangle)]
pub extern "system" fn CAN_Initialize(channel: u16, timing: u16, _: u8, _: u32, _: u16) -> u32 {
    if has_fault("in-use") {
        return IN_USE;
    }
    if channel != USBBUS1 || has_fault("missing") {
        return NO_CHANNEL;
    }
    let mut stream = TcpStream::connect(std::env::var("PCAN_TEST_BUS").unwrap()).unwrap();
    stream.set_nodelay(true).unwrap();
    let open = if *LISTENS.lock().unwrap() { "L" } else { "O" };
    for command in ["C", &format!("s{timing:04X}"), open] {
        say(&mut stream, command);
    }
    *CHANNEL.lock().unwrap() = Some(Channel {
        stream: BufReader::new(stream),
        received: VecDeque::new(),
        sent: 0,
        reads: 0,
        is_off: happens("bus-off"),
    });
    OK
}

#[unsafe(no_mangle)]
pub extern "system" fn CAN_Uninitialize(_: u16) -> u32 {
    *CHANNEL.lock().unwrap() = None;
    OK
}

#[unsafe(no_mangle)]
pub extern "system" fn CAN_Reset(_: u16) -> u32 {
    OK
}

#[unsafe(no_mangle)]
pub extern "system" fn CAN_GetStatus(_: u16) -> u32 {
    OK
}

/// # Safety
/// The message must be valid.
#[unsafe(no_mangle)]
pub unsafe extern "system" fn CAN_Read(_: u16, message: *mut Message, _: *mut c_void) -> u32 {
    let mut channel = CHANNEL.lock().unwrap();
    let Some(channel) = channel.as_mut() else {
        return NOT_INITIALIZED;
    };
    channel.reads += 1;
    if (channel.sent > 0 || channel.reads > 10) && has_fault("unplugged") {
        return NO_CHANNEL;
    }
    if happens("overrun") {
        return QUEUE_OVERRUN;
    }
    if channel.received.is_empty() {
        say(channel.stream.get_mut(), "@4E20");
        loop {
            let line = line(&mut channel.stream);
            if line.starts_with('@') {
                break;
            }
            channel.received.extend(frame(&line));
        }
    }
    let Some(received) = channel.received.pop_front() else {
        return EMPTY;
    };
    // SAFETY: as the caller promises.
    unsafe { message.write(received) };
    OK
}

/// # Safety
/// The message must be valid.
#[unsafe(no_mangle)]
pub unsafe extern "system" fn CAN_Write(_: u16, message: *const Message) -> u32 {
    let mut channel = CHANNEL.lock().unwrap();
    let Some(channel) = channel.as_mut() else {
        return NOT_INITIALIZED;
    };
    channel.sent += 1;
    if has_fault("not-acknowledged") {
        return if channel.sent > 2 { QUEUE_FULL } else { OK };
    }
    if channel.is_off {
        return BUS_OFF;
    }
    // SAFETY: as the caller promises.
    let message = unsafe { message.read() };
    let letter = ['t', 'r', 'T', 'R'][usize::from(message.kind & 3)];
    let id = match message.kind & 2 {
        0 => format!("{:03X}", message.id),
        _ => format!("{:08X}", message.id),
    };
    let bytes = &message.data[..usize::from(message.length) * usize::from(1 - message.kind % 2)];
    let data: String = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
    say(
        channel.stream.get_mut(),
        &format!("{letter}{id}{}{data}", message.length),
    );
    OK
}

/// # Safety
/// The value must be valid.
#[unsafe(no_mangle)]
pub unsafe extern "system" fn CAN_GetValue(
    channel: u16,
    parameter: u8,
    value: *mut u32,
    _: u32,
) -> u32 {
    let read = match parameter {
        LISTEN_ONLY => u32::from(*LISTENS.lock().unwrap()),
        CONDITION if channel == USBBUS1 => 1 + u32::from(has_fault("in-use")),
        _ => 0,
    };
    // SAFETY: as the caller promises.
    unsafe { value.write(read) };
    OK
}

/// # Safety
/// The value must be valid.
#[unsafe(no_mangle)]
pub unsafe extern "system" fn CAN_SetValue(
    _: u16,
    parameter: u8,
    value: *const u32,
    _: u32,
) -> u32 {
    if parameter == LISTEN_ONLY {
        // SAFETY: as the caller promises.
        *LISTENS.lock().unwrap() = unsafe { value.read() } != 0 && !has_fault("no-listen-only");
    }
    OK
}

/// # Safety
/// There must be room for 256 bytes.
#[unsafe(no_mangle)]
pub unsafe extern "system" fn CAN_GetErrorText(status: u32, _: u16, text: *mut c_char) -> u32 {
    let read: &[u8] = match status {
        NO_CHANNEL => b"A channel is invalid\0",
        _ => b"An error\0",
    };
    for (place, byte) in read.iter().enumerate() {
        // SAFETY: as the caller promises.
        unsafe { text.add(place).write(*byte as c_char) };
    }
    OK
}
