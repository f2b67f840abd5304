//! The configuration of clocks, pins and timers. If a disturbance changes a register, the firmware writes it again. It restarts if the
//! hardware does not permit the write while the bits are in use.
//!
//! The values are constants, and not what the boot has read: so a disturbance in the boot is found, and none can change the values.

use super::{REGISTERS, restart, watchdog};

/// The key that AIRCR needs in a write.
const AIRCR_KEY: u32 = 0x05FA << 16;

/// SCB_VTOR, whose value is the address of the vectors.
const VTOR: u32 = 0xE000_ED08;

/// The registers of the processor. SCR is written before each sleep, SysTick by the clock.
const CORE: [Register; 6] = [
    // SCB: PRIGROUP of AIRCR, CCR with STKALIGN.
    Register::new(0xE000_ED0C, 0x700, AIRCR_KEY).written_whole(),
    Register::new(0xE000_ED14, 0x31B, 1 << 9),
    // SHPR3: the priority of SysTick.
    Register::new(0xE000_ED20, 0xF0F0_F0F0, 0x1000_0000),
    // NVIC_IPR4, NVIC_IPR5, NVIC_IPR7: the priorities of the interrupts of CAN and TIM4.
    Register::new(0xE000_E410, 0xF0F0_F0F0, 0x1000_0000),
    Register::new(0xE000_E414, 0xF0F0_F0F0, 0x10),
    Register::new(0xE000_E41C, 0xF0F0_F0F0, 0),
];

/// IWDG_PR and IWDG_RLR, at the same addresses in all chips. Each feeding of the watchdog closes them again.
const WATCHDOG: [Register; 2] = [
    Register::new(0x4000_3004, 0x7, watchdog::PRESCALER as u32).of_the_watchdog(),
    Register::new(0x4000_3008, 0xFFF, watchdog::COUNTS).of_the_watchdog(),
];

/// A configuration register, of which some bits are compared and restored.
pub struct Register {
    address: u32,
    /// The bits that only the boot changes.
    mask: u32,
    value: u32,
    access: Access,
}

/// How a register is restored.
#[derive(Clone, Copy)]
enum Access {
    /// The other bits keep their present value.
    Bits,
    /// The other bits get those of the value: they do not read as they must be written.
    Whole,
    /// After the watchdog has permitted it.
    Watchdog,
    /// It can only be written at the boot.
    Restart,
}

impl Register {
    /// The bits of `mask` in the 32-bit register at `address` have those of `value`.
    pub(super) const fn new(address: u32, mask: u32, value: u32) -> Self {
        Self {
            address,
            mask,
            value,
            access: Access::Bits,
        }
    }

    /// The other bits are always written with those of the value: they do not read as they must be written.
    pub(super) const fn written_whole(self) -> Self {
        self.accessed(Access::Whole)
    }

    /// The bits can only be written at the boot.
    pub(super) const fn fixed(self) -> Self {
        self.accessed(Access::Restart)
    }

    const fn of_the_watchdog(self) -> Self {
        self.accessed(Access::Watchdog)
    }

    const fn accessed(self, access: Access) -> Self {
        Self { access, ..self }
    }

    /// Writes the register if it has changed, or restarts. Returns true if it has changed.
    fn restore(&self) -> bool {
        let place = self.address as *mut u32;
        // SAFETY: an address of the table of the board: a register that always exists, and whose read has no effect.
        let present = unsafe { place.read_volatile() };
        if (present ^ self.value) & self.mask == 0 {
            return false;
        }
        let value = match self.access {
            Access::Whole => self.value,
            Access::Bits => present & !self.mask | self.value & self.mask,
            Access::Watchdog => {
                watchdog::permit();
                self.value
            }
            Access::Restart => {
                error!("restart: {=u32:#x} is disturbed", self.address);
                restart()
            }
        };
        // SAFETY: as above. The value is that of the boot. The main loop is the only code that writes these registers.
        unsafe { place.write_volatile(value) };
        true
    }
}

/// Writes the registers that have changed, or restarts. Returns true if a register has changed. Call it as soon as all registers are set, and
/// often. The clocks come first in the table of the board, because a peripheral without a clock loses a write.
pub fn restore() -> bool {
    unsafe extern "C" {
        static __vector_table: u32;
    }
    let vectors = Register::new(VTOR, !0x7F, &raw const __vector_table as u32);
    let registers = [&CORE[..], &WATCHDOG, &REGISTERS];
    let all = registers.into_iter().flatten();
    all.fold(vectors.restore(), |changed, register| {
        register.restore() || changed
    })
}
