use super::*;
use crate::board::Board;
use crate::chip::Chip;
use crate::flash::{Times, Work};
use bench::Flash;

const KEYR: u32 = 0x04;
const SR: u32 = 0x0C;
const CR: u32 = 0x10;
const AR: u32 = 0x14;

const PAGE: u32 = 0x0800_F800;

struct Bench {
    flash: FlashInterface,
    violations: Violations,
    now: Picoseconds,
}

impl Bench {
    fn new() -> Self {
        Self {
            flash: FlashInterface::new(Board::BluePill, Flash::default()),
            violations: Violations::default(),
            now: 0,
        }
    }

    fn unlocked() -> Self {
        let mut bench = Self::new();
        bench.write(KEYR, 0x4567_0123).unwrap();
        bench.write(KEYR, 0xCDEF_89AB).unwrap();
        bench
    }

    fn write(&mut self, offset: u32, value: u32) -> Result<(), AccessError> {
        self.flash
            .write(self.now, offset, value, &mut self.violations)
    }

    fn read(&mut self, offset: u32) -> u32 {
        self.flash
            .read(self.now, offset, &mut Violations::default())
            .unwrap()
    }

    fn put(&mut self, address: u32, width: Width, value: u32) -> Result<(), AccessError> {
        self.flash
            .program(self.now, address, width, value, &mut self.violations)
    }

    /// Programs a half-word as a driver does; returns the operation, and FLASH_SR at its end.
    fn program(&mut self, address: u32, value: u16) -> (Option<Work>, u32) {
        self.write(CR, PROGRAM).unwrap();
        self.put(address, Width::HalfWord, value.into()).unwrap();
        self.finish()
    }

    fn erase(&mut self, address: u32) -> (Option<Work>, u32) {
        self.write(CR, ERASE).unwrap();
        self.write(AR, address).unwrap();
        self.write(CR, ERASE | START).unwrap();
        self.finish()
    }

    fn finish(&mut self) -> (Option<Work>, u32) {
        let work = self.flash.take_work();
        self.now += work.map_or(0, Work::duration);
        (work, self.read(SR))
    }

    fn reasons(&self) -> Vec<&'static str> {
        self.violations.list().iter().map(|it| it.reason).collect()
    }
}

/// The operation that programs a half-word.
fn programmed(address: u32, value: u32) -> Work {
    Work::Program {
        address,
        width: Width::HalfWord,
        value,
        duration: Times::typical(Chip::F103).program,
    }
}

#[test]
fn reset_values() {
    // PM0075, chapter 3
    let mut bench = Bench::new();
    for (offset, value) in [
        (0x00, 0x30),
        (SR, 0),
        (CR, 0x80),
        (AR, 0),
        (0x1C, 0x03FF_FFFC),
    ] {
        assert_eq!(bench.read(offset), value, "offset {offset:02X}h");
    }
}

#[test]
fn two_keys_unlock_interface() {
    let mut bench = Bench::unlocked();
    assert_eq!(bench.read(CR), 0);
    bench.write(CR, LOCK).unwrap();
    assert_eq!(bench.read(CR), LOCK);
    bench.write(CR, PROGRAM).unwrap();
    assert_eq!(bench.read(CR), LOCK);
    assert_eq!(bench.reasons(), ["written while it is locked"]);
}

#[test]
fn wrong_key_locks_until_next_reset() {
    for keys in [[0xCDEF_89AB, 0x4567_0123], [0x4567_0123, 0x4567_0123]] {
        let mut bench = Bench::new();
        assert!(keys.into_iter().any(|key| bench.write(KEYR, key).is_err()));
        assert!(bench.write(KEYR, 0x4567_0123).is_err());
        assert!(bench.write(KEYR, 0xCDEF_89AB).is_err());
        assert_eq!(bench.read(CR), LOCK);
        bench.flash.reset();
        bench.write(KEYR, 0x4567_0123).unwrap();
        bench.write(KEYR, 0xCDEF_89AB).unwrap();
        assert_eq!(bench.read(CR), 0);
    }
}

#[test]
fn half_word_is_programmed() {
    let mut bench = Bench::unlocked();
    bench.write(CR, PROGRAM).unwrap();
    bench.put(PAGE + 6, Width::HalfWord, 0xBEEF).unwrap();
    assert_eq!(bench.read(SR), BUSY);
    let (work, status) = bench.finish();
    assert_eq!(work, Some(programmed(PAGE + 6, 0xBEEF)));
    assert_eq!(status, END_OF_OPERATION);
    assert_eq!(bench.now, 52_500_000);
    assert_eq!(bench.flash.parameters().bytes()[6..8], [0xEF, 0xBE]);
    bench.write(SR, END_OF_OPERATION).unwrap();
    assert_eq!(bench.read(SR), 0);
}

#[test]
fn only_erased_half_word_can_be_programmed_except_to_zero() {
    let mut bench = Bench::unlocked();
    bench.program(PAGE, 0x00FF);
    bench.write(SR, END_OF_OPERATION).unwrap();
    assert_eq!(bench.program(PAGE, 0x000F), (None, PROGRAMMING_ERROR));
    assert_eq!(bench.flash.parameters().bytes()[..2], [0xFF, 0x00]);
    bench.write(SR, PROGRAMMING_ERROR).unwrap();
    assert_eq!(bench.read(SR), 0);
    let (work, status) = bench.program(PAGE, 0);
    assert!(work.is_some() && status == END_OF_OPERATION);
}

#[test]
fn other_widths_and_missing_pg_are_refused() {
    let mut bench = Bench::unlocked();
    assert!(bench.put(PAGE, Width::HalfWord, 0).is_err());
    bench.write(CR, PROGRAM).unwrap();
    assert!(bench.put(PAGE, Width::Byte, 0).is_err());
    assert!(bench.put(PAGE, Width::Word, 0).is_err());
    assert_eq!(bench.flash.parameters().programmed(), 0);
}

#[test]
fn page_is_erased() {
    let mut bench = Bench::unlocked();
    bench.program(PAGE + 1024, 0x1234);
    bench.program(PAGE, 0x5678);
    bench.now = 0;
    // Any address in the page is accepted.
    let (work, status) = bench.erase(PAGE + 1024 + 500);
    let expected = Work::Erase {
        page: PAGE + 1024,
        size: 1024,
        duration: Times::typical(Chip::F103).erase[0],
    };
    assert_eq!(work, Some(expected));
    assert_eq!(status, END_OF_OPERATION);
    assert_eq!(bench.now, 30_000_000_000);
    let bytes = bench.flash.parameters().bytes();
    assert_eq!((bytes[1024], bytes[0]), (0xFF, 0x78));
    assert_eq!(bench.reasons(), [""; 0]);
}

#[test]
fn strt_reads_as_0_and_start_while_busy_is_violation() {
    let mut bench = Bench::unlocked();
    bench.write(CR, ERASE).unwrap();
    bench.write(AR, PAGE).unwrap();
    bench.write(CR, ERASE | START).unwrap();
    bench.write(CR, PROGRAM).unwrap();
    assert_eq!(bench.reasons(), ["written while the flash is busy"]);
    bench.finish();
    assert_eq!(bench.read(CR), ERASE);
}

#[test]
fn pages_of_program_are_not_changed() {
    let mut bench = Bench::unlocked();
    assert_eq!(bench.program(0x0800_F7FE, 0).0, None);
    assert_eq!(bench.erase(0x0800_0000).0, None);
    bench.write(CR, MASS_ERASE | START).unwrap();
    assert!(bench.reasons().len() >= 3);
    assert_eq!(bench.flash.take_work(), None);
}

#[test]
fn required_wait_states_match_manual() {
    // PM0075, FLASH_ACR: one above 24 MHz, two above 48 MHz.
    let is_enough = |latency, sysclk| {
        let mut bench = Bench::new();
        bench.write(0x00, latency).unwrap();
        bench.flash.check_wait_states(sysclk, &mut bench.violations);
        bench.reasons().is_empty()
    };
    for (latency, most) in [(0, 24_000_000), (1, 48_000_000)] {
        assert!(is_enough(latency, most));
        assert!(!is_enough(latency, most + 1));
    }
    assert!(is_enough(2, 72_000_000));
}

#[test]
fn blown_fuse_cuts_power() {
    let mut bench = Bench::unlocked();
    // The first operation is complete, the second is not.
    bench.flash.parameters_mut().cut_in_operation_after(1, 7);
    bench.erase(PAGE);
    assert!(!bench.flash.power_is_cut());
    bench.program(PAGE, 0);
    assert!(bench.flash.power_is_cut());
    bench.flash.parameters_mut().power_on();
    assert!(!bench.flash.power_is_cut());
}

#[test]
fn faulty_memory_takes_same_time_without_error() {
    let mut bench = Bench::unlocked();
    bench.flash.parameters_mut().fail_writes(true);
    bench.flash.parameters_mut().fail_erases(true);
    let duration = Times::typical(Chip::F103).program;
    assert_eq!(
        bench.program(PAGE, 0),
        (Some(Work::Failed { duration }), END_OF_OPERATION)
    );
    let duration = Times::typical(Chip::F103).erase[0];
    assert_eq!(bench.erase(PAGE).0, Some(Work::Failed { duration }));
    bench.flash.parameters_mut().fail_writes(false);
    bench.flash.parameters_mut().wear_out(3);
    assert_eq!(bench.program(PAGE, 0).0, Some(programmed(PAGE, 0x0008)));
}

#[test]
fn state_of_an_operation_is_read_behind_a_barrier() {
    for fenced in [true, false] {
        let mut bench = Bench::unlocked();
        bench.write(CR, PROGRAM).unwrap();
        bench.put(PAGE, Width::HalfWord, 0x1234).unwrap();
        if fenced {
            bench.flash.barrier();
        }
        let (now, violations) = (bench.now, &mut bench.violations);
        bench.flash.read(now, SR, violations).unwrap();
        assert_eq!(violations.list().is_empty(), fenced);
    }
}
