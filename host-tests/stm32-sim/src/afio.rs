//! Alternate-function I/O of the STM32F103 (RM0008, section 9.4): the pins of the peripherals.
//!
//! | offset | register | |
//! |---|---|---|
//! | 00h | AFIO_EVCR | event output: not modelled |
//! | 04h | AFIO_MAPR | remapping |
//! | 08h..14h | AFIO_EXTICR1..4 | sources of external interrupts: stored, without effect |

mod outputs;

pub use outputs::{Output, SpiOutput};

use super::gpio::{Gpio, Pin, PinMode, PortName};
use super::io::AccessError;
use super::violation::Violations;

/// SWJ_CFG in AFIO_MAPR: the debug port; write-only.
const DEBUG_PORT: u32 = 0b111 << 24;
/// What SWJ_CFG reads as. The manual does not define it: a program that writes it back switches the debug port off.
const UNDEFINED: u32 = 0b100 << 24;
const SPI1_REMAP: u32 = 1 << 0;
const TIM3_REMAP: u32 = 0b11 << 10;
const CAN_REMAP: u32 = 0b11 << 13;

/// RXD of the CAN transceiver on the board.
const CAN_RX: Pin = Pin(PortName::B, 8);
/// TXD of the CAN transceiver on the board.
const CAN_TX: Pin = Pin(PortName::B, 9);

/// The pins of the CAN controller (CAN_REMAP).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum CanPins {
    /// 00: receive PA11, transmit PA12.
    A11A12,
    /// 10: receive PB8, transmit PB9.
    B8B9,
    /// Value 11: CAN on PD0 and PD1.
    D0D1,
    /// Value 01, which is reserved.
    None,
}

/// The remapping of pins (AFIO_MAPR).
#[derive(Debug, Default)]
pub struct Afio {
    remap: u32,
    debug_port: u32,
    interrupt_sources: [u32; 4],
}

impl Afio {
    /// SWJ_CFG as last written: 4 switches the debug port off. It cannot be read back.
    pub fn debug_port(&self) -> u32 {
        self.debug_port
    }

    /// The pins that the CAN controller is mapped to.
    pub fn can_pins(&self) -> CanPins {
        match (self.remap & CAN_REMAP) >> 13 {
            0b00 => CanPins::A11A12,
            0b10 => CanPins::B8B9,
            0b11 => CanPins::D0D1,
            _ => CanPins::None,
        }
    }

    /// True when the CAN controller sees the board's transceiver: mapped to PB8 and PB9, and PB8 is an input (RM0008, table 27).
    pub fn can_receives(&self, gpio: &Gpio) -> bool {
        self.can_pins() == CanPins::B8B9 && gpio.mode(CAN_RX).is_digital_input()
    }

    /// True when the CAN controller drives the board's transceiver: mapped to PB8 and PB9, and PB9 is an alternate-function
    /// push-pull output (RM0008, table 27).
    pub fn can_drives(&self, gpio: &Gpio) -> bool {
        self.can_pins() == CanPins::B8B9 && gpio.mode(CAN_TX) == PinMode::AlternatePushPull
    }

    /// True when SPI1 is connected to the board's accelerometer: mapped to PA5 and PA7, alternate-function push-pull outputs, and
    /// PA6, an input (RM0008, table 25).
    pub fn spi1_is_connected(&self, gpio: &Gpio) -> bool {
        let is_output = |pin| gpio.mode(Pin(PortName::A, pin)) == PinMode::AlternatePushPull;
        self.remap & SPI1_REMAP == 0
            && is_output(5)
            && is_output(7)
            && gpio.mode(Pin(PortName::A, 6)).is_digital_input()
    }

    /// True unless TIM3 is fully remapped (RM0008, table 43).
    pub fn tim3_channels_3_and_4_are_on_pb0_and_pb1(&self) -> bool {
        self.remap & TIM3_REMAP != TIM3_REMAP
    }

    /// Reads the register at `offset`.
    pub fn read(&mut self, offset: u32) -> Result<u32, AccessError> {
        match offset {
            0x04 => Ok(self.remap | UNDEFINED),
            0x08 | 0x0C | 0x10 | 0x14 => Ok(self.interrupt_sources[offset as usize / 4 - 2]),
            _ => Err(AccessError::Refused("AFIO: register not modelled")),
        }
    }

    /// Inverts bits of the register at `offset`. What is read of SWJ_CFG does not show it. False if the register does not have all bits.
    pub fn disturb(&mut self, offset: u32, bits: u32) -> bool {
        match offset {
            0x04 if bits & !(DEBUG_PORT | 0x001F_FFFF) == 0 => {
                self.remap ^= bits & !DEBUG_PORT;
                self.debug_port ^= bits >> 24;
                true
            }
            0x08 | 0x0C | 0x10 | 0x14 if bits & !0xFFFF == 0 => {
                self.interrupt_sources[offset as usize / 4 - 2] ^= bits;
                true
            }
            _ => false,
        }
    }

    /// Writes the register at `offset`.
    pub fn write(
        &mut self,
        offset: u32,
        value: u32,
        violations: &mut Violations,
    ) -> Result<(), AccessError> {
        match offset {
            0x04 => {
                self.remap = value & 0x001F_FFFF;
                self.debug_port = (value & DEBUG_PORT) >> 24;
                violations.check(
                    !matches!(self.debug_port, 0b000 | 0b001 | 0b010 | 0b100),
                    "AFIO_MAPR",
                    "SWJ_CFG: not one of 000, 001, 010 and 100",
                );
                violations.check(
                    self.can_pins() == CanPins::None,
                    "AFIO_MAPR",
                    "CAN_REMAP: 01 is not used",
                );
            }
            0x08 | 0x0C | 0x10 | 0x14 => {
                self.interrupt_sources[offset as usize / 4 - 2] = value & 0xFFFF;
            }
            _ => return Err(AccessError::Refused("AFIO: register not modelled")),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chip::Chip;

    fn set_up(mapr: u32, crl_a: u32, crh_b: u32) -> (Afio, Gpio) {
        let (mut afio, mut gpio) = (Afio::default(), Gpio::new(Chip::F103));
        let mut violations = Violations::default();
        afio.write(0x04, mapr, &mut violations).unwrap();
        gpio.write(PortName::A, 0x00, crl_a, &mut violations)
            .unwrap();
        gpio.write(PortName::B, 0x04, crh_b, &mut violations)
            .unwrap();
        assert!(violations.list().is_empty());
        (afio, gpio)
    }

    #[test]
    fn can_is_connected_only_through_pb8_and_pb9() {
        let connected = |mapr, crh_b| {
            let (afio, gpio) = set_up(mapr, 0x4444_4444, crh_b);
            (afio.can_receives(&gpio), afio.can_drives(&gpio))
        };
        let pb8_and_pb9 = 0b10 << 13;
        assert_eq!(connected(pb8_and_pb9, 0x4444_44B8), (true, true));
        assert_eq!(
            connected(pb8_and_pb9, 0x4444_4494),
            (true, true),
            "any speed, floating"
        );
        assert_eq!(
            connected(0, 0x4444_44B8),
            (false, false),
            "mapped to PA11, PA12"
        );
        assert_eq!(
            connected(0b11 << 13, 0x4444_44B8),
            (false, false),
            "mapped to PD0, PD1"
        );
        // PB9 is an input, a port output, open drain.
        for crh_b in [0x4444_4448, 0x4444_4438, 0x4444_44F8] {
            assert_eq!(connected(pb8_and_pb9, crh_b), (true, false));
        }
        // PB8 is an output.
        assert_eq!(connected(pb8_and_pb9, 0x4444_44B3), (false, true));
    }

    #[test]
    fn spi1_is_connected_only_through_pa5_to_pa7() {
        let connected = |mapr, crl_a| {
            let (afio, gpio) = set_up(mapr, crl_a, 0x4444_4444);
            afio.spi1_is_connected(&gpio)
        };
        assert!(connected(0, 0xB4B3_4444));
        assert!(!connected(1, 0xB4B3_4444), "mapped to PB3 to PB5");
        assert!(!connected(0, 0x44B3_4444), "no MOSI");
    }

    #[test]
    fn debug_port_setting_is_write_only() {
        let (mut afio, _) = set_up(0b010 << 24 | 0b10 << 13, 0x4444_4444, 0x4444_4444);
        assert_eq!(afio.read(0x04), Ok(UNDEFINED | 0b10 << 13));
        assert_eq!(afio.debug_port(), 0b010);
    }

    #[test]
    fn reserved_codes_are_violations() {
        for mapr in [0b111 << 24, 0b01 << 13] {
            let mut violations = Violations::default();
            Afio::default().write(0x04, mapr, &mut violations).unwrap();
            assert_eq!(violations.list().len(), 1);
        }
    }
}
