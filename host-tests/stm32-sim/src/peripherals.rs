//! All peripherals, and the effects of one peripheral on another. The address map and the clock gates are those of the
//! [chip](super::chip). `peripherals/access.rs` has the accesses of the processor, with the clock gating, and
//! `peripherals/accelerometer.rs` the SPI with the accelerometer, `peripherals/supply.rs` the converter at the sensor's supply,
//! `peripherals/pins.rs` the conflicts at the pins.

mod accelerometer;
mod access;
mod disturbance;
mod pins;
mod supply;
#[cfg(test)]
mod tests;

use super::adc::Adc;
use super::adxl355::Adxl355;
use super::afio::Afio;
use super::board::{self, Board};
use super::bxcan::BxCan;
use super::capture_timer::CaptureTimer;
use super::chip::{Chip, Module};
use super::crc::CrcUnit;
use super::dbgmcu::Dbgmcu;
use super::flash::FlashInterface;
use super::gpio::Gpio;
use super::ism330dhcx::Ism330dhcx;
use super::iwdg::Iwdg;
use super::pwr::Pwr;
use super::rcc::{Rcc, ResetCause};
use super::signature::Signature;
use super::silicon::Silicon;
use super::spi::Spi;
use super::timebase::Picoseconds;
use super::timer::Timer;
use super::violation::{Violation, Violations};
use bench::Flash;
use bench::motion::Motion;

/// The peripherals and the parts connected to them.
#[derive(Debug)]
pub struct Peripherals {
    board: Board,
    chip: Chip,
    /// Clocks and resets (RCC).
    pub rcc: Rcc,
    /// The supply and its detectors.
    pub pwr: Pwr,
    /// The pins of all ports.
    pub gpio: Gpio,
    /// Alternate functions of the pins of the STM32F103.
    pub afio: Afio,
    /// The flash interface with the parameter pages.
    pub flash: FlashInterface,
    /// The SPI of the accelerometer.
    pub spi: Spi,
    /// The converter at the divider of the sensor's supply.
    pub adc: Adc,
    /// The timer of the heater's PWM.
    pub tim3: Timer,
    /// The timer at RXD, for the bit rate detection.
    pub tim4: CaptureTimer,
    crc: CrcUnit,
    /// The independent watchdog (IWDG).
    pub iwdg: Iwdg,
    /// The debug support (DBGMCU).
    pub dbgmcu: Dbgmcu,
    /// The accelerometer and gyroscope on the SPI.
    pub imu: Ism330dhcx,
    /// The accelerometer of a board that has this one instead.
    pub adxl355: Option<Adxl355>,
    /// The CAN controller; CAN1 of the STM32F446.
    pub can: BxCan,
    signature: Signature,
    violations: Violations,
    changed: bool,
    touched: bool,
    /// An access to a peripheral without a clock has no effect, as on the chip.
    lenient: bool,
}

/// What drives the transceiver's TXD.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Driver {
    /// The CAN controller drives it.
    Controller,
    /// The pin has a fixed level; true is dominant.
    Fixed(bool),
}

impl Peripherals {
    /// A microcontroller with this unique device identifier and these parameter pages, powered on at cycle 0. `motion` moves its
    /// accelerometer.
    pub fn new(
        board: Board,
        unique_id: [u32; 3],
        parameters: Flash,
        motion: Box<dyn Motion>,
    ) -> Self {
        let chip = board.chip();
        let [_, lsi, _] = chip.facts().lsi;
        let mut iwdg = Iwdg::default();
        iwdg.set_lsi(lsi);
        let mut new = Self {
            board,
            chip,
            rcc: Rcc::new(chip, board.facts().has_external_clock),
            pwr: Pwr::new(chip),
            gpio: Gpio::new(chip),
            afio: Afio::default(),
            flash: FlashInterface::new(board, parameters),
            spi: Spi::default(),
            adc: Adc::new(chip, board.facts().supply_channel),
            tim3: Timer::default(),
            tim4: CaptureTimer::default(),
            crc: CrcUnit::default(),
            iwdg,
            imu: Ism330dhcx::new(motion),
            adxl355: None,
            can: match chip {
                Chip::F103 => BxCan::new(),
                Chip::F446 => BxCan::with_shared_filters(),
            },
            dbgmcu: Dbgmcu::new(chip),
            signature: Signature::new(board, unique_id),
            violations: Violations::default(),
            changed: false,
            touched: false,
            lenient: false,
        };
        new.gpio.drive(board.facts().pins.receive, Some(true));
        new.set_silicon(&Silicon::genuine(board));
        new
    }

    /// From now on an access to a peripheral without a clock has no effect, and a read returns 0, as on the chip. Without this call it stops
    /// the run.
    pub fn be_lenient(&mut self) {
        self.lenient = true;
    }

    /// Selects the behaviour in which chips differ, from the next reset on.
    pub fn set_silicon(&mut self, silicon: &Silicon) {
        self.can.set_silicon(silicon.can);
        self.flash.set_silicon(silicon);
        self.dbgmcu.set_silicon(silicon);
    }

    /// A reset at `cycle`; cycles and time continue.
    pub fn reset(&mut self, cycle: u64, cause: ResetCause) {
        self.rcc.reset(cycle, cause);
        self.flash.reset();
        self.crc = CrcUnit::default();
        self.iwdg.reset();
        self.pwr.reset();
        // All modules at the same time: a transfer that is cut off is no violation of its chip select.
        self.spi = Spi::default();
        for module in Module::WITH_RESET {
            self.reset_module(cycle, module);
        }
        self.can.set_clock(self.rcc.pclk1());
        self.changed = false;
    }

    /// The power returns at this time, cycles continue: everything restarts.
    pub fn power_on(&mut self, cycle: u64, time: Picoseconds) {
        self.rcc.go_on(cycle, time);
        self.flash.parameters_mut().power_on();
        if let Some(slot) = self.flash.slot_mut() {
            slot.power_on();
        }
        self.can.power_on();
        self.reset(cycle, ResetCause::PowerOn);
        self.imu.power_on(time);
        if let Some(part) = &mut self.adxl355 {
            part.power_on(time);
        }
        self.dbgmcu.power_on();
    }

    /// The board.
    pub fn board(&self) -> Board {
        self.board
    }

    /// The microcontroller.
    pub fn chip(&self) -> Chip {
        self.chip
    }

    /// The violations of the firmware so far.
    pub fn violations(&self) -> &[Violation] {
        self.violations.list()
    }

    /// The cycle of the next event without an access: the end of an SPI frame with its interrupt enabled, the time-out of the
    /// watchdog, a change of the clock. Then call [`settle`](Self::settle).
    pub fn next_event(&self) -> Option<u64> {
        let expiry = self
            .iwdg
            .expires_at()
            .map(|time| self.rcc.timebase().cycle_at(time));
        let cycle = |time| self.rcc.timebase().cycle_at(time);
        let supply = self.pwr.next_event().map(cycle);
        [self.spi.next_event(), self.rcc.next_event(), expiry, supply]
            .into_iter()
            .flatten()
            .min()
    }

    /// Processes the events that are due at `cycle`.
    pub fn settle(&mut self, cycle: u64) {
        self.rcc.settle(cycle);
        if self.rcc.nmi() {
            // The hardware has changed the clock: this is no violation of the firmware.
            self.can.lose_clock(self.rcc.pclk1());
        } else {
            self.can.set_clock(self.rcc.pclk1());
        }
        self.advance_spi(cycle);
    }

    /// True when the watchdog was not reloaded in time: the machine resets the microcontroller.
    pub fn watchdog_has_expired(&self, cycle: u64) -> bool {
        let now = self.now(cycle);
        self.iwdg.expires_at().is_some_and(|time| time <= now)
    }

    /// The level of the SPI's interrupt line.
    pub fn spi_interrupt(&self) -> bool {
        self.spi.interrupt()
    }

    /// The level of TIM4's interrupt line.
    pub fn tim4_interrupt(&self) -> bool {
        self.tim4.interrupt()
    }

    /// A new level of RXD; true is dominant, which is low. TIM4 has its channel 3 at PB8.
    pub fn receive_pin(&mut self, now: Picoseconds, dominant: bool) {
        let pin = self.board.facts().pins.receive;
        self.gpio.drive(pin, Some(!dominant));
        if self.is_ready(Module::Tim4) && board::pulses_are_connected(self.board, &self.gpio) {
            self.tim4.edge(now, self.rcc.timer_clock(), !dominant);
        }
    }

    /// True when the module has a clock and is out of reset.
    fn is_ready(&self, module: Module) -> bool {
        let ready = |gate| self.rcc.is_clocked(gate) && !self.rcc.is_in_reset(gate);
        self.board.gate(module).is_some_and(ready)
    }

    /// True when the CAN controller has a clock, is out of reset, and sees the board's transceiver.
    pub fn can_is_connected(&self) -> bool {
        self.is_ready(Module::Can) && board::can_receives(self.board, &self.afio, &self.gpio)
    }

    /// What drives the transceiver's TXD. Dominant is low; the transceiver pulls an undriven pin high.
    pub fn driver(&self) -> Driver {
        match self.gpio.output(self.board.facts().pins.transmit) {
            Some(high) => Driver::Fixed(!high),
            None => {
                let driven = self.is_ready(Module::Can)
                    && board::can_drives(self.board, &self.afio, &self.gpio);
                if driven {
                    Driver::Controller
                } else {
                    Driver::Fixed(false)
                }
            }
        }
    }

    /// The level at the transceiver's TXD with this driver; true is dominant.
    pub fn is_dominant(&self, driver: Driver) -> bool {
        match driver {
            Driver::Controller => self.can.is_dominant(),
            Driver::Fixed(dominant) => dominant,
        }
    }

    /// The level at the transceiver's TXD; true is dominant.
    pub fn transmits_dominant(&self) -> bool {
        self.is_dominant(self.driver())
    }

    /// True once after an access that may have changed [`next_event`](Self::next_event), [`driver`](Self::driver), the connection of the
    /// CAN controller or a pin.
    pub fn take_touched(&mut self) -> bool {
        std::mem::take(&mut self.touched)
    }

    /// The time of a cycle.
    pub fn now(&self, cycle: u64) -> Picoseconds {
        self.rcc.timebase().time_at(cycle)
    }

    /// Resets the modules of RCC's reset registers.
    fn reset_module(&mut self, cycle: u64, module: Module) {
        match module {
            Module::Can => self.can.reset(),
            Module::Pwr => self.pwr.reset(),
            Module::Afio => self.afio = Afio::default(),
            Module::Gpio(port) => self.change_pins(cycle, |gpio, _| gpio.reset(port)),
            Module::Spi => self.spi = Spi::default(),
            Module::Adc => self.adc = Adc::new(self.chip, self.board.facts().supply_channel),
            Module::Tim3 => self.tim3 = Timer::default(),
            Module::Tim4 => self.tim4 = CaptureTimer::default(),
            _ => {}
        }
    }
}
