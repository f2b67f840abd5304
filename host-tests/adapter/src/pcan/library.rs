//! PCAN-Basic, the library of PEAK's adapters, which the user has installed. It is loaded when a port needs it.

use libloading::Library;
use std::ffi::{CStr, c_char, c_void};

/// The file of the library: PCAN-Basic of PEAK on Windows and Linux, PCBUSB of mac-can.com on macOS.
pub const FILE: &str = if cfg!(windows) {
    "PCANBasic.dll"
} else if cfg!(target_os = "macos") {
    "libPCBUSB.dylib"
} else {
    "libpcanbasic.so"
};

/// What a call returns (`TPCANStatus`): 0, or bits and codes of an error.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Status(pub u32);

impl Status {
    /// Done.
    pub const OK: Self = Self(0);
    /// The transmit buffer of the controller or the transmit queue is full.
    const FULL: u32 = 0x01 | 0x80;
    /// The controller or the receive queue has lost frames.
    const OVERRUN: u32 = 0x02 | 0x40;
    /// Error warning, error passive or bus-off.
    const BUS: u32 = 0x04 | 0x08 | 0x10 | 0x4_0000;
    const BUS_OFF: u32 = 0x10;
    const EMPTY: u32 = 0x20;
    /// Another program uses the channel, or uses it at another bit rate.
    const IN_USE: [u32; 2] = [0x400, 0x800];
    /// This computer has no such channel.
    const NO_CHANNEL: u32 = 0x1400;
    const NO_DRIVER: u32 = 0x200;
    /// It was done, but not as requested: for example, the channel has a bit rate already.
    const CAUTION: u32 = 0x0200_0000;

    /// There is no room for a frame.
    pub fn is_full(self) -> bool {
        self.0 & Self::FULL != 0
    }

    /// Frames are lost.
    pub fn is_overrun(self) -> bool {
        self.0 & Self::OVERRUN != 0
    }

    /// There were errors on the bus.
    pub fn is_disturbed(self) -> bool {
        self.0 & Self::BUS != 0
    }

    /// The controller has switched itself off the bus.
    pub fn is_bus_off(self) -> bool {
        self.0 & Self::BUS_OFF != 0
    }

    /// Only bits that are normal in operation: the adapter works.
    pub fn is_working(self) -> bool {
        self.0 & !(Self::FULL | Self::OVERRUN | Self::BUS | Self::EMPTY) == 0
    }

    /// Another program has the channel.
    pub fn is_in_use(self) -> bool {
        Self::IN_USE.contains(&self.0) || self.0 == Self::CAUTION
    }

    /// No adapter has this channel, or its driver is not there.
    pub fn is_missing(self) -> bool {
        self.0 == Self::NO_CHANNEL || self.0 == Self::NO_DRIVER
    }
}

/// A frame of the library (`TPCANMsg`).
#[repr(C)]
#[derive(Clone, Copy, Default, Debug)]
pub struct Message {
    /// The identifier.
    pub id: u32,
    /// Bits: remote, extended, error frame, status and others.
    pub kind: u8,
    /// The number of data bytes.
    pub length: u8,
    /// The data.
    pub data: [u8; 8],
}

/// Parameters of a channel or of the library (`TPCANParameter`).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Parameter {
    /// 1: the controller returns to the bus after bus-off.
    BusOffAutoReset = 7,
    /// 1: the controller only listens.
    ListenOnly = 8,
    /// Whether the channel is there: 0 no, 1 free, 2 used by another program, 3 used by PCAN-View.
    Condition = 13,
    /// 1: errors on the bus are received as frames.
    AllowErrorFrames = 32,
}

type Initialize = unsafe extern "system" fn(u16, u16, u8, u32, u16) -> u32;
type OfChannel = unsafe extern "system" fn(u16) -> u32;
/// The last argument is the time stamp, which may be null.
type Read = unsafe extern "system" fn(u16, *mut Message, *mut c_void) -> u32;
type Write = unsafe extern "system" fn(u16, *mut Message) -> u32;
type Value = unsafe extern "system" fn(u16, u8, *mut c_void, u32) -> u32;
type ErrorText = unsafe extern "system" fn(u32, u16, *mut c_char) -> u32;

/// The length of a parameter, which is a number of 32 bits.
const VALUE: u32 = 4;

/// The library needs room for 256 bytes.
const TEXT: usize = 256;

/// LANGUAGE: English.
const ENGLISH: u16 = 9;

/// The functions of the library that the tool calls.
pub struct PcanBasic {
    initialize: Initialize,
    uninitialize: OfChannel,
    reset: OfChannel,
    status: OfChannel,
    read: Read,
    write: Write,
    get: Value,
    set: Value,
    text: ErrorText,
    /// The functions are in it, so it stays loaded.
    _library: Library,
}

impl PcanBasic {
    /// Loads the library.
    ///
    /// # Errors
    /// It is not installed, or is another library.
    pub fn load() -> Result<Self, libloading::Error> {
        // SAFETY: PCAN-Basic has no conditions on being loaded, and the types are those of its header.
        unsafe {
            let library = Library::new(FILE)?;
            Ok(Self {
                initialize: *library.get::<Initialize>(c"CAN_Initialize")?,
                uninitialize: *library.get::<OfChannel>(c"CAN_Uninitialize")?,
                reset: *library.get::<OfChannel>(c"CAN_Reset")?,
                status: *library.get::<OfChannel>(c"CAN_GetStatus")?,
                read: *library.get::<Read>(c"CAN_Read")?,
                write: *library.get::<Write>(c"CAN_Write")?,
                get: *library.get::<Value>(c"CAN_GetValue")?,
                set: *library.get::<Value>(c"CAN_SetValue")?,
                text: *library.get::<ErrorText>(c"CAN_GetErrorText")?,
                _library: library,
            })
        }
    }

    /// Opens a channel with the bit timing registers BTR0 (high byte) and BTR1 of an SJA1000 at 8 MHz.
    pub fn initialize(&self, channel: u16, timing: u16) -> Status {
        // SAFETY: all values are permitted. The last three are for adapters that are not plug and play.
        Status(unsafe { (self.initialize)(channel, timing, 0, 0, 0) })
    }

    /// Closes a channel.
    pub fn uninitialize(&self, channel: u16) {
        // SAFETY: all values are permitted. A channel that is not open stays so.
        unsafe { (self.uninitialize)(channel) };
    }

    /// Empties the queues of a channel.
    pub fn reset(&self, channel: u16) -> Status {
        // SAFETY: all values are permitted.
        Status(unsafe { (self.reset)(channel) })
    }

    /// The state of a channel on the bus.
    pub fn status(&self, channel: u16) -> Status {
        // SAFETY: all values are permitted.
        Status(unsafe { (self.status)(channel) })
    }

    /// The next frame of the receive queue.
    pub fn read(&self, channel: u16) -> (Status, Message) {
        let mut message = Message::default();
        // SAFETY: the message is valid, and the time stamp may be null.
        let status = unsafe { (self.read)(channel, &raw mut message, std::ptr::null_mut()) };
        (Status(status), message)
    }

    /// Puts a frame into the transmit queue.
    pub fn write(&self, channel: u16, mut message: Message) -> Status {
        // SAFETY: the message is valid during the call.
        Status(unsafe { (self.write)(channel, &raw mut message) })
    }

    /// A parameter of a channel.
    pub fn get(&self, channel: u16, parameter: Parameter) -> (Status, u32) {
        let mut value = 0u32;
        // SAFETY: the parameters have 32 bits, and the value is valid during the call.
        let status =
            unsafe { (self.get)(channel, parameter as u8, (&raw mut value).cast(), VALUE) };
        (Status(status), value)
    }

    /// Sets a parameter of a channel.
    pub fn set(&self, channel: u16, parameter: Parameter, mut value: u32) -> Status {
        // SAFETY: as for `get`.
        let status =
            unsafe { (self.set)(channel, parameter as u8, (&raw mut value).cast(), VALUE) };
        Status(status)
    }

    /// What a status means, in English.
    pub fn text(&self, Status(status): Status) -> String {
        let mut text: [c_char; TEXT] = [0; TEXT];
        // SAFETY: the library writes at most 256 bytes.
        let done = unsafe { (self.text)(status, ENGLISH, text.as_mut_ptr()) };
        // Without the bits of other causes it has no text for the status.
        let bytes = text.map(|letter| letter.to_ne_bytes()[0]);
        let read = CStr::from_bytes_until_nul(&bytes).ok();
        match read.filter(|read| done == 0 && !read.is_empty()) {
            Some(read) => read.to_string_lossy().into_owned(),
            None => format!("status {status:X}h"),
        }
    }
}
