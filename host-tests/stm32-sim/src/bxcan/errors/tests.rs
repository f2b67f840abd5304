use super::*;

const BUS_OFF_ENABLE: u32 = 1 << 10;
const PASSIVE_ENABLE: u32 = 1 << 9;
const WARNING_ENABLE: u32 = 1 << 8;

const QUIET: [bool; 4] = [false; 4];
const TRANSMIT: [bool; 4] = [true, false, false, false];
const FIFO_0: [bool; 4] = [false, true, false, false];
const FIFO_1: [bool; 4] = [false, false, true, false];
const STATUS: [bool; 4] = [false, false, false, true];

fn counters(transmit_errors: u16, receive_errors: u16) -> Confinement {
    Confinement {
        state: BusState::Active,
        transmit_errors,
        receive_errors,
    }
}

fn bus_off() -> Confinement {
    Confinement {
        state: BusState::BusOff,
        ..counters(255, 0)
    }
}

fn enabled(bits: u32) -> Status {
    let mut status = Status::default();
    status.enable(bits);
    status
}

fn status_line(status: &Status) -> bool {
    status.lines(false, [0, 0]) == STATUS
}

#[test]
fn error_status_has_counters_and_limits() {
    let after = |confinement| {
        let mut status = Status::default();
        status.follow(confinement);
        status.error_status()
    };
    assert_eq!(after(counters(0, 0)), 0);
    assert_eq!(after(counters(95, 0)), 95 << 16);
    assert_eq!(after(counters(96, 0)), 96 << 16 | 0b001);
    assert_eq!(after(counters(0, 96)), 96 << 24 | 0b001);
    assert_eq!(after(counters(127, 0)), 127 << 16 | 0b001);
    assert_eq!(after(counters(128, 0)), 128 << 16 | 0b011);
    assert_eq!(after(counters(8, 128)), 128 << 24 | 8 << 16 | 0b011);
    assert_eq!(after(bus_off()) & 0b100, 0b100);
}

#[test]
fn limit_flags_clear_below_limits() {
    let mut status = Status::default();
    status.follow(counters(128, 0));
    status.follow(counters(127, 0));
    assert_eq!(status.error_status() & 7, 0b001);
    status.follow(counters(95, 0));
    assert_eq!(status.error_status() & 7, 0);
}

#[test]
fn last_error_code_matches_manual() {
    for (code, value) in [
        (ErrorCode::Stuff, 0b001),
        (ErrorCode::Form, 0b010),
        (ErrorCode::Acknowledgment, 0b011),
        (ErrorCode::BitRecessive, 0b100),
        (ErrorCode::BitDominant, 0b101),
        (ErrorCode::Crc, 0b110),
    ] {
        let mut status = Status::default();
        status.failed(code);
        assert_eq!(status.error_status(), value << 4);
        status.succeeded();
        assert_eq!(status.error_status(), 0);
    }
}

#[test]
fn software_can_write_seven_to_last_error_code() {
    let mut status = Status::default();
    status.failed(ErrorCode::Crc);
    assert!(status.write_error_status(7 << 4));
    assert_eq!(status.error_status(), 7 << 4);
    status.failed(ErrorCode::Crc);
    assert_eq!(status.error_status(), 6 << 4);
    assert!(!status.write_error_status(3 << 4));
}

#[test]
fn software_cannot_write_the_counters() {
    let mut status = Status::default();
    status.follow(counters(100, 3));
    status.write_error_status(0);
    assert_eq!(status.error_status(), 3 << 24 | 100 << 16 | 1);
}

#[test]
fn reached_limit_is_interrupt_when_enabled() {
    for (enable, confinement) in [
        (WARNING_ENABLE, counters(96, 0)),
        (PASSIVE_ENABLE, counters(0, 128)),
        (BUS_OFF_ENABLE, bus_off()),
    ] {
        let mut silent = enabled(ERROR_ENABLE);
        silent.follow(confinement);
        assert!(!status_line(&silent));
        let mut flagged = enabled(enable);
        flagged.follow(confinement);
        assert_eq!(flagged.interrupts(), ERROR);
        assert!(!status_line(&flagged), "ERRIE is off");
        let mut status = enabled(enable | ERROR_ENABLE);
        status.follow(counters(95, 95));
        assert!(!status_line(&status));
        status.follow(confinement);
        assert!(status_line(&status));
        // Software clears it; it is set again only when the limit is reached again.
        status.clear_interrupts(ERROR);
        status.follow(confinement);
        assert!(!status_line(&status));
        status.follow(counters(0, 0));
        assert!(!status_line(&status));
        status.follow(confinement);
        assert!(status_line(&status));
    }
}

#[test]
fn each_error_is_interrupt_when_enabled() {
    let mut status = enabled(ERROR_ENABLE);
    status.failed(ErrorCode::Stuff);
    assert!(!status_line(&status));
    status.enable(ERROR_ENABLE | LAST_ERROR_ENABLE);
    for _ in 0..2 {
        status.failed(ErrorCode::Stuff);
        assert!(status_line(&status));
        status.clear_interrupts(ERROR);
        assert!(!status_line(&status));
    }
}

#[test]
fn sleep_entry_is_interrupt_when_enabled() {
    let mut disabled = Status::default();
    disabled.sleeps(false);
    disabled.sleeps(true);
    assert_eq!(disabled.interrupts(), 0);
    let mut status = enabled(SLEEP_ENABLE);
    status.sleeps(true);
    assert!(!status_line(&status), "asleep since the reset");
    status.sleeps(false);
    status.sleeps(true);
    assert!(status_line(&status));
    status.clear_interrupts(SLEEP);
    status.sleeps(true);
    assert!(!status_line(&status));
    status.sleeps(false);
    status.sleeps(true);
    status.sleeps(false);
    assert_eq!(status.interrupts(), 0, "SLAKI is cleared with SLAK");
}

#[test]
fn wakeup_sets_flag_and_is_interrupt_when_enabled() {
    let mut status = Status::default();
    status.disturbed_in_sleep();
    assert_eq!(status.interrupts(), WAKE_UP);
    assert!(!status_line(&status));
    status.enable(WAKE_UP_ENABLE);
    assert!(status_line(&status));
    status.clear_interrupts(WAKE_UP);
    assert!(!status_line(&status));
}

#[test]
fn transmit_and_receive_interrupts_have_separate_lines() {
    let everything = [PENDING | FULL | OVERRUN; 2];
    assert_eq!(Status::default().lines(true, everything), QUIET);
    assert_eq!(enabled(1).lines(true, everything), TRANSMIT);
    assert_eq!(enabled(1).lines(false, everything), QUIET);
    // FMPIE, FFIE, FOVIE of FIFO 0, then of FIFO 1.
    for (bit, condition) in [(1, 1), (2, FULL), (3, OVERRUN)] {
        assert_eq!(enabled(1 << bit).lines(true, [condition, 0]), FIFO_0);
        assert_eq!(enabled(1 << bit).lines(true, [0, condition]), QUIET);
        assert_eq!(
            enabled(0x7E & !(1 << bit)).lines(true, [condition, 0]),
            QUIET
        );
        assert_eq!(enabled(8 << bit).lines(true, [0, condition]), FIFO_1);
        assert_eq!(enabled(8 << bit).lines(true, [condition, 0]), QUIET);
    }
}
