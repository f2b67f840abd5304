//! The interface between the processor and the peripherals.

use thiserror::Error;

/// The width of an access.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Width {
    /// An access of 8 bits.
    Byte,
    /// An access of 16 bits.
    HalfWord,
    /// An access of 32 bits.
    Word,
}

impl Width {
    /// The number of bytes: 1, 2 or 4.
    pub fn bytes(self) -> usize {
        match self {
            Self::Byte => 1,
            Self::HalfWord => 2,
            Self::Word => 4,
        }
    }
}

/// The reason why a peripheral refused an access; it stops the run.
#[derive(Clone, PartialEq, Eq, Debug, Error)]
pub enum AccessError {
    /// There is no peripheral or memory at this address.
    #[error("no peripheral at this address")]
    Unmapped,
    /// The peripheral's clock is off (RCC).
    #[error("{0} has no clock")]
    Unclocked(&'static str),
    /// The peripheral does not support such an access: width, alignment, read-only, a register that is not modelled.
    #[error("{0}")]
    Refused(&'static str),
}

/// Everything outside the processor and its memories:
///
/// - 0x4000_0000..0x4200_0000: the peripherals (the processor resolves the bit-band alias);
/// - 0x1FFF_0000..0x2000_0000: system memory, option bytes and electronic signature;
/// - 0xE004_2000..0xE004_2400: DBGMCU;
/// - the flash and its alias at 0, writes only: flash programming.
pub trait Io {
    /// Reads a register at processor cycle `cycle`. Reads of a byte or half-word return it in the low bits.
    fn read(&mut self, cycle: u64, address: u32, width: Width) -> Result<u32, AccessError>;

    /// Writes a register of a peripheral.
    fn write(
        &mut self,
        cycle: u64,
        address: u32,
        width: Width,
        value: u32,
    ) -> Result<(), AccessError>;

    /// The cycle up to which all reads of a register, from `cycle` on, return the same value and change nothing. None if that is unknown.
    /// The machine has called [`CortexM3::run`](super::cortex_m::CortexM3::run) with the next event of the peripherals.
    fn constant_until(&self, cycle: u64, address: u32) -> Option<u64> {
        let _ = (cycle, address);
        None
    }

    /// A barrier (DMB, DSB, ISB) is executed: all stores before it have reached their place.
    fn barrier(&mut self) {}

    /// True once after an access that may have changed an interrupt line, the time of the next peripheral event, the clock or the
    /// flash: the processor stops after the instruction so that the machine can update.
    fn take_changed(&mut self) -> bool;
}

/// No peripherals: every access is refused. For programs that use only the processor and its memories.
#[derive(Clone, Copy, Debug)]
pub struct NoPeripherals;

impl Io for NoPeripherals {
    fn read(&mut self, _: u64, _: u32, _: Width) -> Result<u32, AccessError> {
        Err(AccessError::Unmapped)
    }

    fn write(&mut self, _: u64, _: u32, _: Width, _: u32) -> Result<(), AccessError> {
        Err(AccessError::Unmapped)
    }

    fn take_changed(&mut self) -> bool {
        false
    }
}
