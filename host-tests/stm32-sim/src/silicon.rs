//! The differences between microcontrollers with the same name. Most parts on boards with an STM32F103 are clones.
//!
//! | | CODE | CAN2SB | FLASH_CR.LOCK | CPUID | DBGMCU | wait states | flash |
//! |---|---|---|---|---|---|---|---|
//! | [`genuine`](Silicon::genuine) STM32F103C8 | works | fixed | works | r1p1 | with a debugger | as set | 64 KiB |
//! | [`gd32`](Silicon::gd32): GD32F103C8 | 0 | fixed | works | r2p1 | works | none | 64 KiB, which are 128 |
//! | [`worst`](Silicon::worst) | 0 | 0 | reads 0 | r2p1 | with a debugger | as set | 64 KiB |
//!
//! A program that works on the worst microcontroller works on the others. Sources: katapult, issue 11 (GD32F103, CODE); STM32_CAN, issue 54
//! (CS32F103, CODE); stlink, issues 756 and 805 (debug port of a Cortex-M3 r2p1, flash of 128 KiB); rusefi-hardware, issue 127 (revisions
//! in DBGMCU_IDCODE); ES096 (DBGMCU of the STM32F103); data sheet of the GD32F103 (no wait states).

use super::board::Board;
use super::bxcan;
use super::chip::Chip;
use super::cortex_m::MemorySizes;

/// CPUID of a Cortex-M3 r2p1.
const M3_R2P1: u32 = 0x412F_C231;

/// DBGMCU_IDCODE: medium-density device, and the revision.
const STM32F103: u32 = 0x2003_6410;
const GD32F103: u32 = 0x1303_0410;

/// DBGMCU_IDCODE of the STM32F446, revision A.
const STM32F446: u32 = 0x1000_6421;

/// The behaviour of a microcontroller.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Silicon {
    /// The behaviour of the CAN controller.
    pub can: bxcan::Silicon,
    /// FLASH_CR.LOCK can be read; otherwise it reads 0 while the register is locked.
    pub lock_reads: bool,
    /// CPUID (SCB), with the revision of the core.
    pub processor: u32,
    /// The processor has Arm erratum 602117 also for code in flash.
    pub restarts_loads: bool,
    /// DBGMCU_IDCODE, with the device and its revision.
    pub identity: u32,
    /// A program can read DBGMCU; otherwise it reads 0 unless a debugger is connected.
    pub debug_reads: bool,
    /// A program can write DBGMCU; otherwise a write has no effect unless a debugger is connected.
    pub debug_writes: bool,
    /// The flash has the wait states of FLASH_ACR; otherwise none.
    pub waits: bool,
    /// Flash and RAM. The electronic signature contains the size of the flash that the data sheet states.
    pub memories: MemorySizes,
}

impl Silicon {
    /// A microcontroller of ST.
    pub fn genuine(board: Board) -> Self {
        let chip = board.chip();
        Self {
            can: bxcan::Silicon::default(),
            lock_reads: true,
            processor: chip.facts().processor.cpuid(),
            restarts_loads: false,
            identity: match chip {
                Chip::F103 => STM32F103,
                Chip::F446 => STM32F446,
            },
            debug_reads: chip == Chip::F446,
            debug_writes: chip == Chip::F446,
            waits: true,
            memories: board.memory(),
        }
    }

    /// A GD32F103C8, a clone with a later core and a larger flash.
    pub fn gd32() -> Self {
        let genuine = Self::genuine(Board::BluePill);
        Self {
            can: bxcan::Silicon {
                mailbox_code: Some(0),
                ..genuine.can
            },
            processor: M3_R2P1,
            identity: GD32F103,
            debug_reads: true,
            debug_writes: true,
            waits: false,
            memories: MemorySizes {
                flash: 2 * genuine.memories.flash,
                ..genuine.memories
            },
            ..genuine
        }
    }

    /// The worst behaviour of all microcontrollers with this name.
    pub fn worst(board: Board) -> Self {
        let chip = board.chip();
        let genuine = Self::genuine(board);
        Self {
            can: bxcan::Silicon::worst(),
            lock_reads: false,
            processor: match chip {
                Chip::F103 => M3_R2P1,
                Chip::F446 => genuine.processor,
            },
            restarts_loads: chip == Chip::F103,
            ..genuine
        }
    }
}
