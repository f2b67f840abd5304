//! A simulated microcontroller with an image on a bus with a tester.
//!
//! At the end of a test, the rig checks that there was no violation of the reference manual, that the stack has not reached its
//! limit, and that there was no reset that the test did not expect.

mod board;
pub mod ims360;
mod parameters;

pub use board::{
    board, chip, elf, images, on_genuine_silicon, on_the_genuine_nucleo_f103, on_the_nucleo,
    on_the_nucleo_f103, silicon,
};
pub use parameters::*;

use bench::motion::Motion;
use bench::scene::{Axes, Scene};
use bench::{AdapterId, Bus, BusRate, DeviceId, Flash, Logged, NodeType, Sensor, Source};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::time::{Duration, after};
use std::rc::Rc;
use stm32_sim::Microcontroller;
use stm32_sim::elf::Image;
use stm32_sim::flash::Times;
use stm32_sim::peripherals::Peripherals;
use stm32_sim::rcc::ResetCause;

/// The serial number of every sensor here.
pub const SERIAL: u32 = 1;

/// The image of a product for the board.
pub fn image(model: &str) -> Rc<Image> {
    Rc::new(Image::parse(elf(model)).expect("an ELF file"))
}

/// The node type of a product.
pub fn node_type(name: &str) -> NodeType {
    NodeType::find(name).expect("a product of this name")
}

/// A scene at rest with these angles in degrees.
pub fn tilt(name: &str, x: f64, y: f64) -> Box<dyn Motion> {
    Box::new(Scene::tilt(x, y, Axes::of(&node_type(name))).expect("valid angles"))
}

/// A microcontroller with the image of a product, tilted by 10 and 5 degrees. Its accelerometer has no noise, so each angle is exact.
pub fn microcontroller(name: &str, flash: Flash) -> Microcontroller {
    part(node_type(name).name, SERIAL, flash, tilt(name, 10.0, 5.0))
}

/// A microcontroller with the image of a product, this serial number and this motion. Its accelerometer has no noise.
pub fn part(
    name: &'static str,
    serial: u32,
    flash: Flash,
    motion: Box<dyn Motion>,
) -> Microcontroller {
    let part = Microcontroller::new(name, image(name), serial, flash, motion);
    part.with_silicon(&silicon()).quiet()
}

/// Free flash after the program, for code of a test.
fn code_address() -> u32 {
    // The last part of the program, before the parameters or at the end of the flash.
    let last = board().facts().program.last().expect("a flash");
    last.end - 0x800
}

/// A data frame with an 11-bit identifier.
pub fn data(id: u16, bytes: &[u8]) -> Frame {
    Frame::data(standard(id), bytes).expect("at most eight bytes")
}

pub const fn ms(ms: u64) -> Duration {
    Duration::from_ticks(ms * 1000)
}

/// Maximum time of a reply in ms: a save can erase a page first.
fn patience() -> u64 {
    Times::longest(chip()).erase[2] / 1_000_000_000 + 160
}

/// A microcontroller with an image and a tester on a bus.
pub struct Rig {
    pub bus: Bus,
    pub sensor: DeviceId,
    pub tester: AdapterId,
    /// All frames on the bus so far.
    pub log: Vec<Logged>,
    /// The number of frames in the log that the test has read.
    seen: usize,
    /// The expected resets, including the first power-up.
    expected: Vec<ResetCause>,
    /// The test lets the stack overflow.
    overflows: bool,
}

impl Rig {
    /// A sensor with a blank memory on a bus at this rate, after power-up. The tester acknowledges.
    pub fn new(name: &str, rate: BitRate) -> Self {
        Self::with(name, BusRate::Fixed(rate), blank())
    }

    /// A sensor with this memory, after power-up.
    pub fn with(name: &str, rate: BusRate, flash: Flash) -> Self {
        Self::attached(Bus::new(rate), microcontroller(name, flash))
    }

    /// This sensor on a bus at this rate, after power-up. The tester acknowledges.
    pub fn of(sensor: Microcontroller, rate: BitRate) -> Self {
        Self::attached(Bus::new(BusRate::Fixed(rate)), sensor)
    }

    fn attached(mut bus: Bus, sensor: Microcontroller) -> Self {
        let sensor = bus.attach(sensor);
        let tester = bus.adapter();
        bus.open(tester, None, false);
        Self {
            bus,
            sensor,
            tester,
            log: Vec::new(),
            seen: 0,
            expected: vec![ResetCause::PowerOn],
            overflows: false,
        }
    }

    /// A sensor with this fixed bit rate that has sent its boot-up messages.
    pub fn booted(name: &str, rate: BitRate) -> Self {
        Self::booted_with(name, rate, &[])
    }

    /// A sensor with this fixed bit rate and these parameters that has sent its boot-up messages and measures.
    pub fn booted_with(name: &str, rate: BitRate, parameters: &[&[u8]]) -> Self {
        let rate_parameter = [fsc::WRITE_BAUD_RATE, baud_rate_code(rate)];
        let all: Vec<&[u8]> = parameters
            .iter()
            .copied()
            .chain([&rate_parameter[..]])
            .collect();
        let mut rig = Self::with(name, BusRate::Fixed(rate), saved(name, &all));
        rig.boot_up();
        rig
    }

    /// Waits for the two boot-up messages.
    pub fn boot_up(&mut self) {
        self.boot_up_within(1000);
    }

    /// Waits for the two boot-up messages, each up to `limit` milliseconds.
    pub fn boot_up_within(&mut self, limit: u64) {
        for _ in 0..2 {
            let frame = self.expect(REPLY, limit);
            assert_eq!(frame.bytes()[0], fsc::ALIVE, "{frame:?}");
        }
    }

    pub fn device(&self) -> &dyn Sensor {
        self.bus.device(self.sensor)
    }

    pub fn microcontroller(&self) -> &Microcontroller {
        Microcontroller::of(self.device()).expect("a simulated microcontroller")
    }

    /// The microcontroller, to change its state.
    pub fn microcontroller_mut(&mut self) -> &mut Microcontroller {
        let device = self.bus.device_mut(self.sensor);
        Microcontroller::of_mut(device).expect("a simulated microcontroller")
    }

    /// The peripherals, to set faults, and the time in picoseconds.
    pub fn io(&mut self) -> (&mut Peripherals, u64) {
        let now = self.bus.now().ticks() * 1_000_000;
        (self.microcontroller_mut().io_mut(), now)
    }

    pub fn flash(&mut self) -> &mut Flash {
        self.bus.device_mut(self.sensor).flash()
    }

    /// Runs the bus for this many microseconds.
    pub fn run_us(&mut self, us: u64) {
        let end = after(self.bus.now(), Duration::from_ticks(us));
        self.bus.run_until(end);
        let new = self.bus.take_log();
        self.log.extend(new);
    }

    /// Runs the bus for this many milliseconds.
    pub fn run(&mut self, ms: u64) {
        self.run_us(ms * 1000);
    }

    /// Waits until `condition` holds and checks it every `step` microseconds. Panics if it does not hold within `limit`
    /// milliseconds.
    #[track_caller]
    pub fn wait_until(&mut self, step: u64, limit: u64, condition: impl Fn(&Self) -> bool) {
        let end = after(self.bus.now(), ms(limit));
        while !condition(self) {
            assert!(
                self.bus.now() < end,
                "the condition does not hold within the limit"
            );
            self.run_us(step);
        }
    }

    /// Sends a frame with this data on the Set-Parameter-ID.
    pub fn send(&mut self, bytes: &[u8]) {
        self.bus.send(self.tester, data(SET, bytes));
    }

    /// The frames of the sensor since the last call.
    pub fn sent(&mut self) -> Vec<Logged> {
        let new = self.log[self.seen..].iter();
        let own = Source::Device(self.sensor);
        let sent = new.filter(|logged| logged.source == own).copied().collect();
        self.seen = self.log.len();
        sent
    }

    /// As [`sent`](Self::sent), without times.
    pub fn frames(&mut self) -> Vec<Frame> {
        self.sent().into_iter().map(|logged| logged.frame).collect()
    }

    /// The next frame of the sensor, which must have this identifier and come within `limit` milliseconds.
    #[track_caller]
    pub fn expect(&mut self, id: u16, limit: u64) -> Frame {
        let end = after(self.bus.now(), ms(limit));
        loop {
            let own = Source::Device(self.sensor);
            let new = &self.log[self.seen..];
            if let Some(place) = new.iter().position(|logged| logged.source == own) {
                let frame = new[place].frame;
                self.seen += place + 1;
                assert_eq!(frame.id(), standard(id), "{frame:?}");
                return frame;
            }
            assert!(self.bus.now() < end, "no frame within the limit");
            self.run_us(50);
        }
    }

    /// Sends a request and returns the data of the reply, which must have the code of the request.
    #[track_caller]
    pub fn request(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.send(bytes);
        let reply = self.expect(REPLY, patience());
        assert_eq!(reply.bytes()[0], bytes[0], "{reply:?}");
        reply.bytes().to_vec()
    }

    /// Reads the inclination and returns the complete reply.
    #[track_caller]
    pub fn poll(&mut self) -> Vec<u8> {
        self.request(&[fsc::INCLINATION])
    }

    /// Writes a parameter, which must not be refused.
    #[track_caller]
    pub fn write(&mut self, bytes: &[u8]) {
        let reply = self.request(bytes);
        assert_eq!(reply[1] & status::CMD_PARAM_ERROR, 0, "{reply:02X?}");
    }

    /// Saves the parameters, which must succeed.
    #[track_caller]
    pub fn save(&mut self) {
        self.write(&fsc::SAVE);
    }

    /// Writes the cyclic time, a parameter for tests of saves.
    #[track_caller]
    pub fn write_time(&mut self, value: u16) {
        let [low, high] = value.to_le_bytes();
        self.write(&[fsc::WRITE_CYCLIC_TIME, low, high]);
    }

    #[track_caller]
    pub fn read_time(&mut self) -> u16 {
        let reply = self.request(&[fsc::READ_CYCLIC_TIME]);
        u16::from_le_bytes([reply[2], reply[3]])
    }

    /// True while the main loop executes instructions.
    pub fn runs_main_loop(&self) -> bool {
        let core = self.microcontroller().core();
        core.active_exception() == 0 && !core.is_asleep()
    }

    /// Executes this code in place of the main loop, with these values in R0 and R1. The main loop must be running. A fault starts the
    /// handler of the image.
    #[track_caller]
    pub fn execute(&mut self, code: &[u16], registers: [u32; 2]) {
        assert!(self.runs_main_loop());
        self.microcontroller_mut().take_faults();
        let bytes: Vec<u8> = code.iter().flat_map(|it| it.to_le_bytes()).collect();
        let core = self.microcontroller_mut().core_mut();
        assert!(core.load(code_address(), &bytes));
        for (number, value) in (0..).zip(registers) {
            core.set_register(number, value);
        }
        // Not in an IT block.
        core.set_xpsr(0);
        core.set_register(15, code_address());
    }

    /// Switches the power off and on again.
    pub fn power_cycle(&mut self) {
        self.expected.push(ResetCause::PowerOn);
        self.bus.power_cycle(self.sensor);
    }

    /// Adds a reset to the expected ones.
    pub fn expect_reset(&mut self, cause: ResetCause) {
        self.expected.push(cause);
    }

    /// Asserts that the program made the bus recessive and switched the heater off before the last reset.
    #[track_caller]
    pub fn assert_safe_at_reset(&self) {
        let reset = self.microcontroller().resets().last();
        let outputs = reset.map(|reset| (reset.dominant, reset.heater));
        assert_eq!(
            outputs,
            Some((false, 0)),
            "TXD is dominant, duty of the heater"
        );
    }

    /// The test lets the stack overflow.
    pub fn ignore_stack(&mut self) {
        self.overflows = true;
    }

    /// The checks at the end of a test.
    fn check(&mut self) {
        let expected = std::mem::take(&mut self.expected);
        let microcontroller = self.microcontroller();
        check_violations(microcontroller);
        if !self.overflows {
            check_stack(microcontroller);
        }
        let causes: Vec<_> = microcontroller
            .resets()
            .iter()
            .map(|reset| reset.cause)
            .collect();
        assert_eq!(causes, expected, "the resets");
    }
}

/// Asserts that there was no violation of the reference manual, and that the stack has not reached its limit.
pub fn check(microcontroller: &Microcontroller) {
    check_violations(microcontroller);
    check_stack(microcontroller);
}

fn check_violations(microcontroller: &Microcontroller) {
    let violations = microcontroller.violations();
    assert!(violations.is_empty(), "{}", violations.join("\n"));
}

fn check_stack(microcontroller: &Microcontroller) {
    let limit = microcontroller.image().stack_limit();
    let lowest = microcontroller.lowest_stack();
    assert!(
        lowest >= limit,
        "the stack has reached {lowest:#x}, its limit is {limit:#x}"
    );
}

impl Drop for Rig {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.check();
        }
    }
}
