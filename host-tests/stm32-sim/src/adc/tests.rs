use super::*;

/// A converter at the supply of a sensor, with 3.3 V at the microcontroller.
struct Bench {
    adc: Adc,
    now: Picoseconds,
    supply: u32,
    clock: u32,
    is_analog: bool,
    violations: Violations,
}

/// The offsets of ADC_SR, ADC_CR2 and ADC_DR.
const SR: u32 = 0x00;
const CR2: u32 = 0x08;
const DR: u32 = 0x4C;

impl Bench {
    /// Set up as RM0008 and RM0390 describe, 10.7 MHz and 239.5 clocks, or 16 MHz and 480 clocks; not switched on.
    fn new(chip: Chip) -> Self {
        let mut bench = Self {
            adc: Adc::new(chip, if chip == Chip::F103 { 0 } else { 10 }),
            now: SECOND,
            supply: 24_000,
            clock: match chip {
                Chip::F103 => 64_000_000 / 6,
                Chip::F446 => 64_000_000,
            },
            is_analog: true,
            violations: Violations::default(),
        };
        match chip {
            Chip::F103 => bench.write(0x10, 0b111),
            Chip::F446 => {
                bench.write(0x304, 1 << 16);
                bench.write(0x0C, 0b111);
                bench.write(0x34, 10);
            }
        }
        bench
    }

    /// Switched on, stable, and calibrated.
    fn ready(chip: Chip) -> Self {
        let mut bench = Self::new(chip);
        bench.write(CR2, ON);
        bench.now += 3 * MICROSECOND;
        if chip == Chip::F103 {
            bench.calibrate();
        }
        bench
    }

    fn calibrate(&mut self) {
        for bit in [RESET_CALIBRATION, CALIBRATE] {
            self.write(CR2, ON | bit);
            assert_eq!(self.read(CR2), ON | bit);
            self.now += 8 * MICROSECOND;
            assert_eq!(self.read(CR2), ON);
        }
    }

    fn start(&mut self) {
        match self.adc.chip {
            Chip::F103 => self.write(CR2, ON),
            Chip::F446 => self.write(CR2, ON | F446_START),
        }
    }

    fn read(&mut self, offset: u32) -> u32 {
        let supply = self.supply;
        self.adc.advance(self.now, |_| (supply, 3300));
        self.adc.read(offset).unwrap()
    }

    fn write(&mut self, offset: u32, value: u32) {
        let (now, clock, is_analog) = (self.now, self.clock, self.is_analog);
        let around = Surroundings {
            now,
            clock,
            is_analog,
        };
        let supply = self.supply;
        self.adc.advance(now, |_| (supply, 3300));
        self.adc
            .write(offset, value, around, &mut self.violations)
            .unwrap();
    }

    fn reasons(&self) -> Vec<&'static str> {
        self.violations.list().iter().map(|it| it.reason).collect()
    }
}

#[test]
fn conversion_of_supply_is_proportional() {
    for chip in Chip::ALL {
        let mut bench = Bench::ready(chip);
        // 24 V * 6.8 / 106.8 = 1.5281 V; 1.5281 / 3.3 * 4096 = 1896.7.
        for (supply, count) in [
            (0, 0),
            (8_000, 632),
            (24_000, 1896),
            (36_000, 2845),
            (60_000, 4095),
        ] {
            bench.supply = supply;
            bench.start();
            assert_eq!(bench.read(SR), STARTED, "{chip:?}");
            bench.now += 40 * MICROSECOND;
            assert_eq!(bench.read(SR), STARTED | END_OF_CONVERSION);
            assert_eq!(bench.read(DR), count, "{chip:?} {supply} mV");
            assert_eq!(bench.read(SR), STARTED, "reading ADC_DR clears EOC");
            bench.write(SR, 0);
            assert_eq!(bench.read(SR), 0);
        }
        assert_eq!(bench.reasons(), [""; 0]);
    }
}

#[test]
fn conversion_takes_sampling_time_and_12_5_or_12_clocks() {
    // 252 / 10.67 MHz = 23.62 us; 492 / 16 MHz = 30.75 us.
    for (chip, nanoseconds) in [(Chip::F103, 23_625), (Chip::F446, 30_750)] {
        let mut bench = Bench::ready(chip);
        bench.start();
        bench.now += nanoseconds * MICROSECOND / 1000 - 5000;
        assert_eq!(bench.read(SR) & END_OF_CONVERSION, 0, "{chip:?}");
        bench.now += 10_000;
        assert_ne!(bench.read(SR) & END_OF_CONVERSION, 0, "{chip:?}");
    }
}

#[test]
fn stm32f103_starts_by_swstart_with_its_trigger() {
    let mut bench = Bench::ready(Chip::F103);
    bench.write(CR2, ON | F103_EVENT | F103_TRIGGER);
    bench.write(CR2, ON | F103_EVENT | F103_TRIGGER | F103_START);
    assert_eq!(bench.read(CR2), ON | F103_EVENT | F103_TRIGGER);
    bench.now += 30 * MICROSECOND;
    assert_ne!(bench.read(SR) & END_OF_CONVERSION, 0);
    // A write of ADON that changes another bit starts nothing.
    let mut bench = Bench::ready(Chip::F103);
    bench.write(CR2, ON | F103_TRIGGER);
    assert_eq!(bench.read(SR), 0);
}

#[test]
fn conversion_against_datasheet_is_a_violation() {
    type Change = fn(&mut Bench);
    let cases: [(Chip, Change, &str); 9] = [
        (
            Chip::F103,
            |it| it.clock = 16_000_000,
            "the clock is too fast",
        ),
        (
            Chip::F446,
            |it| it.clock = 180_000_000,
            "the clock is too fast",
        ),
        (
            Chip::F103,
            |it| it.is_analog = false,
            "the pin is not analog",
        ),
        (
            Chip::F446,
            |it| it.is_analog = false,
            "the pin is not analog",
        ),
        (Chip::F103, Bench::start, "starts again while it converts"),
        (
            Chip::F103,
            |it| it.write(0x34, 1),
            "nothing is connected to the channel",
        ),
        (
            Chip::F103,
            |it| it.write(0x10, 0),
            "the sampling time is too short for the divider",
        ),
        (
            Chip::F446,
            |it| it.write(0x0C, 0),
            "the sampling time is too short for the divider",
        ),
        (
            Chip::F446,
            |it| {
                it.write(CR2, 0);
                it.write(CR2, ON);
            },
            "converts before the converter is stable",
        ),
    ];
    for (chip, change, reason) in cases {
        let mut bench = Bench::ready(chip);
        change(&mut bench);
        bench.start();
        assert!(bench.reasons().contains(&reason), "{:?}", bench.reasons());
    }
    let mut bench = Bench::new(Chip::F103);
    bench.write(CR2, ON);
    bench.now += MICROSECOND;
    bench.start();
    assert_eq!(bench.reasons(), ["converts without calibration"]);
}

#[test]
fn function_not_modelled_is_a_violation() {
    for (chip, offset, value) in [
        (Chip::F103, 0x04, 1 << 8),
        (Chip::F103, CR2, ON | 1 << 1),
        (Chip::F103, CR2, ON | 1 << 8),
        (Chip::F446, CR2, ON | 1 << 10),
        (Chip::F446, 0x304, 0b110),
        (Chip::F103, 0x2C, 1 << 20),
    ] {
        let mut bench = Bench::ready(chip);
        bench.write(offset, value);
        assert_eq!(bench.reasons().len(), 1, "{chip:?} {offset:#x} {value:#x}");
    }
    for offset in [0x14, 0x24, 0x28, 0x38, 0x3C, 0x50] {
        assert!(Adc::new(Chip::F446, 10).read(offset).is_err());
    }
    assert!(Adc::new(Chip::F103, 0).read(0x304).is_err());
}
