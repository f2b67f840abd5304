//! The main loop: what comes in goes to the node, what the node wants is done, then the processor sleeps.
//!
//! Boot order: watchdog, clocks and pins, then the parameters, whose memory is erased ahead while that disturbs nobody, then the
//! accelerometer, the node, and with its first action the bus.
//!
//! SysTick wakes the loop every millisecond, which is how precisely it keeps the node's deadlines; it does not ask for them.

use crate::board::{self, Board, ImuWires, StatusLeds};
use crate::can::Bus;
use crate::flash::ParameterFlash;
use crate::imu::Imu;
use crate::{clock, sleep};
use cortex_m::peripheral::SCB;
use plumbline::measure::{I32x3, Reading, SAMPLE_PERIOD};
use plumbline::node::{Action, Boot, Node};
use plumbline::store::{ImageId, Store};
use plumbline::time::{Duration, Instant, after, millis, reached};

/// How long a restart waits for the last frames: four, one of them waiting for a mailbox, of 16 ms each at 10 kbit/s.
const RESTART_LIMIT: Duration = millis(100);

/// How long the boot waits for the accelerometer: it settles in 100 ms.
const FIRST_READING_LIMIT: Duration = millis(200);

/// Runs a node for ever. `image` and `payload` say how it is stored, and `node` starts it.
pub fn run<N: Node>(image: ImageId, payload: usize, node: impl FnOnce(Instant, Boot) -> N) -> ! {
    let Some(board) = Board::take() else {
        // Only a second call gets here.
        SCB::sys_reset()
    };
    let mut watchdog = board.watchdog;
    clock::start(board.systick);

    let (mut store, loaded) = Store::open(board.flash, image, payload);
    if loaded.damaged {
        warn!("stored parameters are damaged");
    }
    watchdog.feed();
    store.prepare();
    watchdog.feed();

    let mut imu = Imu::new(board.imu);
    let first = first_reading(&mut imu);

    let Some(bus) = Bus::new(board.can) else {
        SCB::sys_reset()
    };
    info!("serial number {=u32}", board.serial);
    let boot = Boot {
        loaded,
        serial: board.serial,
    };
    let now = clock::now();
    let mut app = App {
        node: node(now, boot),
        bus,
        imu,
        store,
        leds: board.leds,
        sample_due: after(now, SAMPLE_PERIOD),
    };
    if let Some(reading) = first {
        app.node.sample(now, &reading);
    }
    app.settle();
    loop {
        watchdog.feed();
        if !app.turn() {
            sleep::sleep();
        }
    }
}

/// Waits for the accelerometer to settle, so that the first frame tells the truth; None when it does not come up.
fn first_reading(imu: &mut Imu<ImuWires>) -> Option<Reading> {
    let mut due = clock::now();
    let limit = after(due, FIRST_READING_LIMIT);
    while !reached(clock::now(), limit) {
        if reached(clock::now(), due) {
            due = after(due, SAMPLE_PERIOD);
            if let Some(reading) = imu.read(clock::now()) {
                return Some(reading);
            }
        }
    }
    None
}

/// Everything that the main loop turns.
struct App<N> {
    node: N,
    bus: Bus,
    imu: Imu<ImuWires>,
    store: Store<ParameterFlash<board::Flash>>,
    leds: StatusLeds,
    sample_due: Instant,
}

impl<N: Node> App<N> {
    /// One turn of the loop; true when there may be more to do at once.
    fn turn(&mut self) -> bool {
        self.bus.step();
        while let Some(event) = self.bus.event() {
            self.node.bus(clock::now(), event);
            self.settle();
        }
        while self.node.ready() {
            let Some(frame) = self.bus.receive() else {
                break;
            };
            self.node.receive(clock::now(), &frame);
            self.settle();
        }
        self.sample();
        let saved = self.store.step();
        if let Some(result) = saved {
            if result.is_err() {
                error!("parameters could not be saved");
            }
            self.node.stored(clock::now(), result);
        }
        self.settle();
        // A save that has ended may have made the node ready for a frame that is already here.
        self.store.busy() || saved.is_some()
    }

    /// Hands a sample in when one is due.
    fn sample(&mut self) {
        let now = clock::now();
        if !reached(now, self.sample_due) {
            return;
        }
        self.sample_due = after(self.sample_due, SAMPLE_PERIOD);
        if reached(now, self.sample_due) {
            // Samples were missed while the flash was busy; do not make up for them.
            self.sample_due = after(now, SAMPLE_PERIOD);
        }
        if let Some(reading) = self.imu.read(now) {
            // What a calibration starts from.
            let [x, y, z] = micro_g(&reading);
            let temperature = reading.temperature;
            debug!(
                "acceleration {=i32} {=i32} {=i32} ug, {=i16} 0.01 degC",
                x, y, z, temperature
            );
            self.node.sample(now, &reading);
            self.settle();
        }
    }

    /// Does what the node wants done, then sends what it has to send.
    fn settle(&mut self) {
        while let Some(action) = self.node.poll(clock::now()) {
            self.perform(action);
        }
        self.transmit();
    }

    fn perform(&mut self, action: Action) {
        match action {
            Action::Bus(mode, rate) => {
                info!("{} at {}", mode, rate);
                self.bus.configure(mode, rate, self.node.filters());
            }
            Action::Recover => {
                info!("recover from bus-off");
                self.bus.recover();
            }
            Action::Leds(leds) => self.leds.show(leds),
            Action::Save => self.store.save(&self.node.image()),
            Action::Restart => self.restart(),
            // No model of these boards asks for them.
            Action::Termination(_) | Action::Heater(_) | Action::SelfTest => {}
        }
    }

    fn transmit(&mut self) {
        while self.bus.can_send() {
            let Some(frame) = self.node.transmit(clock::now()) else {
                break;
            };
            self.bus.send(&frame);
        }
    }

    /// Resets the board once everything is sent.
    fn restart(&mut self) -> ! {
        while self.store.busy() {
            self.store.step();
        }
        let limit = after(clock::now(), RESTART_LIMIT);
        loop {
            self.transmit();
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
