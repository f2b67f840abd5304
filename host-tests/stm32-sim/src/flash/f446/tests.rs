use super::*;
use crate::board::Board;
use crate::chip::Chip;
use crate::flash::{Times, Work};
use crate::pwr::Pwr;
use crate::timebase::MICROSECOND;
use bench::{Flash, Geometry};

const KEYR: u32 = 0x04;
const SR: u32 = 0x0C;
const CR: u32 = 0x10;

/// FLASH_ACR.DCRST.
const DATA_CACHE_RESET: u32 = 1 << 12;

/// PSIZE.
const HALF_WORDS: u32 = 1 << 8;
const WORDS: u32 = 2 << 8;

/// Sector 2.
const PARAMETERS: u32 = 0x0800_8000;

struct Bench {
    flash: FlashInterface,
    violations: Violations,
    now: Picoseconds,
}

impl Bench {
    fn unlocked() -> Self {
        let mut bench = Self {
            flash: FlashInterface::new(Board::NucleoF446, Flash::blank(Geometry::STM32F446)),
            violations: Violations::default(),
            now: 0,
        };
        bench.write(KEYR, 0x4567_0123);
        bench.write(KEYR, 0xCDEF_89AB);
        bench
    }

    fn write(&mut self, offset: u32, value: u32) {
        let Self { flash, now, .. } = self;
        flash
            .write(*now, offset, value, &mut self.violations)
            .unwrap();
    }

    fn put(&mut self, address: u32, width: Width, value: u32) -> Option<Work> {
        let Self { flash, now, .. } = self;
        flash
            .program(*now, address, width, value, &mut self.violations)
            .unwrap();
        self.finish()
    }

    fn erase(&mut self, sector: u32, size: u32) -> Option<Work> {
        self.write(CR, ERASE | sector << 3 | size);
        self.write(CR, ERASE | sector << 3 | size | START);
        self.finish()
    }

    fn finish(&mut self) -> Option<Work> {
        let work = self.flash.take_work();
        self.now += work.map_or(0, Work::duration);
        work
    }

    fn read(&mut self, offset: u32) -> u32 {
        self.flash
            .read(self.now, offset, &mut Violations::default())
            .unwrap()
    }

    fn reasons(&self) -> Vec<&'static str> {
        self.violations.list().iter().map(|it| it.reason).collect()
    }
}

#[test]
fn reset_values_match_manual() {
    // RM0390, section 3.8; FLASH_OPTCR has BOR_LEV = 0 (README).
    let memory = Flash::blank(Geometry::STM32F446);
    let mut flash = FlashInterface::new(Board::NucleoF446, memory);
    let values = [0x00, SR, CR, 0x14]
        .map(|offset| flash.read(0, offset, &mut Violations::default()).unwrap());
    assert_eq!(values, [0, 0, 0x8000_0000, 0x0FFF_AAE1]);
}

#[test]
fn units_of_one_two_and_four_bytes_are_programmed() {
    let (typical, longest) = (Times::typical(Chip::F446), Times::longest(Chip::F446));
    for (times, microseconds, size, width, value) in [
        (typical, 16, 0, Width::Byte, 0x12),
        (typical, 16, HALF_WORDS, Width::HalfWord, 0x1234),
        (typical, 16, WORDS, Width::Word, 0x1234_5678),
        (longest, 100, WORDS, Width::Word, 0x1234_5678),
    ] {
        let mut bench = Bench::unlocked();
        bench.flash.set_times(times);
        bench.write(CR, PROGRAM | size);
        let work = bench.put(PARAMETERS + 0x4000, width, value);
        let expected = Work::Program {
            address: PARAMETERS + 0x4000,
            width,
            value,
            duration: microseconds * MICROSECOND,
        };
        assert_eq!(work, Some(expected));
        let held = &bench.flash.parameters().bytes()[0x4000..][..width.bytes()];
        assert_eq!(*held, value.to_le_bytes()[..width.bytes()]);
        assert_eq!((bench.read(SR), bench.reasons().len()), (0, 0));
    }
}

#[test]
fn sector_is_erased_and_takes_time_by_psize() {
    // DS10693: typical and longest times of a sector of 16 KiB.
    let (typical, longest) = (Times::typical(Chip::F446), Times::longest(Chip::F446));
    for (times, size, milliseconds) in [
        (typical, 0, 400),
        (typical, HALF_WORDS, 300),
        (typical, WORDS, 250),
        (longest, 0, 800),
        (longest, HALF_WORDS, 600),
        (longest, WORDS, 500),
    ] {
        let mut bench = Bench::unlocked();
        bench.flash.set_times(times);
        bench.write(CR, PROGRAM | WORDS);
        bench.put(PARAMETERS, Width::Word, 0);
        bench.put(PARAMETERS + 0x4000, Width::Word, 0);
        let work = bench.erase(3, size);
        let expected = Work::Erase {
            page: PARAMETERS + 0x4000,
            size: 0x4000,
            duration: milliseconds * 1000 * MICROSECOND,
        };
        assert_eq!(work, Some(expected));
        let bytes = bench.flash.parameters().bytes();
        assert_eq!((bytes[0], bytes[0x4000]), (0, 0xFF));
        assert_eq!(bench.reasons(), [""; 0]);
    }
}

#[test]
fn wrong_width_and_missing_pg_set_flags() {
    let mut bench = Bench::unlocked();
    bench.write(CR, PROGRAM | WORDS);
    assert_eq!(bench.put(PARAMETERS, Width::HalfWord, 0), None);
    assert_eq!(bench.read(SR), PARALLELISM_ERROR);
    bench.write(SR, PARALLELISM_ERROR);
    bench.write(CR, WORDS);
    assert_eq!(bench.put(PARAMETERS, Width::Word, 0), None);
    assert_eq!(bench.read(SR), SEQUENCE_ERROR);
    assert_eq!(bench.reasons().len(), 2);
    assert_eq!(bench.flash.parameters().bytes()[..4], [0xFF; 4]);
}

#[test]
fn bit_cannot_be_programmed_to_1() {
    let mut bench = Bench::unlocked();
    bench.write(CR, PROGRAM | WORDS);
    bench.put(PARAMETERS, Width::Word, 0x0F);
    bench.put(PARAMETERS, Width::Word, 0xF3);
    assert_eq!(bench.reasons(), ["a bit is programmed from 0 to 1"]);
    assert_eq!(bench.flash.parameters().bytes()[..4], [0x03, 0, 0, 0]);
}

#[test]
fn sectors_of_program_and_locked_register_are_not_changed() {
    let mut bench = Bench::unlocked();
    assert_eq!(bench.erase(1, WORDS), None);
    assert_eq!(bench.erase(4, WORDS), None);
    bench.write(CR, PROGRAM | WORDS);
    assert_eq!(bench.put(0x0801_0000, Width::Word, 0), None);
    assert_eq!(bench.reasons().len(), 3);
    bench.write(CR, LOCK);
    bench.write(CR, PROGRAM);
    assert_eq!(bench.read(CR) & LOCK, LOCK);
    assert_eq!(bench.reasons().last(), Some(&"written while it is locked"));
}

#[test]
fn data_cache_must_be_reset_after_erase() {
    let mut bench = Bench::unlocked();
    bench.write(0x00, DATA_CACHE | 4);
    bench.erase(2, WORDS);
    bench.write(CR, LOCK);
    bench.write(KEYR, 0x4567_0123);
    assert_eq!(
        bench.reasons(),
        ["the data cache is not reset after an erase"]
    );

    let mut bench = Bench::unlocked();
    bench.write(0x00, DATA_CACHE | 4);
    bench.erase(2, WORDS);
    bench.write(CR, LOCK);
    for acr in [4, DATA_CACHE_RESET | 4, 4, DATA_CACHE | 4] {
        bench.write(0x00, acr);
    }
    bench.write(KEYR, 0x4567_0123);
    assert_eq!(bench.reasons(), [""; 0]);
    bench.write(0x00, DATA_CACHE | DATA_CACHE_RESET | 4);
    assert_eq!(bench.reasons(), ["a cache is reset while it is enabled"]);
}

#[test]
fn required_wait_states_match_manual() {
    // RM0390, table 6, 2.7 V to 3.6 V: one more for each 30 MHz.
    for (latency, most) in [(0, 30_000_000), (3, 120_000_000), (4, 150_000_000)] {
        let mut bench = Bench::unlocked();
        bench.write(0x00, latency);
        bench.flash.check_wait_states(most, &mut bench.violations);
        assert_eq!(bench.reasons().len(), 0);
        bench
            .flash
            .check_wait_states(most + 1, &mut bench.violations);
        assert_eq!(bench.reasons().len(), 1);
    }
}

/// RM0390, program/erase parallelism: words need 2.7 V, half-words 2.1 V, bytes 1.8 V.
#[test]
fn supply_limits_width_of_operations() {
    const TOO_LOW: &str = "the supply is too low for an operation of this width";
    for (size, width, limit) in [
        (0, Width::Byte, 1800),
        (HALF_WORDS, Width::HalfWord, 2100),
        (WORDS, Width::Word, 2700),
    ] {
        for (millivolts, reasons) in [(limit, &[][..]), (limit - 1, &[TOO_LOW])] {
            for erases in [false, true] {
                let mut bench = Bench::unlocked();
                let mut pwr = Pwr::new(Chip::F446);
                pwr.ramp(0, millivolts, 0);
                pwr.disable_brown_out();
                bench.flash.set_supply(pwr.supply(), pwr.reset_level());
                if erases {
                    bench.erase(3, size);
                } else {
                    bench.write(CR, PROGRAM | size);
                    bench.put(PARAMETERS, width, 0);
                }
                assert_eq!(bench.reasons(), reasons, "{millivolts} mV");
                assert_eq!(bench.flash.power_is_cut(), !reasons.is_empty());
            }
        }
    }
}

#[test]
fn reset_by_the_supply_cuts_off_an_operation() {
    let mut bench = Bench::unlocked();
    let mut pwr = Pwr::new(Chip::F446);
    // 2.85 V to 2.75 V within the erase; the brown-out reset is typically at 2.83 V.
    pwr.ramp(0, 2850, 0);
    pwr.ramp(0, 2750, 200_000 * MICROSECOND);
    bench.flash.set_supply(pwr.supply(), pwr.reset_level());
    bench.erase(3, WORDS);
    assert_eq!(
        bench.reasons(),
        ["the supply is too low before the end of an operation"]
    );
    assert!(bench.flash.power_is_cut());
}
