//! The main loop: what comes in goes to the node, what the node wants is done, then the processor sleeps.
//!
//! Boot order: watchdog, clocks and pins, then the parameters, whose memory is erased ahead while that disturbs nobody, then the
//! accelerometer, the node, and with its first action the bus.
//!
//! The loop sleeps until an interrupt brings it something or the time that `App::wake` names has come: the next sample, or the
//! node's deadline if that is sooner. The alarm goes off with a tick of SysTick, so deadlines are kept to a millisecond.

use crate::board::{self, Board, StatusLeds, Switches, Watchdog};
use crate::can::Bus;
use crate::flash::ParameterFlash;
use crate::imu::Imu;
use crate::{clock, sleep};
use core::mem::MaybeUninit;
use cortex_m::peripheral::SCB;
use cortex_m::singleton;
use plumbline::measure::{I32x3, Reading, SAMPLE_PERIOD};
use plumbline::node::{Action, Boot, Node};
use plumbline::store::{Owner, Store};
use plumbline::time::{Duration, Instant, after, earlier, millis, reached};

/// How long a restart waits for the last frames: four, one of them waiting for a mailbox, of 16 ms each at 10 kbit/s.
const RESTART_LIMIT: Duration = millis(100);

/// How long the boot waits for the accelerometer: it settles in 100 ms.
const FIRST_READING_LIMIT: Duration = millis(200);

/// Runs a node for ever. `owner` says whose records its memory holds, by the serial number; `store` is where the [`Store`] goes,
/// with a `BUFFER` of the node's [`STORE_BUFFER`](plumbline::node::CanNode::STORE_BUFFER); and `start_node` starts the node.
pub fn run<N: Node + 'static, const BUFFER: usize>(
    owner: fn(u32) -> Owner,
    store: &'static mut MaybeUninit<ParameterStore<BUFFER>>,
    node: &'static mut N,
    start_node: impl FnOnce(&mut N, Instant, &Boot),
) -> ! {
    let Some(parts) = start(owner, store) else {
        // Only a second call gets here.
        SCB::sys_reset()
    };
    let Parts {
        mut watchdog,
        store,
        imu,
        first,
        bus,
        leds,
        switches,
    } = parts;
    let now = clock::now();
    let boot = store.boot();
    if boot.damaged {
        warn!("stored parameters are damaged");
    }
    start_node(node, now, &boot);
    let mut app = App {
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

/// Everything but the node, ready to run. What is large lies in static memory: so its size shows in the image, and it is never on
/// the stack on its way from one function to the next.
struct Parts<const BUFFER: usize> {
    watchdog: Watchdog,
    store: &'static mut ParameterStore<BUFFER>,
    imu: &'static mut Imu,
    first: Option<Reading>,
    bus: &'static mut Bus,
    leds: StatusLeds,
    switches: Switches,
}

/// The nonvolatile memory on this board.
pub type ParameterStore<const BUFFER: usize> = Store<ParameterFlash<board::Flash>, BUFFER>;

/// Boots up to the node; None when called a second time.
#[inline(never)] // what booting puts on the stack is gone when the main loop begins
fn start<const BUFFER: usize>(
    owner: fn(u32) -> Owner,
    store: &'static mut MaybeUninit<ParameterStore<BUFFER>>,
) -> Option<Parts<BUFFER>> {
    let board = Board::take()?;
    let mut watchdog = board.watchdog;
    clock::start(board.systick);

    info!("serial number {=u32}", board.serial);
    let store = open_store(store, board.flash, owner(board.serial));
    watchdog.feed();
    store.prepare();
    watchdog.feed();

    let imu = singleton!(: Imu = Imu::new(board.imu))?;
    let first = first_reading(imu);
    Some(Parts {
        watchdog,
        store,
        imu,
        first,
        bus: Bus::new(board.can)?,
        leds: board.leds,
        switches: board.switches,
    })
}

/// Opens the nonvolatile memory.
#[inline(never)] // as `start`
fn open_store<const BUFFER: usize>(
    place: &'static mut MaybeUninit<ParameterStore<BUFFER>>,
    flash: ParameterFlash<board::Flash>,
    owner: Owner,
) -> &'static mut ParameterStore<BUFFER> {
    place.write(Store::open(flash, owner))
}

/// Waits for the accelerometer to settle, so that the first frame tells the truth; None when it does not come up.
fn first_reading(imu: &mut Imu) -> Option<Reading> {
    let mut due = clock::now();
    let limit = after(due, FIRST_READING_LIMIT);
    while !reached(clock::now(), limit) {
        if reached(clock::now(), due) {
            due = after(due, SAMPLE_PERIOD);
            imu.start(clock::now());
        }
        let reading = imu.step(clock::now());
        if reading.is_some() {
            return reading;
        }
    }
    None
}

/// Everything that the main loop turns.
struct App<N: 'static, const BUFFER: usize> {
    node: &'static mut N,
    bus: &'static mut Bus,
    imu: &'static mut Imu,
    store: &'static mut ParameterStore<BUFFER>,
    leds: StatusLeds,
    switches: Switches,
    sample_due: Instant,
    /// A reading that waits to be handed in.
    reading: Option<Reading>,
}

impl<N: Node + 'static, const BUFFER: usize> App<N, BUFFER> {
    /// One turn of the loop: the frames that have come, then a small piece of everything else. True when there may be more to do at
    /// once.
    fn turn(&mut self) -> bool {
        self.answer();
        if let Some(reading) = self.reading.take() {
            // The largest piece that cannot be cut: nothing comes between the looks for frames before and after it.
            self.node.sample(clock::now(), &reading);
            return true;
        }
        self.bus.step(self.node);
        while let Some(event) = self.bus.event() {
            self.node.bus(clock::now(), event);
        }
        self.settle();
        let reading = self.read();
        let saving = self.save();
        reading || saving
    }

    /// When the loop must turn again though nothing but time has come.
    fn wake(&self) -> Instant {
        if self.bus.restless() {
            // With the next tick.
            return clock::now();
        }
        earlier(Some(self.sample_due), self.node.deadline()).unwrap_or(self.sample_due)
    }

    /// Hands the received frames in.
    fn answer(&mut self) {
        while self.node.ready() {
            let Some(frame) = self.bus.receive() else {
                break;
            };
            let now = clock::now();
            self.node.receive(now, &frame);
            // The reply before anything else.
            self.transmit(now);
            self.settle();
        }
    }

    /// Reads the accelerometer when it is due, step by step; true when there is more to do at once.
    fn read(&mut self) -> bool {
        let now = clock::now();
        if let Some(working) = self.imu.tested() {
            self.node.tested(now, working);
            return true;
        }
        if self.imu.busy() {
            self.reading = self.imu.step(now);
            if let Some(reading) = &self.reading {
                // What a calibration starts from.
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
            // Samples were missed while the flash was busy; do not make up for them.
            self.sample_due = after(now, SAMPLE_PERIOD);
        }
        self.imu.start(now);
        true
    }

    /// Carries a save on; true when there is more to do at once.
    fn save(&mut self) -> bool {
        let Some(result) = self.store.step() else {
            return self.store.busy();
        };
        if result.is_err() {
            error!("parameters could not be saved");
        }
        self.node.stored(clock::now(), result);
        // The save has ended: there is a reply, and perhaps a frame that had to wait.
        true
    }

    /// Does what the node wants done, then sends what it has to send.
    fn settle(&mut self) {
        while let Some(action) = self.node.poll(clock::now()) {
            self.perform(action);
        }
        self.transmit(clock::now());
    }

    #[inline(never)] // seldom
    fn perform(&mut self, action: Action) {
        match action {
            Action::Bus(mode, rate) => {
                info!("{} at {}", mode, rate);
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

    /// Resets the board once everything is sent.
    fn restart(&mut self) -> ! {
        self.switches.heat(0);
        while self.store.busy() {
            self.store.step();
        }
        let limit = after(clock::now(), RESTART_LIMIT);
        loop {
            self.transmit(clock::now());
            // With a mailbox free and nothing sent into it the node has no more.
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
