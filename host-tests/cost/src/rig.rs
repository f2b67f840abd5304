//! The microcontroller and a tester on a wire.

use super::CostError;
use super::products::{MeasuredProduct, Message};
use bench::motion::Motion;
use bench::{AdapterId, Bus, DeviceId, Flash, Source};
use plumbline::can::{Frame, standard};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::node::BusState;
use plumbline::time::{Duration, Instant, after, millis, reached};
use std::f64::consts::TAU;
use std::rc::Rc;
use stm32_sim::Microcontroller;
use stm32_sim::board::Board;
use stm32_sim::cortex_m::timing::Cycles;
use stm32_sim::elf::Image;
use stm32_sim::flash::Times;

/// Maximum time of a reply: a save that erases a page takes 40 ms and more.
const PATIENCE: Duration = millis(500);

/// The number of frames, one every 10 ms, after which the sensor must have found the bit rate.
const DETECTION_FRAMES: usize = 300;

/// Polling interval for a reply.
const LOOK: Duration = Duration::from_ticks(200);

/// A frame that makes the bit rate detectable; no device uses its identifier.
const UNUSED: Message = Message(0x7FE, &[]);

/// Rotates through all directions, so that the angle calculation takes every path. No axis sees more than 1 g.
struct Tumble;

impl Motion for Tumble {
    fn reading(&mut self, now: Instant) -> Reading {
        let seconds = now.ticks() as f64 / 1e6;
        let (turn, nod) = (TAU * seconds / 0.53, TAU * seconds / 1.7);
        let one_g = |part: f64| (part * f64::from(ONE_G)) as i32;
        Reading {
            acceleration: I32x3 {
                x: one_g(turn.sin() * nod.cos()),
                y: one_g(nod.sin()),
                z: one_g(turn.cos() * nod.cos()),
            },
            temperature: 25_00,
            ..Reading::default()
        }
    }
}

/// The same motion with a changing temperature: first it is 6 K below the set point of the heater, then it rises and falls around the set
/// point, so that the regulator changes the duty in each period.
pub struct Warming {
    /// The set point of the heater in 0.01 degC.
    pub set_point: i16,
    /// From this time on, the temperature rises and falls.
    pub swings: Instant,
}

impl Motion for Warming {
    fn reading(&mut self, now: Instant) -> Reading {
        let deviation = if reached(now, self.swings) {
            // Falls by 2 K in 5 s, then rises by 2 K in 5 s.
            let phase = (now.ticks() % 10_000_000) as f64 / 5e6;
            200.0 * (phase - 1.0).abs() - 100.0
        } else {
            -600.0
        };
        Reading {
            temperature: self.set_point + deviation as i16,
            ..Tumble.reading(now)
        }
    }
}

/// A sensor and a tester.
pub struct Rig {
    bus: Bus,
    device: DeviceId,
    tester: AdapterId,
    product: MeasuredProduct,
}

impl Rig {
    /// A sensor with blank memory, which is switched on.
    pub fn new(product: MeasuredProduct, image: Rc<Image>, cycles: Cycles) -> Self {
        let mut bus = Bus::new(product.protocol.bus);
        let motion = Box::new(Tumble);
        let memory = Flash::blank(image.board().chip().facts().geometry);
        let mut controller = Microcontroller::new(product.name, image, 1, memory, motion).quiet();
        // The cycles of the Cortex-M4 are not modelled.
        if product.board == Board::BluePill {
            controller.core_mut().set_cycles(Some(cycles));
            controller
                .io_mut()
                .flash
                .set_times(Times::longest(product.board.chip()));
        }
        let device = bus.attach(controller);
        let tester = bus.adapter();
        bus.open(tester, None, false);
        Self {
            bus,
            device,
            tester,
            product,
        }
    }

    /// The bus with the sensor and the tester.
    pub fn bus(&mut self) -> &mut Bus {
        &mut self.bus
    }

    /// The sensor as a sender.
    pub fn source(&self) -> Source {
        Source::Device(self.device)
    }

    /// True when a frame of the sensor is in a mailbox.
    pub fn offers(&self) -> bool {
        self.bus.device(self.device).offered().is_some()
    }

    /// True when the sensor is bus-off.
    pub fn is_bus_off(&self) -> bool {
        self.bus.device(self.device).bus_state() == Some(BusState::BusOff)
    }

    /// The transmit error counter of the sensor.
    pub fn transmit_errors(&self) -> u16 {
        let counters = self.bus.device(self.device).error_counters();
        counters.map_or(0, |(transmit, _)| transmit)
    }

    /// Switches the sensor off and on.
    pub fn power_cycle(&mut self) {
        self.bus.power_cycle(self.device);
    }

    /// The number of erased pages of its parameter memory.
    pub fn erased(&mut self) -> u64 {
        self.bus.device_mut(self.device).flash().erased()
    }

    /// Changes the motion of the sensor.
    pub fn set_motion(&mut self, motion: Box<dyn Motion>) {
        self.bus.device_mut(self.device).set_motion(motion);
    }

    /// The number of changes of the LEDs so far.
    pub fn led_changes(&self) -> u64 {
        self.bus.device(self.device).led_history().len() as u64
    }

    /// The address that the processor executes; None while it sleeps.
    pub fn place(&self) -> Option<u32> {
        let core = self.controller().core();
        (!core.is_asleep()).then(|| core.pc())
    }

    /// The short name of the function at this address: the last two parts of its path.
    pub fn name_of(&self, place: Option<u32>) -> String {
        let Some(address) = place else {
            return "asleep".to_owned();
        };
        let image = self.controller().image();
        image
            .name_of(address)
            .map_or_else(|| "unknown".to_owned(), |(name, _)| short(name))
    }

    /// The simulated microcontroller of the sensor.
    pub fn controller(&self) -> &Microcontroller {
        Microcontroller::of(self.bus.device(self.device)).expect("it was attached as one")
    }

    /// The instructions that the processor has executed.
    pub fn instructions(&self) -> u64 {
        self.controller().core().instructions()
    }

    /// Runs the bus and the sensor for this simulated time.
    pub fn run(&mut self, time: Duration) {
        let until = after(self.bus.now(), time);
        self.bus.run_until(until);
    }

    /// Sends a message, waits for the reply, and half a millisecond more.
    ///
    /// # Errors
    /// There is no reply.
    pub fn request(&mut self, message: Message) -> Result<(), CostError> {
        self.bus.take_received(self.tester);
        self.send(message);
        self.receive(1, PATIENCE, || format!("message {:02X?}", message.1))?;
        self.run(Duration::from_ticks(500));
        Ok(())
    }

    /// Sends a message of the tester.
    pub fn send(&mut self, message: Message) {
        self.bus.send(self.tester, message.frame());
    }

    /// Sends frames until the sensor has found the bit rate and sent its boot-up messages.
    ///
    /// # Errors
    /// It does not find it.
    pub fn detect(&mut self) -> Result<(), CostError> {
        self.bus.take_received(self.tester);
        for _ in 0..DETECTION_FRAMES {
            self.send(UNUSED);
            self.run(millis(10));
            if !self.bus.take_received(self.tester).is_empty() {
                // Until the first measurement.
                self.run(millis(100));
                return self.connect();
            }
        }
        Err(self.silent("bit rate detection".to_owned()))
    }

    /// Waits until the sensor answers requests, and allocates connections.
    ///
    /// # Errors
    /// It refuses them.
    pub fn connect(&mut self) -> Result<(), CostError> {
        self.run(self.product.protocol.online);
        for message in self.product.protocol.connection {
            self.request(*message)?;
        }
        Ok(())
    }

    /// Waits until the sensor has sent `count` frames. Emergency messages do not count.
    ///
    /// # Errors
    /// They are not sent in time; `what` describes the request.
    pub fn receive(
        &mut self,
        count: usize,
        patience: Duration,
        what: impl Fn() -> String,
    ) -> Result<(), CostError> {
        let limit = after(self.bus.now(), patience);
        let mut came = 0;
        while came < count {
            if self.bus.now() >= limit {
                return Err(self.silent(what()));
            }
            self.run(LOOK);
            let received = self.bus.take_received(self.tester);
            let emergency = self.product.protocol.emergency.map(standard);
            let is_reply = |frame: &Frame| Some(frame.id()) != emergency;
            came += received.iter().filter(|(_, frame)| is_reply(frame)).count();
        }
        Ok(())
    }

    /// The error for a missing reply.
    pub fn silent(&self, to: String) -> CostError {
        CostError::Silent(self.product.name, to)
    }
}

/// The last two parts of the path of a function, without generic arguments and without the trait of a method.
fn short(name: &str) -> String {
    let mut plain = String::new();
    let mut depth = 0;
    // `<Type as Trait>::method` is `Type::method`.
    let name = match (name.split_once(" as "), name.rsplit_once(">::")) {
        (Some((own, _)), Some((_, method))) => format!("{}::{method}", own.trim_start_matches('<')),
        _ => name.to_owned(),
    };
    for letter in name.chars() {
        match letter {
            '<' => depth += 1,
            '>' => depth -= 1,
            _ if depth == 0 => plain.push(letter),
            _ => {}
        }
    }
    let mut parts: Vec<&str> = plain.rsplit("::").filter(|part| !part.is_empty()).collect();
    parts.truncate(2);
    parts.reverse();
    parts.join("::")
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn names_of_functions_are_shortened() {
        for (name, expected) in [
            ("memcpy", "memcpy"),
            ("plumbline::angle::Angle::atan2", "Angle::atan2"),
            (
                "plumbline::node::can_node::CanNode<A,P> as plumbline::node::Node>::sample",
                "CanNode::sample",
            ),
            (
                "<plumbline::node::can_node::CanNode<A,P> as plumbline::node::Node>::sample",
                "CanNode::sample",
            ),
            ("plumbline::store::slots::Store<M,B>::step", "Store::step"),
        ] {
            assert_eq!(short(name), expected);
        }
    }
}
