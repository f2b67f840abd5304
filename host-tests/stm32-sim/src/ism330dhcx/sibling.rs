//! Parts with the same identifier and the same addresses (ST: ism330dhcx_reg.h, asm330lhh_reg.h, iis2iclx_reg.h).
//!
//! | | ISM330DHCX | ASM330LHH | IIS2ICLX |
//! |---|---|---|---|
//! | axes of the accelerometer | 3 | 3 | 2: Z reads 0 |
//! | range, FS_XL 0 to 3 | 2, 16, 4, 8 g | 2, 16, 4, 8 g | 0.5, 3, 1, 2 g |
//! | gyroscope: CTRL2_G, batch data rate, self-test | yes | yes | no, reads 0 |
//! | other register banks: FUNC_CFG_ACCESS | yes | no | yes |

use super::{CTRL2_G, CTRL5_C, FIFO_CTRL3};

/// One of the parts whose WHO_AM_I is 6Bh.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Sibling {
    /// The part for which the firmware is made.
    Ism330dhcx,
    /// For vehicles, with the same accelerometer and gyroscope.
    Asm330lhh,
    /// An inclinometer of two axes.
    Iis2iclx,
}

impl Sibling {
    /// The bits that exist in a writable register.
    pub(super) fn bits(self, register: u8) -> u8 {
        match (self, register) {
            (Self::Iis2iclx, CTRL2_G) => 0,
            (Self::Iis2iclx, FIFO_CTRL3) => 0x0F,
            (Self::Iis2iclx, CTRL5_C) => 0b11,
            _ => 0xFF,
        }
    }

    /// Whether it has FUNC_CFG_ACCESS.
    pub(super) fn has_banks(self) -> bool {
        self != Self::Asm330lhh
    }

    /// The number of axes of the accelerometer.
    pub(super) fn axes(self) -> usize {
        match self {
            Self::Iis2iclx => 2,
            _ => 3,
        }
    }

    /// g per count, by FS_XL (datasheets, LA_So).
    pub(super) fn units(self) -> [f64; 4] {
        match self {
            Self::Iis2iclx => [15e-6, 122e-6, 31e-6, 61e-6],
            _ => [61e-6, 488e-6, 122e-6, 244e-6],
        }
    }
}
