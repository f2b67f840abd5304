//! The register map of bxCAN (RM0008, 24.9.5): the register at an offset from 0x4000_6400, its name and its reserved bits.
//!
//! | Offset | Register |
//! |---|---|
//! | 000h, 004h | CAN_MCR, CAN_MSR: master control and status |
//! | 008h | CAN_TSR: transmit status |
//! | 00Ch, 010h | CAN_RF0R, CAN_RF1R: receive FIFOs |
//! | 014h, 018h | CAN_IER: interrupt enable; CAN_ESR: error status |
//! | 01Ch | CAN_BTR: bit timing |
//! | 180h, 190h, 1A0h | transmit mailboxes: identifier, length, low and high data |
//! | 1B0h, 1C0h | receive FIFO mailboxes, in the same order |
//! | 200h | CAN_FMR: filter master |
//! | 204h, 20Ch, 214h, 21Ch | CAN_FM1R mode, CAN_FS1R scale, CAN_FFA1R FIFO, CAN_FA1R activation |
//! | 240h + 8 i | CAN_FiR1 and CAN_FiR2, the filter banks |

/// Filter banks in the address map: those of the STM32F446; the STM32F103 has half of them.
const MAPPED_BANKS: u32 = 28;

/// The word of a mailbox that has the identifier.
pub(super) const IDENTIFIER: usize = 0;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Register {
    MasterControl,
    MasterStatus,
    TransmitStatus,
    ReceiveFifo(usize),
    InterruptEnable,
    ErrorStatus,
    BitTiming,
    Transmit { mailbox: usize, word: usize },
    Receive { fifo: usize, word: usize },
    FilterMaster,
    FilterMode,
    FilterScale,
    FilterFifo,
    FilterActivation,
    FilterBank { bank: usize, half: usize },
}

impl Register {
    /// The register at an offset; None for an unused or unaligned offset.
    pub(super) fn at(offset: u32) -> Option<Self> {
        const BANKS_END: u32 = 0x240 + 8 * MAPPED_BANKS;
        if !offset.is_multiple_of(4) {
            return None;
        }
        let word = (offset / 4 % 4) as usize;
        Some(match offset {
            0x000 => Self::MasterControl,
            0x004 => Self::MasterStatus,
            0x008 => Self::TransmitStatus,
            0x00C => Self::ReceiveFifo(0),
            0x010 => Self::ReceiveFifo(1),
            0x014 => Self::InterruptEnable,
            0x018 => Self::ErrorStatus,
            0x01C => Self::BitTiming,
            0x180..0x1B0 => Self::Transmit {
                mailbox: ((offset - 0x180) / 16) as usize,
                word,
            },
            0x1B0..0x1D0 => Self::Receive {
                fifo: ((offset - 0x1B0) / 16) as usize,
                word,
            },
            0x200 => Self::FilterMaster,
            0x204 => Self::FilterMode,
            0x20C => Self::FilterScale,
            0x214 => Self::FilterFifo,
            0x21C => Self::FilterActivation,
            0x240..BANKS_END => Self::FilterBank {
                bank: ((offset - 0x240) / 8) as usize,
                half: (offset / 4 % 2) as usize,
            },
            _ => return None,
        })
    }

    /// The name in the reference manual.
    pub(super) fn name(self) -> &'static str {
        const TRANSMIT: [[&str; 4]; 3] = [
            ["CAN_TI0R", "CAN_TDT0R", "CAN_TDL0R", "CAN_TDH0R"],
            ["CAN_TI1R", "CAN_TDT1R", "CAN_TDL1R", "CAN_TDH1R"],
            ["CAN_TI2R", "CAN_TDT2R", "CAN_TDL2R", "CAN_TDH2R"],
        ];
        const RECEIVE: [[&str; 4]; 2] = [
            ["CAN_RI0R", "CAN_RDT0R", "CAN_RDL0R", "CAN_RDH0R"],
            ["CAN_RI1R", "CAN_RDT1R", "CAN_RDL1R", "CAN_RDH1R"],
        ];
        match self {
            Self::MasterControl => "CAN_MCR",
            Self::MasterStatus => "CAN_MSR",
            Self::TransmitStatus => "CAN_TSR",
            Self::ReceiveFifo(0) => "CAN_RF0R",
            Self::ReceiveFifo(_) => "CAN_RF1R",
            Self::InterruptEnable => "CAN_IER",
            Self::ErrorStatus => "CAN_ESR",
            Self::BitTiming => "CAN_BTR",
            Self::Transmit { mailbox, word } => TRANSMIT[mailbox][word],
            Self::Receive { fifo, word } => RECEIVE[fifo][word],
            Self::FilterMaster => "CAN_FMR",
            Self::FilterMode => "CAN_FM1R",
            Self::FilterScale => "CAN_FS1R",
            Self::FilterFifo => "CAN_FFA1R",
            Self::FilterActivation => "CAN_FA1R",
            Self::FilterBank { half: 0, .. } => "CAN_FiR1",
            Self::FilterBank { .. } => "CAN_FiR2",
        }
    }

    /// The bits that must keep their reset value, and that value. For the filter registers, see `Filters::reserved`.
    pub(super) fn reserved(self) -> (u32, u32) {
        match self {
            Self::MasterControl => (0xFFFE_7F00, 0),
            Self::MasterStatus => (0xFFFF_F0E0, 0),
            Self::TransmitStatus => (0x0070_7070, 0),
            Self::ReceiveFifo(_) => (0xFFFF_FFC4, 0),
            Self::InterruptEnable => (0xFFFC_7080, 0),
            Self::ErrorStatus => (0x0000_FF88, 0),
            Self::BitTiming => (0x3C80_FC00, 0),
            Self::Transmit { word: 1, .. } => (0x0000_FEF0, 0),
            // The reserved bits of the filter registers depend on the number of banks.
            _ => (0, 0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn register_map_matches_manual() {
        for (offset, name) in [
            (0x000, "CAN_MCR"),
            (0x004, "CAN_MSR"),
            (0x008, "CAN_TSR"),
            (0x00C, "CAN_RF0R"),
            (0x010, "CAN_RF1R"),
            (0x014, "CAN_IER"),
            (0x018, "CAN_ESR"),
            (0x01C, "CAN_BTR"),
            (0x180, "CAN_TI0R"),
            (0x184, "CAN_TDT0R"),
            (0x198, "CAN_TDL1R"),
            (0x1AC, "CAN_TDH2R"),
            (0x1B0, "CAN_RI0R"),
            (0x1B4, "CAN_RDT0R"),
            (0x1CC, "CAN_RDH1R"),
            (0x200, "CAN_FMR"),
            (0x204, "CAN_FM1R"),
            (0x20C, "CAN_FS1R"),
            (0x214, "CAN_FFA1R"),
            (0x21C, "CAN_FA1R"),
            (0x240, "CAN_FiR1"),
            (0x2AC, "CAN_FiR2"),
        ] {
            assert_eq!(
                Register::at(offset).map(Register::name),
                Some(name),
                "{offset:03X}h"
            );
        }
        assert_eq!(
            Register::at(0x2AC),
            Some(Register::FilterBank { bank: 13, half: 1 })
        );
    }

    #[test]
    fn unused_offsets_have_no_register() {
        for offset in [
            0x020, 0x17C, 0x1D0, 0x208, 0x210, 0x218, 0x220, 0x23C, 0x320, 0x002, 0x181,
        ] {
            assert_eq!(Register::at(offset), None, "{offset:03X}h");
        }
    }
}
