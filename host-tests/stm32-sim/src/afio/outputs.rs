//! The pins of the outputs of the peripherals (RM0008, sections 9.3 and 9.4.2).

use super::{Afio, CanPins, SPI1_REMAP, TIM3_REMAP};
use crate::gpio::{Pin, PortName};

const TIM4_REMAP: u32 = 1 << 12;

/// The output of a peripheral.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Output {
    /// CAN_TX.
    Can,
    /// A channel of TIM3, 1 to 4.
    Tim3(u8),
    /// A channel of TIM4, 1 to 4.
    Tim4(u8),
    /// SPI1_NSS, SPI1_SCK, SPI1_MOSI.
    Spi1(SpiOutput),
    /// SPI2_NSS, SPI2_SCK, SPI2_MOSI.
    Spi2(SpiOutput),
    /// MCO, a clock.
    Clock,
    /// JTDO of the debug port.
    DebugPort,
}

/// An output of an SPI that is the master.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SpiOutput {
    /// NSS, only with SSOE.
    Select,
    /// SCK.
    Clock,
    /// MOSI.
    Data,
}

impl Afio {
    /// The pin of an output; None if it has none.
    pub fn pin_of(&self, output: Output) -> Option<Pin> {
        use PortName::{A, B, C, D};
        let pins = |pins: [(PortName, u8); 4], channel: u8| {
            let (port, pin) = pins[usize::from(channel) - 1];
            Pin(port, pin)
        };
        Some(match output {
            Output::Can => match self.can_pins() {
                CanPins::A11A12 => Pin(A, 12),
                CanPins::B8B9 => Pin(B, 9),
                CanPins::D0D1 => Pin(D, 1),
                CanPins::None => return None,
            },
            Output::Tim3(channel) => match (self.remap & TIM3_REMAP) >> 10 {
                0b00 => pins([(A, 6), (A, 7), (B, 0), (B, 1)], channel),
                0b10 => pins([(B, 4), (B, 5), (B, 0), (B, 1)], channel),
                0b11 => pins([(C, 6), (C, 7), (C, 8), (C, 9)], channel),
                _ => return None,
            },
            Output::Tim4(channel) if self.remap & TIM4_REMAP == 0 => Pin(B, 5 + channel),
            Output::Tim4(channel) => Pin(D, 11 + channel),
            Output::Spi1(output) => match (output, self.remap & SPI1_REMAP) {
                (SpiOutput::Select, 0) => Pin(A, 4),
                (SpiOutput::Clock, 0) => Pin(A, 5),
                (SpiOutput::Data, 0) => Pin(A, 7),
                (SpiOutput::Select, _) => Pin(A, 15),
                (SpiOutput::Clock, _) => Pin(B, 3),
                (SpiOutput::Data, _) => Pin(B, 5),
            },
            Output::Spi2(SpiOutput::Select) => Pin(B, 12),
            Output::Spi2(SpiOutput::Clock) => Pin(B, 13),
            Output::Spi2(SpiOutput::Data) => Pin(B, 15),
            Output::Clock => Pin(A, 8),
            // SWJ_CFG: 000 and 001 have JTAG.
            Output::DebugPort if self.debug_port <= 0b001 => Pin(B, 3),
            Output::DebugPort => return None,
        })
    }
}
