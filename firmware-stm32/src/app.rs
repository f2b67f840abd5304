//! The main loop: passes inputs to the node, performs its actions, then lets the processor sleep.
//!
//! Boot order: watchdog, clocks and pins, then the parameter memory, which is erased in advance because the node is not on the
//! bus yet, then the accelerometer, the node, and with its first action the bus.
//!
//! The loop sleeps until an interrupt has an event for it, or until the time of `App::wake`: the next sample, or the deadline of
//! the node if it is earlier. SysTick triggers the alarm, so the resolution of deadlines is one millisecond.

use crate::board::{self, Board, ImuWires, StatusLeds, Switches, Watchdog};
use crate::can::Bus;
use crate::flash::ParameterFlash;
use crate::imu::Imu;
use crate::{clock, sleep};
use core::mem::MaybeUninit;
use cortex_m::peripheral::SCB;
use plumbline::measure::{I32x3, Reading, SAMPLE_PERIOD};
use plumbline::node::{Action, Boot, BusEvent, Node};
use plumbline::store::{Owner, Store};
use plumbline::time::{Duration, Instant, after, earlier, millis, reached};

/// The longest time that a restart waits for the last frames: four frames, one of them waiting for a mailbox, of 16 ms each at 10
/// kbit/s.
const RESTART_LIMIT: Duration = millis(100);

/// The longest time that the boot waits for the accelerometer, which turns on in 20 ms and needs 24 ms for a reading.
const FIRST_READING_LIMIT: Duration = millis(200);

/// Runs a node without end. `owner` returns the owner of the stored records for a serial number. `store` and `imu` are memory for
/// the [`Store`], with a `BUFFER` of the [`STORE_BUFFER`](plumbline::node::CanNode::STORE_BUFFER) of the node, and for the driver
/// of the accelerometer. `start_node` starts the node. `TESTS` is 1 if the node requests self-tests, otherwise 0. `DETECTS` is true
/// if it detects the bit rate.
///
/// # Safety
/// Call it only once: it takes all peripherals. A check at run time would need 64 bytes of flash.
pub unsafe fn run<
    N: Node + 'static,
    const BUFFER: usize,
    const TESTS: usize,
    const DETECTS: bool,
>(
    owner: fn(u32) -> Owner,
    store: &'static mut MaybeUninit<ParameterStore<BUFFER>>,
    imu: &'static mut MaybeUninit<Imu<TESTS>>,
    node: &'static mut N,
    start_node: impl FnOnce(&mut N, Instant, &Boot),
) -> ! {
    // SAFETY: the caller calls this function only once.
    let board = unsafe { Board::take() };
    let Parts {
        mut watchdog,
        store,
        imu,
        first,
        bus,
        leds,
        switches,
    } = start(board, owner, store, imu);
    let now = clock::now();
    let boot = store.boot();
    if boot.damaged {
        warn!("stored parameters are damaged");
    }
    start_node(node, now, &boot);
    let mut app = App::<_, _, _, DETECTS> {
        node,
        bus,
        imu,
        store,
        leds,
        switches,
        sample_due: after(now, SAMPLE_PERIOD),
        reading: first,
    };
    loop {
        watchdog.feed();
        if !app.turn() {
            sleep::sleep(app.wake());
        }
    }
}

/// All parts except the node, ready to run. Large parts are in static memory, so that their size is part of the image and they
/// are not moved over the stack.
struct Parts<const BUFFER: usize, const TESTS: usize> {
    watchdog: Watchdog,
    store: &'static mut ParameterStore<BUFFER>,
    imu: &'static mut Imu<TESTS>,
    first: Option<Reading>,
    bus: &'static mut Bus,
    leds: StatusLeds,
    switches: Switches,
}

/// The nonvolatile memory of this board.
pub type ParameterStore<const BUFFER: usize> = Store<ParameterFlash<board::Flash>, BUFFER>;

/// Performs the boot up to the start of the node.
#[inline(never)] // the stack of the boot is free again when the main loop begins
fn start<const BUFFER: usize, const TESTS: usize>(
    board: Board,
    owner: fn(u32) -> Owner,
    store: &'static mut MaybeUninit<ParameterStore<BUFFER>>,
    imu: &'static mut MaybeUninit<Imu<TESTS>>,
) -> Parts<BUFFER, TESTS> {
    let mut watchdog = board.watchdog;
    clock::start(board.systick);

    info!("serial number {=u32}", board.serial);
    let store = create_store(store, board.flash, owner(board.serial));
    store.scan();
    watchdog.feed();
    store.prepare();
    watchdog.feed();

    let imu = create_imu(imu, board.imu);
    let first = first_reading(imu);
    // None only on a second call.
    let Some(bus) = Bus::new(board.can) else {
        SCB::sys_reset()
    };
    Parts {
        watchdog,
        store,
        imu,
        first,
        bus,
        leds: board.leds,
        switches: board.switches,
    }
}

/// Creates the store of the nonvolatile memory in place.
#[inline(never)] // same reason as `start`
fn create_store<const BUFFER: usize>(
    place: &'static mut MaybeUninit<ParameterStore<BUFFER>>,
    flash: ParameterFlash<board::Flash>,
    owner: Owner,
) -> &'static mut ParameterStore<BUFFER> {
    place.write(Store::new(flash, owner))
}

/// Creates the driver of the accelerometer in place.
#[inline(never)] // same reason as `start`
fn create_imu<const TESTS: usize>(
    place: &'static mut MaybeUninit<Imu<TESTS>>,
    wires: ImuWires,
) -> &'static mut Imu<TESTS> {
    place.write(Imu::new(wires))
}

/// Waits until the accelerometer has settled, so that the first frame contains valid values. None if it does not start.
fn first_reading<const TESTS: usize>(imu: &mut Imu<TESTS>) -> Option<Reading> {
    let mut due = clock::now();
    let limit = after(due, FIRST_READING_LIMIT);
    loop {
        let now = clock::now();
        if reached(now, due) {
            due = after(due, SAMPLE_PERIOD);
            imu.start(now);
        }
        let reading = imu.step(now);
        if reading.is_some() || reached(now, limit) {
            return reading;
        }
    }
}

/// The state of the main loop.
struct App<N: 'static, const BUFFER: usize, const TESTS: usize, const DETECTS: bool> {
    node: &'static mut N,
    bus: &'static mut Bus,
    imu: &'static mut Imu<TESTS>,
    store: &'static mut ParameterStore<BUFFER>,
    leds: StatusLeds,
    switches: Switches,
    sample_due: Instant,
    /// A reading for the next call of `Node::sample`.
    reading: Option<Reading>,
}

impl<N: Node + 'static, const BUFFER: usize, const TESTS: usize, const DETECTS: bool>
    App<N, BUFFER, TESTS, DETECTS>
{
    /// One iteration of the loop: handles the received frames, then a small step of each other task. Returns true if there can be
    /// more to do at once.
    fn turn(&mut self) -> bool {
        self.answer();
        if let Some(reading) = self.reading.take() {
            // The longest step that cannot be divided. Frames are checked immediately before and after it.
            self.node.sample(clock::now(), &reading);
            return true;
        }
        self.bus.step(self.node);
        while let Some(event) = self.bus.event() {
            self.node.bus(clock::now(), event);
        }
        if DETECTS && let Some(time) = self.bus.bit_time() {
            let now = clock::now();
            if self.bus.restless() {
                // At this bit rate, the end of a frame was too short for the controller to join the bus.
                self.node.bus(now, BusEvent::Error);
            }
            self.node.bus(now, BusEvent::BitTime(time));
        }
        self.settle();
        let reading = self.read();
        let saving = self.save();
        reading || saving || DETECTS && self.bus.is_urgent()
    }

    /// The time of the next iteration if no interrupt comes before.
    fn wake(&self) -> Instant {
        if self.bus.restless() || DETECTS && self.bus.measures() {
            // At the next tick.
            return clock::now();
        }
        earlier(Some(self.sample_due), self.node.deadline()).unwrap_or(self.sample_due)
    }

    /// Passes the received frames to the node.
    fn answer(&mut self) {
        while self.node.ready() {
            let Some(frame) = self.bus.receive() else {
                break;
            };
            let now = clock::now();
            self.node.receive(now, &frame);
            // The reply has the highest priority.
            self.transmit(now);
            self.settle();
        }
    }

    /// Reads the accelerometer step by step when a sample is due. Returns true if there is more to do at once.
    fn read(&mut self) -> bool {
        let now = clock::now();
        if let Some(working) = self.imu.tested() {
            self.node.tested(now, working);
            return true;
        }
        if self.imu.busy() {
            self.reading = self.imu.step(now);
            if let Some(reading) = &self.reading {
                // The input for a calibration.
                let [x, y, z] = micro_g(reading);
                let temperature = reading.temperature;
                debug!(
                    "acceleration {=i32} {=i32} {=i32} ug, {=i16} 0.01 degC",
                    x, y, z, temperature
                );
            }
            return true;
        }
        if !reached(now, self.sample_due) {
            return false;
        }
        self.sample_due = after(self.sample_due, SAMPLE_PERIOD);
        if reached(now, self.sample_due) {
            // The flash was busy. The FIFO of the accelerometer has the values.
            self.sample_due = after(now, SAMPLE_PERIOD);
        }
        self.imu.start(now);
        true
    }

    /// Performs one step of a save. Returns true if there is more to do at once.
    fn save(&mut self) -> bool {
        let Some(result) = self.store.step() else {
            return self.store.busy();
        };
        if result.is_err() {
            error!("parameters could not be saved");
        }
        self.node.stored(clock::now(), result);
        // The save has ended: there is a reply, and possibly a deferred frame.
        true
    }

    /// Performs the actions of the node, then sends its frames.
    fn settle(&mut self) {
        while let Some(action) = self.node.poll(clock::now()) {
            self.perform(action);
        }
        self.transmit(clock::now());
    }

    #[inline(never)] // rarely called
    fn perform(&mut self, action: Action) {
        match action {
            Action::Bus(mode, rate) => {
                info!("{} at {}", mode, rate);
                if DETECTS {
                    self.bus.measure(mode);
                }
                self.bus.configure(mode, rate);
            }
            Action::Recover => {
                info!("recover from bus-off");
                self.bus.recover();
            }
            Action::Leds(leds) => self.leds.show(leds),
            Action::Save => self.store.save(|buffer| self.node.image(buffer)),
            Action::Restart => self.restart(),
            Action::Termination(on) => self.switches.terminate(on),
            Action::Heater(permille) => self.switches.heat(permille),
            Action::SelfTest => self.imu.test(),
        }
    }

    fn transmit(&mut self, now: Instant) {
        while self.bus.can_send() {
            let Some(frame) = self.node.transmit(now) else {
                break;
            };
            self.bus.send(&frame);
        }
    }

    /// Resets the board when all frames are sent, at the latest after [`RESTART_LIMIT`].
    fn restart(&mut self) -> ! {
        self.switches.heat(0);
        while self.store.busy() {
            self.store.step();
        }
        let limit = after(clock::now(), RESTART_LIMIT);
        loop {
            self.transmit(clock::now());
            // If all mailboxes are empty now, the node has no more frames.
            if self.bus.sent() || reached(clock::now(), limit) {
                info!("restart");
                SCB::sys_reset();
            }
        }
    }
}

/// The acceleration of a reading in 10^-6 g.
fn micro_g(reading: &Reading) -> [i32; 3] {
    let I32x3 { x, y, z } = reading.acceleration;
    [x, y, z].map(|value| ((i64::from(value) * 1_000_000) >> 28) as i32)
}
