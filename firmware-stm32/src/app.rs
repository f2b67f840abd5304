//! The main loop: measures, passes events to the node, performs its actions, then lets the processor sleep. The CAN interrupts
//! answer frames ([`link`](crate::link)).
//!
//! Boot order: watchdog, clocks and pins, then the parameter memory, which is erased in advance because the node is not on the
//! bus yet, then the accelerometer, the node, and with its first action the bus.
//!
//! The loop sleeps until an interrupt has an event for it, or until the time of `App::wake`: the next sample, or the deadline of
//! the node if it is earlier. SysTick triggers the alarm, so the resolution of deadlines is one millisecond.

use crate::board::{self, Board, CanPeripheral, ImuWires, StatusLeds, Switches, Watchdog};
use crate::can::mailboxes::Mailboxes;
use crate::can::{self, Bus, BusEvents};
use crate::flash::ParameterFlash;
use crate::guard::Guard;
use crate::imu::Element;
use crate::link::Shared;
#[cfg(feature = "behind-bootloader")]
use crate::program;
use crate::{clock, kept, sleep};
use core::mem::MaybeUninit;
use cortex_m::peripheral::SCB;
use cortex_m::singleton;
use plumbline::application::Application;
use plumbline::calibration_line;
use plumbline::measure::{I32x3, ONE_G, Reading, SAMPLE_PERIOD};
use plumbline::node::driver::{Driver, Line, Output, Platform, TwoPriorities};
use plumbline::node::{Leds, ProductNode, Protocol, StoreOf};
use plumbline::store::{Owner, Store, StoreError, Usage};
use plumbline::time::{Instant, after, earlier};
#[cfg(feature = "behind-bootloader")]
use plumbline::update::Contact;

/// Runs a node without end. `store` and `element` are memory for the store and for the driver of the accelerometer. `link` is shared with the
/// CAN interrupts.
///
/// # Safety
/// Call it only once: it takes all peripherals. A check at run time would need 64 bytes of flash.
pub unsafe fn run<N: ProductNode, E: Element>(
    article: &N::Article,
    store: &'static mut MaybeUninit<ParameterStore<N>>,
    element: &'static mut MaybeUninit<E>,
    node: &'static mut N,
    link: &'static Shared<N>,
) -> ! {
    // SAFETY: the caller calls this function only once.
    let board = unsafe { Board::take() };
    if N::Application::MEASURES_SUPPLY {
        board::start_adc();
    }
    can::set_priorities();
    // Before the erase of the flash, which takes long. It also sets the vector table.
    board::restore();
    let Parts {
        mut watchdog,
        store,
        element,
        leds,
        switches,
        can,
    } = start::<N, E>(board, article, store, element);
    let now = clock::now();
    let mut boot = store.boot();
    if !boot.fit(E::PART) {
        warn!("the calibration is not used: it is that of another measuring element");
    }
    if N::Application::HAS_DIAGNOSIS {
        boot.causes = board::reset_causes();
    }
    if N::Application::HEATER.is_some() {
        boot.kept = kept::take();
    }
    #[cfg(feature = "behind-bootloader")]
    {
        boot.program = program::installed();
    }
    if boot.damaged {
        warn!("stored parameters are damaged");
    }
    node.start(article, now, &boot);
    let (communication, acquisition) = node.halves();
    let Some(line) = singleton!(: Line<Mailboxes> = Line::new(Mailboxes::EMPTY)) else {
        SCB::sys_reset()
    };
    // Not with J1939: measured, the slowest answer of the IMS360 would take longer than 22 us.
    let is_guarded = !<N::Protocol as Protocol<N::Application>>::CHANGES_FILTERS;
    let guard = is_guarded.then(|| Guard::new::<N>(communication, line, now));
    link.start(communication, line);
    // None only on a second call.
    let Some(bus) = Bus::new(can) else {
        SCB::sys_reset()
    };
    let Some(outputs) = singleton!(OUTPUTS: [Outputs; 2] = [Outputs::OFF; 2]) else {
        SCB::sys_reset()
    };
    let mut app = App {
        driver: Driver::new(TwoPriorities::new(acquisition, link, BusEvents::new(bus))),
        hardware: Hardware {
            element,
            store,
            leds,
            switches,
            outputs,
        },
        link,
        guard,
        sample_due: clock::next_tick(),
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

/// All parts except the node, ready to run. Large parts are in static memory, so that their size is part of the image and they
/// are not moved over the stack.
struct Parts<N: ProductNode, E: Element + 'static> {
    watchdog: Watchdog,
    store: &'static mut ParameterStore<N>,
    element: &'static mut E,
    leds: StatusLeds,
    switches: Switches,
    can: CanPeripheral,
}

/// The store of node `N` in the nonvolatile memory of this board.
pub type ParameterStore<N> = StoreOf<N, ParameterFlash<board::Flash>>;

/// Performs the boot up to the start of the node.
fn start<N: ProductNode, E: Element>(
    board: Board,
    article: &N::Article,
    store: &'static mut MaybeUninit<ParameterStore<N>>,
    element: &'static mut MaybeUninit<E>,
) -> Parts<N, E> {
    let mut watchdog = board.watchdog;
    clock::start(board.systick);

    // `plumbline calibrate` reads both.
    calibration_line!(element, info, E::PART.name());
    calibration_line!(serial, info, board.serial);
    let store = create_store::<N>(store, board.flash, N::owner(article, board.serial));
    store.scan();
    watchdog.feed();
    store.prepare();
    watchdog.feed();

    let element = create_element(element, board.imu);
    Parts {
        watchdog,
        store,
        element,
        leds: board.leds,
        switches: board.switches,
        can: board.can,
    }
}

/// Creates the store of the nonvolatile memory in place.
fn create_store<N: ProductNode>(
    place: &'static mut MaybeUninit<ParameterStore<N>>,
    flash: ParameterFlash<board::Flash>,
    owner: Owner,
) -> &'static mut ParameterStore<N> {
    place.write(Store::new(flash, owner))
}

/// Creates the driver of the accelerometer in place.
fn create_element<E: Element>(
    place: &'static mut MaybeUninit<E>,
    wires: ImuWires,
) -> &'static mut E {
    place.write(E::new(wires))
}

/// The hardware that the main loop uses.
struct Hardware<N: ProductNode, E: Element + 'static> {
    element: &'static mut E,
    store: &'static mut ParameterStore<N>,
    leds: StatusLeds,
    switches: Switches,
    /// The present outputs, twice: a disturbance of one is found.
    outputs: &'static mut [Outputs; 2],
}

/// The LEDs that are on, the terminating resistor, the power of the heater in permille.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Outputs {
    lit: Leds,
    terminated: bool,
    heating: u16,
}

impl Outputs {
    const OFF: Self = Self {
        lit: Leds {
            run: false,
            error: false,
            module_green: false,
            module_red: false,
        },
        terminated: false,
        heating: 0,
    };
}

impl<N: ProductNode, E: Element> Hardware<N, E> {
    /// Sets the outputs again: a disturbance can have changed them. Restarts if it has changed their values.
    fn refresh(&mut self) {
        let [outputs, copy] = *self.outputs;
        if outputs != copy {
            error!("restart: the outputs are disturbed");
            board::restart();
        }
        self.leds.show(outputs.lit);
        self.switches.terminate(outputs.terminated);
        self.switches.heat(outputs.heating);
    }

    /// Changes both copies of the outputs, then sets them.
    fn set(&mut self, change: impl Fn(&mut Outputs)) {
        self.outputs.iter_mut().for_each(change);
        self.refresh();
    }
}

impl<N: ProductNode, E: Element> Platform for Hardware<N, E> {
    const HAS_BOOTLOADER: bool = cfg!(feature = "behind-bootloader");

    fn perform(&mut self, output: Output) {
        match output {
            Output::Leds(leds) => self.set(|outputs| outputs.lit = leds),
            Output::Termination(on) => self.set(|outputs| outputs.terminated = on),
            Output::Heater(permille) => self.set(|outputs| outputs.heating = permille),
            Output::SelfTest => self.element.test(),
        }
    }

    fn save(&mut self, image: impl FnOnce(&mut [u8]) -> Option<usize>) {
        self.store.save(image);
    }

    fn stored(&mut self) -> Option<Result<(), StoreError>> {
        let result = self.store.step();
        if let Some(Err(_)) = result {
            error!("parameters could not be saved");
        }
        result
    }

    fn keep(&mut self, usage: &Usage, hour: u32) -> bool {
        self.store.keep(usage, hour)
    }

    #[cfg(feature = "behind-bootloader")]
    fn update(&mut self, contact: &Contact) {
        info!("update");
        program::ask_for_update(self.store.owner().image, contact);
    }

    fn restart(&mut self, kept: u32) {
        self.switches.heat(0);
        if N::Application::HEATER.is_some() {
            kept::put(kept);
        }
        info!("restart");
        SCB::sys_reset();
    }
}

/// The state of the main loop.
struct App<N: ProductNode, E: Element + 'static> {
    driver: Driver<TwoPriorities<'static, &'static Shared<N>, BusEvents<N>>>,
    hardware: Hardware<N, E>,
    link: &'static Shared<N>,
    guard: Option<Guard>,
    sample_due: Instant,
    /// A reading for the measuring half.
    reading: Option<Reading>,
}

impl<N: ProductNode, E: Element + 'static> App<N, E> {
    /// One iteration of the loop: a small step of each task. Returns true if there can be more to do at once.
    fn turn(&mut self) -> bool {
        // During the calculation, which takes long, the interrupts answer frames.
        if let Some(reading) = &self.reading {
            self.driver.sample(reading);
            self.reading = None;
        }
        self.driver.controller_mut().begin();
        let settling = self.driver.turn(&mut self.hardware);
        let reading = self.read();
        let saving = self.hardware.store.busy();
        settling || reading || saving || self.driver.controller().is_urgent()
    }

    /// The time of the next iteration if no interrupt comes before.
    fn wake(&self) -> Instant {
        if self.driver.controller().is_restless() {
            // At the next tick.
            return clock::now();
        }
        earlier(Some(self.sample_due), self.driver.deadline()).unwrap_or(self.sample_due)
    }

    /// Reads the accelerometer step by step when a sample is due. Returns true if there is more to do at once.
    fn read(&mut self) -> bool {
        let now = clock::now();
        let element = &mut *self.hardware.element;
        if let Some(working) = element.tested() {
            self.driver.tested(working);
            return true;
        }
        if element.busy() {
            self.reading = element.step(now);
            if let Some(reading) = &self.reading {
                if element.lost() {
                    self.driver.interrupt();
                }
                // The input for a calibration.
                let [x, y, z] = micro_g(reading);
                let [gx, gy, gz] = milli_rate(reading);
                let temperature = reading.temperature;
                calibration_line!(reading, debug, x, y, z, temperature, gx, gy, gz);
            }
            return true;
        }
        if !clock::is_due(now, self.sample_due, SAMPLE_PERIOD) {
            return false;
        }
        self.sample_due = after(self.sample_due, SAMPLE_PERIOD);
        if clock::is_due(now, self.sample_due, SAMPLE_PERIOD) {
            // The flash was busy. The FIFO of the accelerometer has the values.
            self.sample_due = after(clock::next_tick(), SAMPLE_PERIOD);
        }
        let bus = &mut *self.driver.controller_mut().bus;
        if bus.inspect(now)
            && let Some(guard) = &mut self.guard
        {
            guard.check(&self.link, bus, now);
        }
        self.hardware.refresh();
        self.hardware.element.start(now);
        self.measure_supply();
        true
    }

    /// Takes the result of a conversion and starts the next one.
    fn measure_supply(&mut self) {
        if N::Application::MEASURES_SUPPLY
            && let Some(millivolts) = board::supply()
        {
            self.driver.supply(millivolts);
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
