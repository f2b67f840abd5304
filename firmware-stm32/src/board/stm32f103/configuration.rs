//! The registers that only the boot changes, with the bits that an STM32F103 has: the others can have any value on a clone.

use crate::board::registers::Register;
use crate::board::{APB1_PERIPHERALS, APB2_PERIPHERALS, PORTS, SPI_ADDRESS, SPI_CONTROL, SPI_PULL};

/// The registers of the [configuration](crate::board::restore).
pub(in crate::board) const REGISTERS: [Register; 30] = [
    // RCC: the resets of APB2 and APB1, the enables. ADC1 and TIM4 are switched on by their users.
    Register::new(0x4002_100C, 0x0038_FFFD, 0),
    Register::new(0x4002_1010, 0x3AFE_C9FF, 0),
    Register::new(0x4002_1014, 0x557, 0x15),
    Register::new(0x4002_1018, 0x0038_FDFD, 0x1D | APB2_PERIPHERALS),
    Register::new(0x4002_101C, 0x3AFE_C9FB, 0x1200_0002 | APB1_PERIPHERALS),
    // RCC_CR: HSEON and PLLON; CSSON, HSITRIM, HSION. Not HSEBYP: which oscillator has started is not a constant, and HSE that stops causes an
    // NMI.
    Register::new(0x4002_1000, 0x0101_0000, 0x0101_0000).fixed(),
    Register::new(0x4002_1000, 0x0008_00F9, 0x0008_0081),
    // RCC_CFGR: PLLMUL, PLLXTPRE, PLLSRC; the rest without SWS.
    Register::new(0x4002_1004, 0x003F_0000, 0x0019_0000).fixed(),
    Register::new(0x4002_1004, 0x0740_FFF3, 0x8402),
    // FLASH_ACR: HLFCYA, LATENCY. PRFTBE cannot be written above 24 MHz (PM0075), and some clones do not have it.
    Register::new(0x4002_2000, 0xF, 2),
    // PWR_CR: the voltage detector.
    Register::new(0x4000_7000, 0xF0, 0xF0),
    // AFIO_MAPR without SWJ_CFG, which cannot be read. Written as 000, the debug port stays on.
    Register::new(0x4001_0004, 0x001F_FFFF, 0x4000).written_whole(),
    // GPIO A, B, C: modes without that of TXD; pull-ups of the accelerometer's output and of RXD, level of TXD.
    Register::new(0x4001_0800, !0, PORTS[0]),
    Register::new(0x4001_0804, !0, 0x4444_4444),
    SPI_PULL,
    Register::new(0x4001_0C00, !0, 0x4444_443B),
    Register::new(0x4001_0C04, !0xF0, PORTS[1]),
    Register::new(0x4001_0C0C, 0b11 << 8, 0b11 << 8),
    Register::new(0x4001_1000, !0, PORTS[2]),
    Register::new(0x4001_1004, !0, PORTS[3]),
    // TIM3: CR2, SMCR, CCMR2, CCER, PSC, ARR, CR1.
    Register::new(0x4000_0404, 0xF8, 0),
    Register::new(0x4000_0408, 0xFFF7, 0),
    Register::new(0x4000_041C, 0xFFFF, 0x68),
    Register::new(0x4000_0420, 0x3333, 0x100),
    Register::new(0x4000_0428, 0xFFFF, 63),
    Register::new(0x4000_042C, 0xFFFF, 999),
    Register::new(0x4000_0400, 0x3FF, 0x81),
    // SPI: CR1, CR2, and I2SCFGR, which SPI1 does not have: it reads as 0 there.
    Register::new(SPI_ADDRESS, 0xFFFF, SPI_CONTROL),
    Register::new(SPI_ADDRESS + 4, 0xE7, 0),
    Register::new(SPI_ADDRESS + 0x1C, 0xFBF, 0),
];
