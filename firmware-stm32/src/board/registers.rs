//! The configuration of clocks, pins and timers after the boot. If a disturbance changes a register, the firmware writes it again. It restarts
//! if the hardware does not permit the write while the bits are in use.

use super::{REGISTERS, restart};
use cortex_m::singleton;

/// The key that AIRCR needs in a write.
const AIRCR_KEY: u32 = 0x05FA << 16;

/// The registers of the processor. SCR is written before each sleep, SysTick by the clock.
const CORE: [Register; 7] = [
    // SCB: VTOR, PRIGROUP of AIRCR, CCR.
    Register::new(0xE000_ED08, !0),
    Register::new(0xE000_ED0C, 0x700).with_others(AIRCR_KEY),
    Register::new(0xE000_ED14, !0),
    // SHPR3: the priority of SysTick.
    Register::new(0xE000_ED20, !0),
    // NVIC_IPR4, NVIC_IPR5, NVIC_IPR7: the priorities of the interrupts of CAN and TIM4.
    Register::new(0xE000_E410, !0),
    Register::new(0xE000_E414, !0),
    Register::new(0xE000_E41C, !0),
];

/// IWDG_PR and IWDG_RLR, at the same addresses in all chips. Each feeding of the watchdog closes them again.
const WATCHDOG: [Register; 2] = [
    Register::new(0x4000_3004, 0x7).opened_by(IWDG_KR, 0x5555),
    Register::new(0x4000_3008, 0xFFF).opened_by(IWDG_KR, 0x5555),
];
const IWDG_KR: usize = 0x4000_3000;

/// All of them.
fn registers() -> impl Iterator<Item = &'static Register> {
    CORE.iter().chain(&WATCHDOG).chain(&REGISTERS)
}

/// A configuration register, of which some bits are compared and restored.
pub struct Register {
    /// The address of the 32-bit register.
    address: usize,
    /// The bits that only the boot changes.
    mask: u32,
    /// Those of them that can only be written at the boot.
    fixed: u32,
    /// The value to write in the other bits. None: their present value.
    others: Option<u32>,
    /// The register and the key that permit a write.
    key: Option<(usize, u32)>,
}

impl Register {
    /// The bits of `mask` in the register at `address`. They can be read and written at any time.
    pub(super) const fn new(address: usize, mask: u32) -> Self {
        Self {
            address,
            mask,
            fixed: 0,
            others: None,
            key: None,
        }
    }

    /// The other bits are always written with this value: they do not read as they must be written.
    pub(super) const fn with_others(self, value: u32) -> Self {
        Self {
            others: Some(value),
            ..self
        }
    }

    /// These bits can only be written at the boot.
    pub(super) const fn with_fixed(self, fixed: u32) -> Self {
        Self { fixed, ..self }
    }

    /// A write needs this key in the register at `address`.
    const fn opened_by(self, address: usize, key: u32) -> Self {
        Self {
            key: Some((address, key)),
            ..self
        }
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
        unsafe {
            if let Some((address, key)) = self.key {
                (address as *mut u32).write_volatile(key);
            }
            self.place().write_volatile(value);
        }
    }
}

const COUNT: usize = CORE.len() + WATCHDOG.len() + REGISTERS.len();

/// The configuration after the boot.
pub struct Configuration([u32; COUNT]);

impl Configuration {
    /// The present configuration. Call it as soon as all registers are set. None on a second call.
    pub fn read() -> Option<&'static mut Self> {
        let configuration = singleton!(: Configuration = Configuration([0; COUNT]))?;
        for (value, register) in configuration.0.iter_mut().zip(registers()) {
            *value = register.read();
        }
        Some(configuration)
    }

    /// Writes the registers that have changed, or restarts. The clocks come first in the table, because a peripheral without a clock loses a
    /// write. Returns true if a register has changed.
    pub fn restore(&self) -> bool {
        let mut changed = false;
        for (value, register) in self.0.iter().zip(registers()) {
            let present = register.read();
            if (present ^ value) & register.fixed != 0 {
                error!("restart: {=usize:#x} is disturbed", register.address);
                restart();
            }
            if (present ^ value) & register.mask != 0 {
                let others = register.others.unwrap_or(present);
                register.write(others & !register.mask | value & register.mask);
                changed = true;
            }
        }
        changed
    }
}
