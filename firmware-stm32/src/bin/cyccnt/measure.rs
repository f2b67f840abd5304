//! The program for the target.

use super::sequences::{Register, SEQUENCES, Sequence};
use core::ptr::{addr_of_mut, with_exposed_provenance_mut};

#[cfg(feature = "defmt")]
use defmt_rtt as _;
#[cfg(feature = "nucleo-f446re")]
use stm32f4xx_hal as _;

/// The linker script expects a vector table. There are no interrupts.
// SAFETY: the section is that of the vectors, behind those of the core.
#[cfg(feature = "stm32f103")]
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [usize; 1] = [0];

/// "CCYC" in memory: all sequences are measured.
const FINISHED: u32 = 0x4359_4343;

/// Measurements of each sequence; the last one counts.
const ROUNDS: usize = 3;

/// The figures, as a debugger reads them.
#[repr(C)]
struct Results {
    state: u32,
    count: u32,
    sequences: *const Sequence,
    figures: [[u32; 2]; SEQUENCES.len()],
}

#[unsafe(no_mangle)]
static mut CYCCNT_RESULTS: Results = Results {
    state: 0,
    count: SEQUENCES.len() as u32,
    sequences: SEQUENCES.as_ptr(),
    figures: [[0; 2]; SEQUENCES.len()],
};

/// DEMCR with TRCENA, and the registers of the DWT (ARMv7-M Architecture Reference Manual, C1.6.5 and C1.8).
const DEMCR: usize = 0xE000_EDFC;
const TRCENA: u32 = 1 << 24;
const DWT_CTRL: usize = 0xE000_1000;
const CYCCNTENA: u32 = 1 << 0;
const DWT_CYCCNT: usize = 0xE000_1004;

/// Registers of the STM32F103 (RM0008).
#[cfg(feature = "stm32f103")]
mod chip {
    use super::Register;

    pub const FLASH_ACR: usize = 0x4002_2000;
    /// Wait states, with the prefetch buffer.
    pub const fn acr(wait_states: u32) -> u32 {
        1 << 4 | wait_states
    }
    pub const RCC_CFGR: usize = 0x4002_1004;
    /// PPRE1 in RCC_CFGR: PCLK1 = HCLK / 2.
    pub const APB1_HALF: u32 = 0b100 << 8;
    /// The clocks of the registers below: their addresses and bits.
    pub const CLOCKS: [(usize, u32); 2] = [(0x4002_101C, 1 << 1), (0x4002_1018, 1 << 2)];

    /// A register that can be read, and written with 0 without effect: TIM3_ARR, GPIOA_BSRR, FLASH_ACR.
    pub const fn register(register: Register) -> usize {
        match register {
            Register::Apb1 => 0x4000_042C,
            Register::Apb2 => 0x4001_0810,
            Register::Ahb => FLASH_ACR,
        }
    }
}

/// Registers of the STM32F446 (RM0390).
#[cfg(feature = "nucleo-f446re")]
mod chip {
    use super::Register;

    pub const FLASH_ACR: usize = 0x4002_3C00;
    /// Wait states, with the prefetch buffer, without the caches.
    pub const fn acr(wait_states: u32) -> u32 {
        1 << 8 | wait_states
    }
    pub const RCC_CFGR: usize = 0x4002_3808;
    /// PPRE1 in RCC_CFGR: PCLK1 = HCLK / 2.
    pub const APB1_HALF: u32 = 0b100 << 10;
    /// The clocks of the registers below: their addresses and bits.
    pub const CLOCKS: [(usize, u32); 2] = [(0x4002_3840, 1 << 1), (0x4002_3844, 1 << 14)];

    /// A register that can be read, and written with 0 without effect: TIM3_ARR, SYSCFG_EXTICR1, FLASH_ACR.
    pub const fn register(register: Register) -> usize {
        match register {
            Register::Apb1 => 0x4000_042C,
            Register::Apb2 => 0x4001_3808,
            Register::Ahb => FLASH_ACR,
        }
    }
}

fn at(address: usize) -> *mut u32 {
    with_exposed_provenance_mut(address)
}

/// Writes a register.
///
/// # Safety
/// The write must be permitted and without effect on memory.
unsafe fn write(address: usize, value: u32) {
    // SAFETY: the caller guarantees it.
    unsafe { at(address).write_volatile(value) };
}

/// Sets bits of a register.
///
/// # Safety
/// As for [`write`].
unsafe fn set(address: usize, bits: u32) {
    // SAFETY: the caller guarantees it.
    unsafe { at(address).write_volatile(at(address).read_volatile() | bits) };
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: there are no interrupts and no other code, and all registers are those of the chip that the feature selects. HSI, the
    // clock after a reset, permits any number of wait states.
    unsafe {
        set(DEMCR, TRCENA);
        set(DWT_CTRL, CYCCNTENA);
        set(chip::RCC_CFGR, chip::APB1_HALF);
        for (address, bits) in chip::CLOCKS {
            set(address, bits);
        }
        let figures = addr_of_mut!(CYCCNT_RESULTS.figures).cast::<[u32; 2]>();
        for (column, wait_states) in [0, 2].into_iter().enumerate() {
            write(chip::FLASH_ACR, chip::acr(wait_states));
            for (row, sequence) in SEQUENCES.iter().enumerate() {
                let figure = measure(sequence);
                figures
                    .add(row)
                    .cast::<u32>()
                    .add(column)
                    .write_volatile(figure);
            }
        }
        addr_of_mut!(CYCCNT_RESULTS.state).write_volatile(FINISHED);
        print(figures);
    }
    loop {
        cortex_m::asm::wfi();
    }
}

/// Measures a sequence.
///
/// # Safety
/// The clocks of the registers must be on, and CYCCNT must count.
unsafe fn measure(sequence: &Sequence) -> u32 {
    let mut ram = [0_u32; 4];
    let register = at(chip::register(sequence.register));
    let mut figure = 0;
    for _ in 0..ROUNDS {
        // SAFETY: a sequence writes only to its arguments; the caller guarantees the rest.
        figure =
            unsafe { (sequence.code)(at(DWT_CYCCNT), ram.as_mut_ptr(), register, 0x1234_5678) };
    }
    figure
}

/// Prints the figures, with `defmt`.
///
/// # Safety
/// `_figures` must be those of `CYCCNT_RESULTS`.
unsafe fn print(_figures: *const [u32; 2]) {
    #[cfg(feature = "defmt")]
    for (row, sequence) in SEQUENCES.iter().enumerate() {
        // SAFETY: the caller guarantees it.
        let [none, two] = unsafe { _figures.add(row).read_volatile() };
        defmt::println!("{=u32} {=u32} {=str}", none, two, sequence.name());
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}
