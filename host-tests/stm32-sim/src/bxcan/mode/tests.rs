use super::*;

const BUSY: bool = true;
const QUIET: bool = false;

/// A controller in this mode, with the corresponding requests.
fn control(mode: Mode) -> Control {
    let mut control = Control::default();
    control.write(match mode {
        Mode::Sleep | Mode::Resetting => SLEEP,
        Mode::Initialization => INITIALIZATION,
        Mode::Normal => 0,
    });
    control.enter(mode);
    assert_eq!(control.due(QUIET), None);
    control
}

fn requested(mode: Mode, bits: u32) -> Control {
    let mut control = control(mode);
    control.write(bits);
    control
}

#[test]
fn reset_enters_sleep_mode() {
    let control = Control::default();
    assert_eq!(control.value(), 0x0001_0002);
    assert_eq!(control.acknowledged(), SLEEP_ACKNOWLEDGED);
    assert_eq!(control.due(QUIET), None);
    assert!(!control.is_on());
}

#[test]
fn each_mode_sets_its_acknowledge_bit() {
    assert_eq!(control(Mode::Initialization).acknowledged(), 0b01);
    assert_eq!(control(Mode::Sleep).acknowledged(), 0b10);
    assert_eq!(control(Mode::Normal).acknowledged(), 0b00);
}

#[test]
fn change_between_sleep_and_initialization_ignores_bus() {
    let to_initialization = requested(Mode::Sleep, INITIALIZATION);
    let acknowledge = Some(Change::Acknowledge(Mode::Initialization));
    assert_eq!(to_initialization.due(QUIET), acknowledge);
    assert_eq!(to_initialization.due(BUSY), acknowledge);
    let to_sleep = requested(Mode::Initialization, SLEEP);
    assert_eq!(to_sleep.due(QUIET), Some(Change::Acknowledge(Mode::Sleep)));
}

#[test]
fn sleeping_controller_enters_initialization_mode_while_sleep_is_set() {
    let mut control = requested(Mode::Sleep, INITIALIZATION | SLEEP);
    let acknowledge = Some(Change::Acknowledge(Mode::Initialization));
    assert_eq!(control.due(QUIET), acknowledge);
    control.enter(Mode::Initialization);
    assert_eq!(control.acknowledged(), 0b11);
    control.write(INITIALIZATION);
    assert_eq!(control.acknowledged(), 0b01);
    // From the bus, SLEEP has no effect beside INRQ.
    let mut awake = requested(Mode::Normal, INITIALIZATION | SLEEP);
    awake.enter(Mode::Initialization);
    assert_eq!(awake.acknowledged(), 0b01);
}

#[test]
fn reset_bit_acknowledges_no_mode_and_requests_sleep_mode() {
    for mode in [Mode::Sleep, Mode::Initialization, Mode::Normal] {
        let mut control = control(mode);
        control.reset();
        assert_eq!(control.acknowledged(), 0);
        assert!(!control.is_on() && !control.may_start());
        assert_eq!(control.value(), 0x0001_0002);
        assert_eq!(control.due(QUIET), Some(Change::Acknowledge(Mode::Sleep)));
    }
}

#[test]
fn controller_leaves_bus_when_idle() {
    for (bits, mode) in [(INITIALIZATION, Mode::Initialization), (SLEEP, Mode::Sleep)] {
        let control = requested(Mode::Normal, bits);
        assert!(!control.may_start());
        assert_eq!(control.due(BUSY), None);
        assert_eq!(control.acknowledged(), 0);
        assert_eq!(control.due(QUIET), Some(Change::Acknowledge(mode)));
    }
}

#[test]
fn controller_joins_after_eleven_recessive_bits() {
    for (mode, acknowledged) in [(Mode::Sleep, 0b10), (Mode::Initialization, 0b01)] {
        let mut control = requested(mode, 0);
        assert_eq!(control.due(QUIET), Some(Change::Join));
        control.joining();
        assert_eq!(control.due(QUIET), None);
        assert_eq!(control.acknowledged(), acknowledged);
        assert!(!control.may_start());
        assert!(!control.is_initializing());
        control.joined();
        assert_eq!(control.acknowledged(), 0);
        assert!(control.may_start());
    }
}

#[test]
fn joining_can_be_aborted_at_once() {
    let mut control = requested(Mode::Initialization, 0);
    control.joining();
    control.write(INITIALIZATION);
    assert_eq!(
        control.due(BUSY),
        Some(Change::Acknowledge(Mode::Initialization))
    );
}

#[test]
fn automatic_wakeup_clears_sleep_request() {
    let mut without = control(Mode::Sleep);
    without.wake_up();
    assert_eq!(without.due(QUIET), None);
    let mut with = requested(Mode::Sleep, SLEEP | AUTOMATIC_WAKE_UP);
    with.wake_up();
    assert_eq!(with.value(), AUTOMATIC_WAKE_UP);
    assert_eq!(with.due(QUIET), Some(Change::Join));
}

#[test]
fn option_bits_match_manual() {
    let nothing = requested(Mode::Normal, 0);
    assert!(!nothing.recovers() && nothing.retransmits() && !nothing.locks_fifo());
    assert_eq!(nothing.order(), Order::Identifier);
    assert!(requested(Mode::Normal, 0x40).recovers());
    assert!(!requested(Mode::Normal, 0x10).retransmits());
    assert!(requested(Mode::Normal, 0x08).locks_fifo());
    assert_eq!(requested(Mode::Normal, 0x04).order(), Order::Request);
}
