//! The configuration of clocks, pins and timers after the boot. If a disturbance changes a register, the firmware writes it again.

use super::REGISTERS;

/// A configuration register, of which some bits are compared and restored.
pub struct Register {
    /// The address of the 32-bit register.
    address: usize,
    /// The bits that only the boot changes.
    mask: u32,
    /// The bits that keep their present value.
    kept: u32,
}

impl Register {
    /// The bits of `mask` in the register at `address`. They can be read and written at any time.
    pub(super) const fn new(address: usize, mask: u32) -> Self {
        let kept = !mask;
        Self {
            address,
            mask,
            kept,
        }
    }

    /// The other bits are written as 0: what is read of them is undefined.
    #[cfg(feature = "stm32f103")]
    pub(super) const fn with_others_0(self) -> Self {
        Self { kept: 0, ..self }
    }

    fn place(&self) -> *mut u32 {
        self.address as *mut u32
    }

    fn read(&self) -> u32 {
        // SAFETY: an address of the table of the board: a register that always exists, and whose read has no effect.
        unsafe { self.place().read_volatile() }
    }

    fn write(&self, value: u32) {
        // SAFETY: as in `read`. The value is what the boot has written. The main loop is the only code that writes these registers.
        unsafe { self.place().write_volatile(value) }
    }
}

/// The configuration after the boot.
pub struct Configuration([u32; REGISTERS.len()]);

impl Configuration {
    /// The present configuration. Call it at the end of the boot.
    pub fn read() -> Self {
        let mut values = [0; REGISTERS.len()];
        for (value, register) in values.iter_mut().zip(&REGISTERS) {
            *value = register.read();
        }
        Self(values)
    }

    /// Writes the registers that have changed. The clocks come first in the table, because a peripheral without a clock loses a write.
    /// Returns true if one has changed.
    pub fn restore(&self) -> bool {
        let mut changed = false;
        for (value, register) in self.0.iter().zip(&REGISTERS) {
            let present = register.read();
            if (present ^ value) & register.mask != 0 {
                register.write(present & register.kept | value & register.mask);
                changed = true;
            }
        }
        changed
    }
}
