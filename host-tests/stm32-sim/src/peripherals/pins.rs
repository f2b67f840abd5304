//! Peripherals that share a pin, and peripherals with two pins.
//!
//! The STM32F103 has no multiplexer: all peripherals that are enabled and mapped to a pin drive it. The multiplexer of the STM32F446 selects
//! one, but an input can have two pins.

use super::Peripherals;
use crate::afio::{Output, SpiOutput};
use crate::board::{HEATER_CHANNEL, Spi};
use crate::chip::{Chip, Module};
use crate::gpio::{Pin, PinMode, PortName};

/// Inputs of the STM32F446 with their pins and alternate functions (DS10693, alternate functions).
const INPUTS: [(&str, u8, &[Pin]); 3] = [
    (
        "CAN1_RX",
        9,
        &[
            Pin(PortName::A, 11),
            Pin(PortName::B, 8),
            Pin(PortName::D, 0),
        ],
    ),
    ("SPI2_MISO", 5, &[Pin(PortName::B, 14), Pin(PortName::C, 2)]),
    ("TIM4_CH3", 2, &[Pin(PortName::B, 8), Pin(PortName::D, 14)]),
];

impl Peripherals {
    /// True if a write to this register can connect a peripheral with a pin.
    pub(super) fn connects_pins(&self, module: Module, offset: u32) -> bool {
        match module {
            Module::Gpio(_) => match self.chip {
                Chip::F103 => offset < 0x08,
                Chip::F446 => matches!(offset, 0x00 | 0x20 | 0x24),
            },
            Module::Afio | Module::Rcc => true,
            Module::Spi => offset < 0x08,
            Module::Tim3 | Module::Tim4 => matches!(offset, 0x00 | 0x20),
            _ => false,
        }
    }

    /// Checks that each pin has one output, and each input one pin.
    pub(super) fn check_pins(&mut self) {
        match self.chip {
            Chip::F103 => self.check_outputs(),
            Chip::F446 => self.check_inputs(),
        }
    }

    fn check_outputs(&mut self) {
        let outputs: Vec<(Output, Pin)> = self
            .outputs()
            .into_iter()
            .filter(|(_, enabled)| *enabled)
            .filter_map(|(output, _)| Some((output, self.afio.pin_of(output)?)))
            .filter(|(output, pin)| *output == Output::DebugPort || self.is_alternate_output(*pin))
            .collect();
        for (number, (first, pin)) in outputs.iter().enumerate() {
            let others = outputs[number + 1..].iter();
            for (second, _) in others.filter(|(_, other)| other == pin) {
                let at = format!("P{:?}{}, {first:?} and {second:?}", pin.0, pin.1);
                self.violations.add(at, "two outputs drive one pin");
            }
        }
    }

    /// Checks that TIM3 runs when the pin of the heater becomes its output. A driver that stops may switch TIM3 off first.
    pub(super) fn check_heater(&mut self) {
        if self.chip != Chip::F103 {
            return;
        }
        let heater = self.gpio.mode(self.board.facts().pins.heater);
        self.violations.check(
            heater == PinMode::AlternatePushPull && self.tim3.duty(HEATER_CHANNEL).is_none(),
            "GPIOB_CRL",
            "PB0 is an output of TIM3, which does not run",
        );
    }

    /// All outputs of the modelled peripherals, and whether the peripheral drives it. A channel of a timer that captures counts too: the
    /// manual does not say what it drives.
    fn outputs(&self) -> Vec<(Output, bool)> {
        let mut all = vec![
            (Output::Can, self.is_ready(Module::Can)),
            (Output::Clock, self.rcc.outputs_clock()),
            (Output::DebugPort, true),
        ];
        for channel in 1..=4 {
            let is_on = |enabled: u32| enabled >> (4 * (channel - 1)) & 1 != 0;
            let tim3 = self.is_ready(Module::Tim3) && is_on(self.tim3.enabled());
            let tim4 = self.is_ready(Module::Tim4) && is_on(self.tim4.enabled());
            all.extend([(Output::Tim3(channel), tim3), (Output::Tim4(channel), tim4)]);
        }
        let spi = match self.board.facts().spi {
            Spi::Spi1 => Output::Spi1,
            Spi::Spi2 => Output::Spi2,
        };
        let master = self.is_ready(Module::Spi) && self.spi.is_master();
        all.extend([
            (spi(SpiOutput::Select), master && self.spi.drives_select()),
            (spi(SpiOutput::Clock), master),
            (spi(SpiOutput::Data), master),
        ]);
        all
    }

    fn is_alternate_output(&self, pin: Pin) -> bool {
        matches!(
            self.gpio.mode(pin),
            PinMode::AlternatePushPull | PinMode::AlternateOpenDrain
        )
    }

    fn check_inputs(&mut self) {
        for (name, function, pins) in INPUTS {
            let selects = |pin: &&Pin| self.gpio.alternate(**pin) == Some(function);
            let selected = pins.iter().filter(selects).count();
            self.violations
                .check(selected > 1, name, "the input has two pins");
        }
    }
}
