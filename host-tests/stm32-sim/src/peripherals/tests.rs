use super::*;
use crate::flash::{Times, Work};
use crate::io::{AccessError, Io, Width};
use plumbline::measure::{I32x3, ONE_G, Reading};

const TIM3: u32 = 0x4000_0400;
const TIM4: u32 = 0x4000_0800;
const IWDG: u32 = 0x4000_3000;
const CAN: u32 = 0x4000_6400;
const AFIO: u32 = 0x4001_0000;
const GPIOA: u32 = 0x4001_0800;
const GPIOB: u32 = 0x4001_0C00;
const ADC1: u32 = 0x4001_2400;
const SPI1: u32 = 0x4001_3000;
const RCC: u32 = 0x4002_1000;
const FLASH: u32 = 0x4002_2000;

const APB2ENR: u32 = RCC + 0x18;
const APB1ENR: u32 = RCC + 0x1C;

struct Bench {
    io: Peripherals,
    cycle: u64,
}

impl Bench {
    fn new() -> Self {
        Self::of(Board::BluePill)
    }

    fn of(board: Board) -> Self {
        let level = Reading {
            acceleration: I32x3 {
                x: 0,
                y: 0,
                z: ONE_G,
            },
            angular_rate: I32x3 { x: 0, y: 0, z: 0 },
            temperature: 2500,
            clipped: false,
        };
        let flash = Flash::blank(board.chip().facts().geometry);
        Self {
            io: Peripherals::new(board, [1, 2, 3], flash, Box::new(level)),
            // The accelerometer has booted.
            cycle: 8_000_000,
        }
    }

    fn write(&mut self, address: u32, value: u32) {
        self.put(address, Width::Word, value).unwrap();
    }

    fn put(&mut self, address: u32, width: Width, value: u32) -> Result<(), AccessError> {
        self.cycle += 2;
        self.io.write(self.cycle, address, width, value)
    }

    fn read(&mut self, address: u32) -> Result<u32, AccessError> {
        self.get(address, Width::Word)
    }

    fn get(&mut self, address: u32, width: Width) -> Result<u32, AccessError> {
        self.cycle += 2;
        self.io.read(self.cycle, address, width)
    }

    /// Chip select PA4 high, SPI1 on PA5 to PA7, PCLK2 / 2.
    fn with_spi() -> Self {
        let mut bench = Self::new();
        bench.write(APB2ENR, 1 << 12 | 1 << 2 | 1);
        bench.write(GPIOA + 0x10, 1 << 4);
        bench.write(GPIOA, 0xB4B3_4444);
        bench.write(SPI1, 0x0344);
        bench
    }

    /// Sends a byte with byte accesses, as the HAL does.
    fn exchange(&mut self, byte: u8) -> u8 {
        self.put(SPI1 + 0x0C, Width::Byte, byte.into()).unwrap();
        while self.read(SPI1 + 0x08).unwrap() & 1 == 0 {}
        self.get(SPI1 + 0x0C, Width::Byte).unwrap() as u8
    }

    fn select(&mut self, low: bool) {
        self.write(GPIOA + 0x10, if low { 1 << 20 } else { 1 << 4 });
    }

    fn who_am_i(&mut self) -> u8 {
        self.select(true);
        self.exchange(0x8F);
        let answer = self.exchange(0);
        self.select(false);
        answer
    }

    fn reasons(&self) -> Vec<&'static str> {
        self.io.violations().iter().map(|it| it.reason).collect()
    }
}

#[test]
fn peripheral_without_clock_does_not_answer() {
    let mut bench = Bench::new();
    for (address, name, enable, bit) in [
        (CAN, "CAN", APB1ENR, 25),
        (AFIO + 4, "AFIO", APB2ENR, 0),
        (GPIOA, "GPIO", APB2ENR, 2),
        (GPIOB, "GPIO", APB2ENR, 3),
        (SPI1, "SPI1", APB2ENR, 12),
        (ADC1, "ADC1", APB2ENR, 9),
    ] {
        let refused = AccessError::Unclocked(name);
        assert_eq!(bench.read(address), Err(refused.clone()));
        assert_eq!(bench.put(address, Width::Word, 0), Err(refused));
        bench.write(enable, 1 << bit);
        assert!(bench.read(address).is_ok(), "{name}");
    }
}

#[test]
fn missing_peripherals_are_unmapped() {
    let mut bench = Bench::new();
    // TIM2, USART1, ADC2
    for address in [0x4000_0000, 0x4001_3800, 0x4001_2800, 0x4002_3800] {
        assert_eq!(bench.read(address), Err(AccessError::Unmapped));
    }
}

/// A conversion of 24 V, which a scene has without a supply of its own, with ADCPRE / 2 of HSI.
#[test]
fn converter_measures_supply_of_scene_through_pa0() {
    let mut bench = Bench::new();
    bench.write(APB2ENR, 1 << 9 | 1 << 2);
    bench.write(GPIOA, 0x4444_4440);
    bench.write(ADC1 + 0x10, 0b111);
    bench.write(ADC1 + 0x08, 1);
    bench.cycle += 100;
    bench.write(ADC1 + 0x08, 0b101);
    bench.cycle += 1000;
    bench.write(ADC1 + 0x08, 1);
    assert_eq!(bench.read(ADC1), Ok(0x10));
    bench.cycle += 1000;
    assert_eq!(bench.read(ADC1), Ok(0x12));
    assert_eq!(bench.read(ADC1 + 0x4C), Ok(1896));
    assert_eq!(bench.reasons(), [""; 0]);
    // The reset of the module.
    bench.write(RCC + 0x0C, 1 << 9);
    bench.write(RCC + 0x0C, 0);
    assert_eq!(bench.read(ADC1 + 0x08), Ok(0));
    // A floating input.
    bench.write(GPIOA, 0x4444_4444);
    bench.write(ADC1 + 0x08, 1);
    bench.write(ADC1 + 0x08, 1);
    assert!(bench.reasons().contains(&"the pin is not analog"));
}

#[test]
fn ports_accept_word_access_only() {
    let mut bench = Bench::new();
    bench.write(APB2ENR, 1 << 2);
    for width in [Width::Byte, Width::HalfWord] {
        assert!(matches!(
            bench.get(GPIOA, width),
            Err(AccessError::Refused(_))
        ));
        assert!(matches!(
            bench.put(GPIOA, width, 0),
            Err(AccessError::Refused(_))
        ));
    }
}

#[test]
fn accelerometer_answers_through_spi_and_pins() {
    let mut bench = Bench::with_spi();
    assert_eq!(bench.who_am_i(), 0x6B);
    assert_eq!(bench.reasons(), [""; 0]);
}

#[test]
fn accelerometer_does_not_answer_without_chip_select_or_pins() {
    let mut bench = Bench::with_spi();
    assert_eq!((bench.exchange(0x8F), bench.exchange(0)), (0xFF, 0xFF));
    // PA5 is no longer a pin of SPI1.
    bench.write(GPIOA, 0xB433_4444);
    assert_eq!(bench.who_am_i(), 0xFF);
}

/// Pins of 2 MHz (RM0008, GPIOx_CRL), SCK has 4 MHz.
#[test]
fn slow_pins_of_the_spi_are_violation() {
    let mut bench = Bench::with_spi();
    bench.write(GPIOA, 0xA4A3_4444);
    bench.who_am_i();
    let reason = "the pins of the SPI are too slow for its clock";
    assert!(bench.reasons().contains(&reason), "{:?}", bench.reasons());
}

#[test]
fn chip_select_within_frame_and_unknown_register_are_violations() {
    let mut bench = Bench::with_spi();
    bench.select(true);
    bench.write(SPI1 + 0x0C, 0x8F);
    bench.select(false);
    assert_eq!(
        bench.reasons(),
        ["the accelerometer's chip select changes within a frame"]
    );
    bench.cycle += 100;
    bench.read(SPI1 + 0x0C).unwrap();
    bench.select(true);
    bench.exchange(0xB5);
    bench.exchange(0);
    let last = bench.io.violations().last().unwrap();
    assert_eq!(last.register, "ISM330DHCX 35h");
}

#[test]
fn rcc_resets_selected_peripherals() {
    let mut bench = Bench::with_spi();
    bench.write(APB1ENR, 1 << 25);
    bench.write(CAN + 0x14, 1 << 1);
    bench.write(RCC + 0x0C, 1 << 12);
    bench.write(RCC + 0x10, 1 << 25);
    assert_eq!(bench.read(SPI1), Ok(0));
    assert_eq!(bench.reasons(), ["accessed while held in reset"]);
    bench.write(RCC + 0x0C, 0);
    bench.write(RCC + 0x10, 0);
    assert_eq!(bench.read(SPI1), Ok(0));
    assert_eq!(bench.read(CAN + 0x14), Ok(0));
    assert_eq!(bench.read(GPIOA), Ok(0xB4B3_4444), "not reset");
}

#[test]
fn too_few_wait_states_are_violation() {
    let mut bench = Bench::new();
    bench.write(FLASH, 0x31);
    bench.write(RCC, 0x0001_0083);
    bench.cycle += 8_000_000;
    bench.write(RCC + 4, 0x0019_0000);
    bench.write(RCC, 0x0101_0083);
    bench.cycle += 8_000_000;
    assert_eq!(bench.reasons(), [""; 0]);
    bench.write(RCC + 4, 0x0019_0402);
    assert_eq!(bench.reasons(), ["too few wait states for this SYSCLK"]);
    bench.write(FLASH, 0x32);
    assert_eq!(bench.reasons().len(), 1);
}

#[test]
fn can_is_connected_when_clocked_and_mapped() {
    let mut bench = Bench::new();
    bench.write(APB2ENR, 1 << 3 | 1);
    bench.write(AFIO + 4, 2 << 13);
    bench.write(GPIOB + 4, 0x4444_44B8);
    assert!(!bench.io.can_is_connected());
    bench.write(APB1ENR, 1 << 25);
    assert!(bench.io.can_is_connected());
    bench.write(CAN + 0x14, 1 << 1);
    assert_eq!(bench.read(CAN + 0x14), Ok(1 << 1));
    assert!(bench.io.take_changed());
    assert!(!bench.io.take_changed());
}

#[test]
fn transmit_pin_belongs_to_port_or_can_controller() {
    let mut bench = Bench::new();
    bench.write(APB2ENR, 1 << 3 | 1);
    bench.write(APB1ENR, 1 << 25);
    bench.write(AFIO + 4, 2 << 13);
    assert!(!bench.io.transmits_dominant(), "an input: pulled up");
    bench.io.can.take_changed();
    // A port output that is low, then high.
    bench.write(GPIOB + 4, 0x4444_4438);
    assert!(bench.io.transmits_dominant());
    assert!(bench.io.can.take_changed(), "the wire has changed");
    bench.write(GPIOB + 0x10, 1 << 9);
    assert!(!bench.io.transmits_dominant());
    assert!(bench.io.can.take_changed());
    // The controller, recessive.
    bench.write(GPIOB + 4, 0x4444_44B8);
    assert!(!bench.io.transmits_dominant());
    assert!(!bench.io.can.take_changed());
}

#[test]
fn watchdog_timeout_resets_and_sets_flag() {
    let mut bench = Bench::new();
    bench.write(IWDG, 0xCCCC);
    assert!(bench.io.take_changed());
    // 409.6 ms at 8 MHz
    let expiry = bench.cycle + 3_276_800;
    assert_eq!(bench.io.next_event(), Some(expiry));
    assert!(!bench.io.watchdog_has_expired(expiry - 1));
    assert!(bench.io.watchdog_has_expired(expiry));
    bench.io.reset(expiry, ResetCause::Watchdog);
    bench.cycle = expiry;
    assert_eq!(bench.io.next_event(), None);
    assert_eq!(bench.read(RCC + 0x24), Ok(0x2C00_0000));
}

#[test]
fn flash_operation_is_reported_once() {
    let mut bench = Bench::new();
    for (register, value) in [(4, 0x4567_0123), (4, 0xCDEF_89AB), (0x10, 1)] {
        bench.write(FLASH + register, value);
    }
    bench.put(0x0800_F800, Width::HalfWord, 0x1234).unwrap();
    assert!(bench.io.take_changed());
    let expected = Work::Program {
        address: 0x0800_F800,
        width: Width::HalfWord,
        value: 0x1234,
        duration: Times::typical(Chip::F103).program,
    };
    assert_eq!(bench.io.flash.take_work(), Some(expected));
    assert!(bench.put(0x0800_F800, Width::Word, 0).is_err());
}

const WITHOUT_HSI: &str = "the flash is programmed or erased without HSI";

#[test]
fn programming_without_hsi_is_violation() {
    let mut bench = Bench::new();
    bench.write(RCC, 0x0001_0083);
    bench.cycle += 8_000_000;
    bench.write(RCC + 4, 1);
    bench.write(RCC, 0x0001_0080);
    for (register, value) in [(4, 0x4567_0123), (4, 0xCDEF_89AB), (0x10, 1)] {
        bench.write(FLASH + register, value);
    }
    bench.put(0x0800_F800, Width::HalfWord, 0).unwrap();
    assert_eq!(bench.reasons(), [WITHOUT_HSI]);
}

#[test]
fn erasing_without_hsi_is_violation() {
    let mut bench = Bench::new();
    bench.write(RCC, 0x0001_0083);
    bench.cycle += 8_000_000;
    bench.write(RCC + 4, 1);
    bench.write(RCC, 0x0001_0080);
    for (register, value) in [
        (4, 0x4567_0123),
        (4, 0xCDEF_89AB),
        (0x10, 2),
        (0x14, 0x0800_F800),
        (0x10, 0x42),
    ] {
        bench.write(FLASH + register, value);
    }
    assert_eq!(bench.reasons(), [WITHOUT_HSI]);
}

#[test]
fn lsi_is_ready_while_watchdog_runs() {
    let mut bench = Bench::new();
    assert_eq!(bench.read(RCC + 0x24).map(|csr| csr & 0b11), Ok(0));
    bench.write(IWDG, 0xCCCC);
    bench.cycle += 85 * 8;
    assert_eq!(bench.read(RCC + 0x24).map(|csr| csr & 0b11), Ok(0b10));
}

#[test]
fn end_of_frame_is_event_when_interrupt_is_enabled() {
    let mut bench = Bench::with_spi();
    bench.write(SPI1 + 4, 1 << 6);
    bench.io.take_changed();
    bench.write(SPI1 + 0x0C, 0x8F);
    assert!(bench.io.take_changed());
    // 8 bits at PCLK2 / 2
    let end = bench.cycle + 16;
    assert_eq!(bench.io.next_event(), Some(end));
    bench.io.settle(end - 1);
    assert!(!bench.io.spi_interrupt());
    bench.io.settle(end);
    assert!(bench.io.spi_interrupt());
    bench.cycle = end;
    bench.read(SPI1 + 0x0C).unwrap();
    assert!(bench.io.take_changed() && !bench.io.spi_interrupt());
}

mod f446;

#[test]
fn two_outputs_at_a_pin_are_a_violation() {
    const CONFLICT: &str = "two outputs drive one pin";
    // Channel 4 of TIM4 and CAN_TX at PB9.
    let mut bench = Bench::new();
    bench.write(APB2ENR, 1 << 3 | 1);
    bench.write(APB1ENR, 1 << 25 | 1 << 2);
    bench.write(AFIO + 4, 2 << 13);
    bench.write(TIM4 + 0x1C, 0x3231);
    bench.write(TIM4 + 0x20, 0x3100);
    bench.write(GPIOB + 4, 0x4444_4438);
    assert_eq!(bench.reasons(), [""; 0]);
    bench.write(GPIOB + 4, 0x4444_44B8);
    assert_eq!(bench.reasons(), [CONFLICT]);
    // Channel 2 of TIM3 and MOSI at PA7; with TIM3 remapped it is at PB5.
    for (mapr, expected) in [(0, vec![CONFLICT]), (0b10 << 10, vec![])] {
        let mut bench = Bench::with_spi();
        bench.write(APB1ENR, 1 << 1);
        bench.write(AFIO + 4, mapr);
        assert_eq!(bench.reasons(), [""; 0]);
        bench.write(TIM3 + 0x20, 0x10);
        assert_eq!(bench.reasons(), expected);
    }
    // JTDO and SCK of the remapped SPI1 at PB3.
    let mut bench = Bench::with_spi();
    bench.write(APB2ENR, 1 << 12 | 1 << 3 | 1 << 2 | 1);
    bench.write(AFIO + 4, 1);
    assert_eq!(bench.reasons(), [""; 0]);
    bench.write(GPIOB, 0x4444_B444);
    assert_eq!(bench.reasons(), [CONFLICT]);
    bench.write(AFIO + 4, 0b010 << 24 | 1);
    assert_eq!(
        bench.reasons(),
        [CONFLICT],
        "without JTAG there is no other one"
    );
}

#[test]
fn output_of_a_stopped_timer_is_a_violation() {
    let mut bench = Bench::new();
    bench.write(APB2ENR, 1 << 3 | 1);
    bench.write(GPIOB, 0x4444_4443);
    assert_eq!(bench.reasons(), [""; 0]);
    bench.write(GPIOB, 0x4444_444B);
    assert_eq!(
        bench.reasons(),
        ["PB0 is an output of TIM3, which does not run"]
    );
}
