//! The main loop: measures, passes events to the node, performs its actions, then lets the processor sleep. The CAN interrupts
//! answer frames ([`link`](crate::link)).
//!
//! Boot order: watchdog, clocks and pins, then the parameter memory, which is erased in advance because the node is not on the
//! bus yet, then the accelerometer, the node, and with its first action the bus.
//!
//! The loop sleeps until an interrupt has an event for it, or until the time of `App::wake`: the next sample, or the deadline of
//! the node if it is earlier. SysTick triggers the alarm, so the resolution of deadlines is one millisecond.

use crate::board::{self, Board, CanPeripheral, ImuWires, StatusLeds, Switches, Watchdog};
use crate::can::{self, Bus, transmit};
use crate::flash::ParameterFlash;
use crate::imu::Imu;
use crate::link::{Frames, Link, Shared};
use crate::{clock, kept, sleep};
use core::mem::MaybeUninit;
use cortex_m::peripheral::SCB;
use cortex_m::singleton;
use plumbline::application::Application;
use plumbline::can::BitRate;
use plumbline::measure::{I32x3, ONE_G, Reading, SAMPLE_PERIOD};
use plumbline::node::{Acquisition, Action, Boot, BusEvent, BusMode, Divided, Indicator, Protocol};
use plumbline::store::{Owner, Store};
use plumbline::time::{Deadline, Duration, Instant, after, millis, reached};

/// The longest time that a restart waits for the last frames: four frames, one of them waiting for a mailbox, of 16 ms each at 10
/// kbit/s.
const RESTART_LIMIT: Duration = millis(100);

/// Runs a node without end. `owner` returns the owner of the stored records for a serial number. `store` and `imu` are memory for
/// the [`Store`], with a `BUFFER` of the [`STORE_BUFFER`](plumbline::node::CanNode::STORE_BUFFER) of the node, and for the driver of the
/// accelerometer. `link` is shared with the CAN interrupts. `start_node` starts the node. `TESTS` is 1 if the node requests
/// self-tests, otherwise 0. `GYROSCOPES` is 1 if it needs the angular rate, otherwise 0. `DETECTS` is true if it detects the bit rate.
///
/// # Safety
/// Call it only once: it takes all peripherals. A check at run time would need 64 bytes of flash.
pub unsafe fn run<
    N: Divided + 'static,
    const BUFFER: usize,
    const TESTS: usize,
    const GYROSCOPES: usize,
    const DETECTS: bool,
>(
    owner: fn(u32) -> Owner,
    store: &'static mut MaybeUninit<ParameterStore<BUFFER>>,
    imu: &'static mut MaybeUninit<Imu<TESTS, GYROSCOPES>>,
    node: &'static mut N,
    link: &'static Shared<N>,
    start_node: impl FnOnce(&mut N, Instant, &Boot),
) -> ! {
    // SAFETY: the caller calls this function only once.
    let board = unsafe { Board::take() };
    let Parts {
        mut watchdog,
        store,
        imu,
        leds,
        switches,
        can,
    } = start(board, owner, store, imu);
    if N::Application::MEASURES_SUPPLY {
        board::start_adc();
    }
    let now = clock::now();
    let mut boot = store.boot();
    if N::Application::HEATER.is_some() {
        boot.kept = kept::take();
    }
    if boot.damaged {
        warn!("stored parameters are damaged");
    }
    start_node(node, now, &boot);
    let (communication, acquisition) = node.halves();
    let Some(frames) = singleton!(: Frames = Frames::EMPTY) else {
        SCB::sys_reset()
    };
    link.start(communication, frames);
    // None only on a second call.
    let Some(bus) = Bus::new(can) else {
        SCB::sys_reset()
    };
    let mut app = App::<N, _, _, _, DETECTS> {
        acquisition,
        link,
        bus,
        imu,
        store,
        leds,
        indicator: Indicator::DARK,
        switches,
        sample_due: now,
        reading: None,
    };
    loop {
        clock::restore();
        watchdog.feed();
        if !app.turn() {
            sleep::sleep(app.wake());
        }
    }
}

/// The maximum number of rounds of actions in one iteration of the main loop. The limit ensures that the watchdog is fed even if each frame
/// causes an action.
const ROUNDS: u8 = 8;

/// All parts except the node, ready to run. Large parts are in static memory, so that their size is part of the image and they
/// are not moved over the stack.
struct Parts<const BUFFER: usize, const TESTS: usize, const GYROSCOPES: usize> {
    watchdog: Watchdog,
    store: &'static mut ParameterStore<BUFFER>,
    imu: &'static mut Imu<TESTS, GYROSCOPES>,
    leds: StatusLeds,
    switches: Switches,
    can: CanPeripheral,
}

/// The nonvolatile memory of this board.
pub type ParameterStore<const BUFFER: usize> = Store<ParameterFlash<board::Flash>, BUFFER>;

/// Performs the boot up to the start of the node.
fn start<const BUFFER: usize, const TESTS: usize, const GYROSCOPES: usize>(
    board: Board,
    owner: fn(u32) -> Owner,
    store: &'static mut MaybeUninit<ParameterStore<BUFFER>>,
    imu: &'static mut MaybeUninit<Imu<TESTS, GYROSCOPES>>,
) -> Parts<BUFFER, TESTS, GYROSCOPES> {
    let mut watchdog = board.watchdog;
    clock::start(board.systick);

    info!("serial number {=u32}", board.serial);
    let store = create_store(store, board.flash, owner(board.serial));
    store.scan();
    watchdog.feed();
    store.prepare();
    watchdog.feed();

    let imu = create_imu(imu, board.imu);
    Parts {
        watchdog,
        store,
        imu,
        leds: board.leds,
        switches: board.switches,
        can: board.can,
    }
}

/// Creates the store of the nonvolatile memory in place.
fn create_store<const BUFFER: usize>(
    place: &'static mut MaybeUninit<ParameterStore<BUFFER>>,
    flash: ParameterFlash<board::Flash>,
    owner: Owner,
) -> &'static mut ParameterStore<BUFFER> {
    place.write(Store::new(flash, owner))
}

/// Creates the driver of the accelerometer in place.
fn create_imu<const TESTS: usize, const GYROSCOPES: usize>(
    place: &'static mut MaybeUninit<Imu<TESTS, GYROSCOPES>>,
    wires: ImuWires,
) -> &'static mut Imu<TESTS, GYROSCOPES> {
    place.write(Imu::new(wires))
}

/// The state of the main loop.
struct App<
    N: Divided + 'static,
    const BUFFER: usize,
    const TESTS: usize,
    const GYROSCOPES: usize,
    const DETECTS: bool,
> {
    acquisition: &'static mut Acquisition<N::Application>,
    link: &'static Shared<N>,
    bus: &'static mut Bus,
    imu: &'static mut Imu<TESTS, GYROSCOPES>,
    store: &'static mut ParameterStore<BUFFER>,
    leds: StatusLeds,
    indicator: Indicator,
    switches: Switches,
    sample_due: Instant,
    /// A reading for the measuring half.
    reading: Option<Reading>,
}

impl<
    N: Divided + 'static,
    const BUFFER: usize,
    const TESTS: usize,
    const GYROSCOPES: usize,
    const DETECTS: bool,
> App<N, BUFFER, TESTS, GYROSCOPES, DETECTS>
{
    /// One iteration of the loop: a small step of each task. Returns true if there can be more to do at once.
    fn turn(&mut self) -> bool {
        self.measure();
        let link = self.link;
        // Reads the bit time before the step: if the controller can join the bus at the end of this frame, the step completes the join.
        let time = if DETECTS { self.bus.bit_time() } else { None };
        self.step();
        while let Some(event) = self.bus.event() {
            link.call(|node, now| node.bus(now, event));
        }
        if let Some(time) = time {
            if self.bus.misses_frame() {
                link.call(|node, now| node.bus(now, BusEvent::Error));
            }
            link.call(|node, now| node.bus(now, BusEvent::BitTime(time)));
        }
        let settling = self.settle();
        let reading = self.read();
        let saving = self.save();
        settling || reading || saving || DETECTS && self.bus.is_urgent()
    }

    /// Performs a step of a change of the bus mode.
    fn step(&mut self) {
        let link = self.link;
        let restless = self.bus.restless();
        self.bus
            .step(|accept| link.with(|link| link.node.filters(accept)));
        if restless && !self.bus.restless() {
            // Handles the frames that waited for the change.
            link.settle();
        }
    }

    /// The time of the next iteration if no interrupt comes before.
    fn wake(&self) -> Instant {
        if self.bus.restless() || DETECTS && self.bus.measures() {
            // At the next tick.
            return clock::now();
        }
        let mut earliest = Deadline::at(self.sample_due);
        earliest.consider(self.link.with(|link| link.node.deadline()));
        earliest.consider(self.acquisition.deadline());
        self.indicator.consider(&mut earliest);
        earliest.time().unwrap_or(self.sample_due)
    }

    /// Performs the tasks of the measuring half.
    fn obey(&mut self) {
        loop {
            let now = clock::now();
            let task = self.link.with(|link| link.node.task(now));
            // Passed by reference, so that the parameters are not copied again.
            let Some(task) = &task else {
                return;
            };
            let values = self.acquisition.perform(now, task);
            self.link.call(|node, now| node.finish(now, task, values));
        }
    }

    /// Processes a reading. During the calculation, which takes long, the interrupts answer frames.
    fn measure(&mut self) {
        if let Some(values) = self.acquisition.tick(clock::now()) {
            self.link.call(|node, now| node.publish(now, values));
        }
        if self.reading.is_some() {
            self.obey();
        }
        if let Some(reading) = &self.reading {
            let now = clock::now();
            let values = self.acquisition.sample(now, reading);
            self.link.with(|link| link.node.sampled(now, values));
            self.reading = None;
        }
    }

    /// Performs the actions of the node. The interrupts are masked only during each call of the node. Returns true if more actions can be
    /// pending.
    fn settle(&mut self) -> bool {
        let link = self.link;
        for _ in 0..ROUNDS {
            let now = clock::now();
            if let Some(leds) = self.indicator.poll(now) {
                self.leds.show(leds);
            }
            link.settle();
            if link.with(|link| link.node.is_idle(now)) {
                return false;
            }
            loop {
                self.obey();
                if !link.with(|link| link.node.tick(now)) {
                    break;
                }
            }
            if let Some(patterns) = link.with(|link| link.node.patterns()) {
                self.indicator.show(now, patterns);
            }
            let action = link.with(|link| {
                let action = link.node.action(now);
                if let Some(Action::Bus(mode, rate)) = action {
                    // In the same critical section, so that no frame is put into a mailbox that the change of the mode aborts.
                    if self.stays(mode, rate) {
                        can::hold();
                    } else {
                        can::stop();
                    }
                }
                action
            });
            if let Some(action) = action {
                self.perform(action);
            }
        }
        true
    }

    /// Reads the accelerometer step by step when a sample is due. Returns true if there is more to do at once.
    fn read(&mut self) -> bool {
        let now = clock::now();
        if let Some(working) = self.imu.tested() {
            if let Some(values) = self.acquisition.tested(working) {
                self.link.call(|node, now| node.publish(now, values));
            }
            return true;
        }
        if self.imu.busy() {
            self.reading = self.imu.step(now);
            if let Some(reading) = &self.reading {
                if self.imu.lost() {
                    self.acquisition.interrupt();
                }
                // The input for a calibration.
                let [x, y, z] = micro_g(reading);
                let [gx, gy, gz] = milli_rate(reading);
                let temperature = reading.temperature;
                debug!(
                    "acceleration {=i32} {=i32} {=i32} ug, {=i16} 0.01 degC, rate {=i32} {=i32} {=i32} mdps",
                    x, y, z, temperature, gx, gy, gz
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
        self.bus.inspect(now);
        self.imu.start(now);
        self.measure_supply();
        true
    }

    /// Takes the result of a conversion and starts the next one.
    fn measure_supply(&mut self) {
        if N::Application::MEASURES_SUPPLY
            && let Some(millivolts) = board::supply()
            && let Some(values) = self.acquisition.supply(millivolts)
        {
            self.link.call(|node, now| node.publish(now, values));
        }
    }

    /// Performs one step of a save. Returns true if there is more to do at once.
    fn save(&mut self) -> bool {
        let Some(result) = self.store.step() else {
            return self.store.busy();
        };
        if result.is_err() {
            error!("parameters could not be saved");
        }
        self.link.call(|node, now| node.stored(now, result));
        // The frames that waited for the end of the save.
        loop {
            self.obey();
            if !self.link.call(|node, now| node.resume(now)) {
                return true;
            }
        }
    }

    /// Whether this action only changes the filters.
    fn stays(&mut self, mode: BusMode, rate: BitRate) -> bool {
        N::Protocol::CHANGES_FILTERS && mode == BusMode::Normal && self.bus.is_at(mode, rate)
    }

    fn perform(&mut self, action: Action) {
        match action {
            Action::Bus(mode, rate) if self.stays(mode, rate) => {
                let link = self.link;
                self.bus
                    .refilter(|accept| link.with(|link| link.node.filters(accept)));
                link.settle();
            }
            Action::Bus(mode, rate) => {
                info!("{} at {}", mode, rate);
                if DETECTS {
                    self.bus.measure(mode);
                }
                self.bus.configure(mode, rate);
                self.link.with(Link::discard);
                // Immediately, so that the controller can join the bus at the end of the current frame.
                self.step();
            }
            Action::Recover => {
                info!("recover from bus-off");
                self.bus.recover();
            }
            // Not an action of the communicating half.
            Action::Leds(_) => {}
            Action::Save => {
                let image = self.link.with(|link| *link.node.image());
                self.store.save(|buffer| image.encode(buffer));
            }
            Action::Restart => self.restart(),
            Action::Termination(on) => self.switches.terminate(on),
            Action::Heater(permille) => self.switches.heat(permille),
            Action::SelfTest => self.imu.test(),
        }
    }

    /// Resets the board when all frames are sent, at the latest after [`RESTART_LIMIT`].
    fn restart(&mut self) -> ! {
        self.switches.heat(0);
        if N::Application::HEATER.is_some() {
            kept::put(self.acquisition.kept());
        }
        while self.store.busy() {
            self.store.step();
        }
        let limit = after(clock::now(), RESTART_LIMIT);
        loop {
            self.link.settle();
            // If all mailboxes are empty now, the node has no more frames.
            if transmit::is_idle() || reached(clock::now(), limit) {
                info!("restart");
                SCB::sys_reset();
            }
        }
    }
}

/// The angular rate of a reading in 0.001 deg/s.
fn milli_rate(reading: &Reading) -> [i32; 3] {
    let I32x3 { x, y, z } = reading.angular_rate;
    [x, y, z].map(|value| ((i64::from(value) * 1000) >> 16) as i32)
}

/// The acceleration of a reading in 10^-6 g.
fn micro_g(reading: &Reading) -> [i32; 3] {
    let I32x3 { x, y, z } = reading.acceleration;
    [x, y, z].map(|value| ((i64::from(value) * 1_000_000) >> ONE_G.ilog2()) as i32)
}
