//! Blue Pill: STM32F103C8, 64 KiB flash, 20 KiB RAM, crystal of 8 MHz.
//!
//! | pin  | connected to                                                 |
//! |------|--------------------------------------------------------------|
//! | PB8  | CAN transceiver RXD; TIM4 measures its pulses                |
//! | PB9  | CAN transceiver TXD                                          |
//! | PA4  | ISM330DHCX CS                                                |
//! | PA5  | ISM330DHCX SCL (SPC)                                         |
//! | PA6  | ISM330DHCX SDO                                               |
//! | PA7  | ISM330DHCX SDA (SDI)                                         |
//! | PC13 | run LED: the one on the board, lit when low                  |
//! | PB12 | error LED with its resistor to ground, lit when high         |
//! | PB13 | green module LED with its resistor to ground, lit when high  |
//! | PB14 | red module LED with its resistor to ground, lit when high    |
//! | PB0  | heater switch (a logic-level MOSFET), on when high, PWM      |
//! | PB1  | switch of the 120 ohm terminating resistor, on when high     |
//!
//! PB0 and PB1 are for products with a heater or a switched terminating resistor. Each has a resistor to ground, so that both are
//! off while the microcontroller is in reset.
//!
//! CAN is remapped to PB8 and PB9, because PA12 has the pull-up of the USB socket. The transceiver runs at 3.3 V and must not
//! have a dominant time-out that is too short for 10 kbit/s; for example SN65HVD230. The core runs at 64 MHz instead of 72 so
//! that APB1 runs at 32 MHz ([`bit_timing`](crate::bit_timing)).

use super::{HEATER_PERIOD_US, SPI_CLOCK_HZ, WATCHDOG_PERIOD_MS};
use crate::can;
use crate::counts::Mounting;
use crate::flash::{ParameterFlash, Sectors};
use crate::imu::Wires;
use cortex_m::peripheral::SYST;
use embedded_hal::spi::MODE_0;
use embedded_storage::nor_flash::NorFlashErrorKind;
use plumbline::node::Leds;
use stm32f1xx_hal::flash::{self, FlashSize, SectorSize};
use stm32f1xx_hal::gpio::{Output, PA4, PB1, PB12, PB13, PB14, PC13, PinState};
use stm32f1xx_hal::pac;
pub use stm32f1xx_hal::pac::interrupt;
use stm32f1xx_hal::prelude::*;
use stm32f1xx_hal::rcc::{self, Enable};
use stm32f1xx_hal::spi::Spi;
use stm32f1xx_hal::timer::{PwmChannel, Tim3NoRemap};
use stm32f1xx_hal::watchdog::IndependentWatchdog;

/// The core clock in Hz.
pub const CORE_CLOCK: u32 = 64_000_000;

/// The clock of APB1 in Hz.
pub const APB1_CLOCK: u32 = 32_000_000;

/// The CAN controller.
pub type CanPeripheral = pac::CAN;

/// The timer of the bit rate detection. Its channel 3 is on PB8.
pub type PulseTimer = pac::TIM4;

/// The timer has captured the end of a pulse.
pub const PULSE_INTERRUPT: pac::Interrupt = pac::Interrupt::TIM4;

/// The filter banks of the CAN controller (medium-density devices; the HAL defines 28 for all devices).
pub const FILTER_BANKS: u8 = 14;

/// Receive FIFO 0 contains a frame.
pub const CAN_RECEIVE_INTERRUPT: pac::Interrupt = pac::Interrupt::USB_LP_CAN_RX0;

/// A transmit mailbox has become free.
pub const CAN_TRANSMIT_INTERRUPT: pac::Interrupt = pac::Interrupt::USB_HP_CAN_TX;

/// The mounting of the accelerometer.
pub const MOUNTING: Mounting = Mounting::ALIGNED;

/// The SPI and the chip select of the accelerometer.
pub type ImuWires = Wires<Spi<pac::SPI1, u8>, PA4<Output>>;

/// The watchdog.
pub type Watchdog = IndependentWatchdog;

/// The parts of the board that the firmware uses, initialised.
pub struct Board {
    /// The timer of the time base.
    pub systick: SYST,
    /// The independent watchdog, running.
    pub watchdog: Watchdog,
    /// The status LEDs, off.
    pub leds: StatusLeds,
    /// Heater and terminating resistor, off.
    pub switches: Switches,
    /// The CAN controller, with its clock and pins, still in reset state.
    pub can: CanPeripheral,
    /// The SPI and the chip select of the accelerometer.
    pub imu: ImuWires,
    /// The parameter memory.
    pub flash: ParameterFlash<Flash>,
    /// The serial number.
    pub serial: u32,
}

impl Board {
    /// Initialises watchdog, clocks and pins. None on a second call.
    #[inline(never)] // so that only the boot needs its stack
    pub fn take() -> Option<Self> {
        let core = cortex_m::Peripherals::take()?;
        // SAFETY: `cortex_m::Peripherals::take` has succeeded, so this is the first call.
        let device = unsafe { pac::Peripherals::steal() };

        // First, so that a crystal that does not start causes a reset and a new attempt.
        let mut watchdog = Watchdog::new(device.IWDG);
        watchdog.stop_on_debug(&device.DBGMCU, true);
        watchdog.start(WATCHDOG_PERIOD_MS.millis());

        let mut flash = device.FLASH.constrain();
        let clocks = rcc::Config::hse(8.MHz()).sysclk(64.MHz()).pclk1(32.MHz());
        let mut rcc = device.RCC.freeze(clocks, &mut flash.acr);

        let mut gpioa = device.GPIOA.split(&mut rcc);
        let mut gpiob = device.GPIOB.split(&mut rcc);
        let mut gpioc = device.GPIOC.split(&mut rcc);

        let leds = StatusLeds {
            run: gpioc
                .pc13
                .into_push_pull_output_with_state(&mut gpioc.crh, PinState::High),
            error: gpiob
                .pb12
                .into_push_pull_output_with_state(&mut gpiob.crh, PinState::Low),
            module_green: gpiob
                .pb13
                .into_push_pull_output_with_state(&mut gpiob.crh, PinState::Low),
            module_red: gpiob
                .pb14
                .into_push_pull_output_with_state(&mut gpiob.crh, PinState::Low),
        };

        // The controller is enabled first, so that it drives TXD recessive when the pin is connected.
        CanPeripheral::enable(&mut rcc);
        let mut afio = device.AFIO.constrain(&mut rcc);
        // SAFETY: 2 is the mapping to PB8 and PB9 (RM0008, AFIO_MAPR).
        afio.mapr
            .modify_mapr(|_, w| unsafe { w.can_remap().bits(2) });
        gpiob.pb8.into_pull_up_input(&mut gpiob.crh);
        gpiob.pb9.into_alternate_push_pull(&mut gpiob.crh);

        let heater_pin = gpiob.pb0.into_alternate_push_pull(&mut gpiob.crl);
        let mut heater = device
            .TIM3
            .pwm_us::<Tim3NoRemap, _, _>(
                heater_pin,
                &mut afio.mapr,
                HEATER_PERIOD_US.micros(),
                &mut rcc,
            )
            .split();
        heater.enable();
        let switches = Switches {
            heater,
            termination: gpiob
                .pb1
                .into_push_pull_output_with_state(&mut gpiob.crl, PinState::Low),
        };

        let select = gpioa
            .pa4
            .into_push_pull_output_with_state(&mut gpioa.crl, PinState::High);
        let pins = (Some(gpioa.pa5), Some(gpioa.pa6), Some(gpioa.pa7));
        let spi = device
            .SPI1
            .spi(pins, MODE_0.into(), SPI_CLOCK_HZ.Hz(), &mut rcc);

        Some(Self {
            systick: core.SYST,
            watchdog,
            leds,
            switches,
            can: device.CAN,
            imu: Wires::new(spi, select),
            flash: ParameterFlash(Flash(flash)),
            serial: super::serial(unique_id()),
        })
    }
}

/// The status LEDs.
pub struct StatusLeds {
    run: PC13<Output>,
    error: PB12<Output>,
    module_green: PB13<Output>,
    module_red: PB14<Output>,
}

impl StatusLeds {
    /// Shows `leds`.
    pub fn show(&mut self, leds: Leds) {
        self.run.set_state((!leds.run).into());
        self.error.set_state(leds.error.into());
        self.module_green.set_state(leds.module_green.into());
        self.module_red.set_state(leds.module_red.into());
    }
}

/// Heater and terminating resistor.
pub struct Switches {
    heater: PwmChannel<pac::TIM3, 2>,
    termination: PB1<Output>,
}

impl Switches {
    /// Connects or disconnects the terminating resistor.
    pub fn terminate(&mut self, on: bool) {
        self.termination.set_state(on.into());
    }

    /// Sets the power of the heater, 0 to 1000 permille.
    pub fn heat(&mut self, permille: u16) {
        // A period is 1000 ticks.
        self.heater.set_duty(permille);
    }
}

/// The last two pages of the flash. memory.x excludes them from the program memory.
pub struct Flash(flash::Parts);

/// The start of the flash. The offsets of the HAL are relative to it.
const FLASH_START: usize = 0x0800_0000;

impl Sectors for Flash {
    const START: usize = 0x0800_F800;
    const SIZE: usize = 1024;
    const COUNT: usize = 2;
    const WRITE_SIZE: usize = 2;

    fn erase(&mut self, sector: usize) -> Result<(), NorFlashErrorKind> {
        let offset = Self::START - FLASH_START + sector * Self::SIZE;
        self.0
            .writer(SectorSize::Sz1K, FlashSize::Sz64K)
            .page_erase(offset as u32)
            .map_err(|_| NorFlashErrorKind::Other)
    }

    fn program(&mut self, offset: usize, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        let offset = Self::START - FLASH_START + offset;
        self.0
            .writer(SectorSize::Sz1K, FlashSize::Sz64K)
            .write(offset as u32, bytes)
            .map_err(|_| NorFlashErrorKind::Other)
    }
}

/// The 96-bit unique device identifier (RM0008, device electronic signature).
fn unique_id() -> [u32; 3] {
    const ADDRESS: *const [u32; 3] = 0x1FFF_F7E8 as *const _;
    // SAFETY: system memory of all F103 devices, always readable, never written.
    unsafe { ADDRESS.read_volatile() }
}

/// Enables the clock of [`PulseTimer`].
pub fn enable_pulse_timer() {
    // SAFETY: the main loop is the only code that changes this register.
    let rcc = unsafe { pac::RCC::steal() };
    rcc.apb1enr().modify(|_, w| w.tim4en().set_bit());
}

#[interrupt]
fn USB_LP_CAN_RX0() {
    can::on_received();
}

#[interrupt]
fn USB_HP_CAN_TX() {
    can::on_transmitted();
}
