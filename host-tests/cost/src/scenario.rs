//! The standard scenario: it uses every function of a sensor at least once, and measures the cost.

mod j1939;
mod latency;

use super::CostError;
use super::products::{MeasuredProduct, Message, Protocol, Service, Step};
use super::rig::Rig;
use can_wire::frame_length::frame_bits;
use can_wire::protocol::{Picoseconds, bit_time};
use plumbline::measure::SAMPLE_PERIOD;
use plumbline::time::{Duration, Instant, millis};
use std::collections::BTreeMap;
use std::rc::Rc;
use stm32_sim::cortex_m::timing::Cycles;
use stm32_sim::elf::Image;

/// Figures by the keys of their rows.
pub type Figures = BTreeMap<&'static str, u64>;

/// Requests of one type that are measured.
const REPETITIONS: usize = 20;

/// Samples of each filter that are measured.
const SAMPLES: u32 = 100;

/// Saves after which both pages must have been full.
const SAVES: usize = 1000;

/// Transmit errors that lead to bus-off: each counts 8, and bus-off begins above 255 (ISO 11898-1).
const ERRORS_TO_BUS_OFF: u32 = 32;

/// The phases at which messages are sent in the sweeps.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Phases {
    /// All: steps of 2 us.
    All,
    /// Steps of 10 us against the sampling period (2 us for a product with two protocols), and nothing else: no saves, boot, heater
    /// and LEDs.
    Few,
}

/// The result of the scenario.
pub struct Outcome {
    /// The measured figures, by row.
    pub figures: Figures,
    /// The worst phases of the rows that have one.
    pub phases: BTreeMap<&'static str, String>,
    /// The peak of the stack in bytes.
    pub stack: u64,
    /// The number of simulated instructions of all runs.
    pub instructions: u64,
}

/// Runs the scenario.
///
/// # Errors
/// The sensor does not behave as expected.
pub fn run(
    product: MeasuredProduct,
    image: Rc<Image>,
    cycles: Cycles,
    sweep: Phases,
) -> Result<Outcome, CostError> {
    let mut scenario = Scenario {
        rig: Rig::new(product, image, cycles),
        protocol: product.protocol,
        product,
        sweep,
        figures: Figures::new(),
        phases: BTreeMap::new(),
    };
    scenario.play()?;
    let controller = scenario.rig.controller();
    let violations = controller.violations();
    if let Some(first) = violations.first() {
        return Err(CostError::Violations {
            model: product.name,
            count: violations.len(),
            first: first.clone(),
        });
    }
    Ok(Outcome {
        stack: controller.peak_stack().into(),
        instructions: controller.core().instructions(),
        figures: scenario.figures,
        phases: scenario.phases,
    })
}

struct Scenario {
    rig: Rig,
    protocol: &'static Protocol,
    product: MeasuredProduct,
    sweep: Phases,
    figures: Figures,
    phases: BTreeMap<&'static str, String>,
}

impl Scenario {
    fn play(&mut self) -> Result<(), CostError> {
        self.rig.detect()?;
        self.steps(self.protocol.preparation)?;
        if !self.protocol.connection.is_empty() {
            // The sensor has restarted.
            self.rig.detect()?;
        }
        // Until the LEDs are steady, and the usage of this start is kept: an answer waits for the flash meanwhile.
        self.rig.run(millis(11_000));
        self.requests()?;
        self.samples()?;
        self.answers()?;
        self.cyclic()?;
        for message in self.protocol.set_up {
            self.rig.request(*message)?;
        }
        self.saves()?;
        self.boot()?;
        if self.product.swept && self.sweep == Phases::All {
            self.answers_while_saving()?;
            self.starts_with_erase()?;
            self.answers_while_flashing()?;
        }
        self.bus_off()?;
        if let Some(messages) = self.protocol.j1939 {
            return self.j1939(messages);
        }
        for message in self.protocol.load {
            self.rig.request(*message)?;
        }
        if self.protocol.restart.is_empty() {
            return Ok(());
        }
        for message in self.protocol.restart {
            self.rig.send(*message);
        }
        self.rig.run(millis(50));
        self.rig.detect()
    }

    fn requests(&mut self) -> Result<(), CostError> {
        let Protocol { write, others, .. } = *self.protocol;
        self.replies("write_median", write)?;
        for message in others {
            self.rig.request(*message)?;
        }
        self.protocol
            .services
            .iter()
            .try_for_each(|service| self.service(service))
    }

    /// Requests a service several times.
    fn service(&mut self, service: &Service) -> Result<(), CostError> {
        let mut times = Vec::new();
        for _ in 0..REPETITIONS {
            self.steps(service.before)?;
            times.push(self.time_of(service.message)?);
            self.steps(service.after)?;
        }
        self.median(service.row, times);
        Ok(())
    }

    /// Requests the same several times.
    fn replies(&mut self, row: &'static str, message: Message) -> Result<(), CostError> {
        let times: Result<_, _> = (0..REPETITIONS).map(|_| self.time_of(message)).collect();
        self.median(row, times?);
        Ok(())
    }

    /// The time from the end of a message to the start of its reply in ns.
    fn time_of(&mut self, message: Message) -> Result<u64, CostError> {
        self.rig.bus().take_log();
        self.rig.request(message)?;
        let (own, frame) = (self.rig.source(), message.frame());
        let length = Picoseconds::from(frame_bits(&frame)) * bit_time(self.rig.bus().rate());
        let mut log = self.rig.bus().take_log().into_iter();
        let asked = log.find(|logged| logged.source != own && logged.frame == frame);
        let reply = log.find(|logged| logged.source == own);
        match (asked, reply) {
            (Some(asked), Some(reply)) => Ok((reply.start - asked.start - length).div_ceil(1_000)),
            _ => Err(self.rig.silent(format!("{message:?}"))),
        }
    }

    /// The median of these times, the larger of the two middle ones.
    fn median(&mut self, row: &'static str, mut times: Vec<u64>) {
        times.sort_unstable();
        self.figures.insert(row, times[times.len() / 2]);
    }

    fn steps(&mut self, steps: &[Step]) -> Result<(), CostError> {
        for step in steps {
            match *step {
                Step::Asked(message) => {
                    self.rig.request(message)?;
                }
                Step::Told(message) => {
                    self.rig.send(message);
                    self.rig.run(millis(1));
                }
            }
        }
        Ok(())
    }

    /// The load of the processor with each filter. The first one is off; for the others, what they add.
    fn samples(&mut self) -> Result<(), CostError> {
        let mut off = 0;
        for filter in self.protocol.filters {
            for setting in filter.settings {
                self.rig.request(*setting)?;
            }
            self.rig.run(millis(20));
            let before = self.rig.instructions();
            for _ in 0..SAMPLES {
                self.rig.run(SAMPLE_PERIOD);
            }
            let load = (self.rig.instructions() - before) / u64::from(SAMPLES);
            self.figures.insert(filter.load, load.saturating_sub(off));
            if off == 0 {
                off = load;
            }
        }
        Ok(())
    }

    fn cyclic(&mut self) -> Result<(), CostError> {
        if self.protocol.cyclic.is_empty() {
            return Ok(());
        }
        for message in self.protocol.cyclic {
            self.rig.request(*message)?;
        }
        self.rig
            .receive(10, millis(500), || "cyclic mode".to_owned())?;
        for message in self.protocol.not_cyclic {
            self.rig.request(*message)?;
        }
        Ok(())
    }

    /// Saves until a page must be erased.
    fn saves(&mut self) -> Result<(), CostError> {
        if self.protocol.saves.is_empty() {
            return Ok(());
        }
        let before = self.rig.erased();
        for message in self.protocol.saves.iter().cycle().take(SAVES) {
            self.rig.request(*message)?;
            self.rig.run(self.protocol.saves_later);
            if self.rig.erased() != before {
                return Ok(());
            }
        }
        Err(CostError::NeverHappened("the erase of a page"))
    }

    /// Lets the sensor answer the synchronous message after a start.
    fn begin(&mut self) {
        for message in self.protocol.begin {
            self.rig.send(*message);
            self.rig.run(millis(1));
        }
    }

    /// Measures a power-up with the saved bit rate.
    fn boot(&mut self) -> Result<(), CostError> {
        let (start, before) = (self.rig.bus().now(), self.rig.instructions());
        self.rig.bus().take_log();
        self.rig.power_cycle();
        for _ in 0..1_000_000 {
            self.rig.run(Duration::from_ticks(1));
            if self.rig.offers() {
                break;
            }
        }
        let boot = self.rig.instructions() - before;
        self.figures.insert("boot", boot);
        self.rig
            .receive(self.protocol.boot_up, millis(100), || "boot-up".to_owned())?;
        let log = self.rig.bus().take_log();
        let first = log
            .first()
            .ok_or(CostError::NeverHappened("a boot-up message"))?;
        let time = first.start - picoseconds(start);
        self.figures.insert("boot_time", time.div_ceil(1_000));
        self.rig.connect()?;
        self.begin();
        Ok(())
    }

    /// Forces bus-off and waits for the recovery.
    fn bus_off(&mut self) -> Result<(), CostError> {
        let own = self.rig.source();
        self.rig.bus().corrupt(ERRORS_TO_BUS_OFF, Some(own));
        self.rig.send(self.protocol.read);
        let mut was_off = false;
        for _ in 0..1_000 {
            self.rig.run(Duration::from_ticks(20));
            was_off |= self.rig.is_bus_off();
        }
        if !was_off {
            return Err(CostError::NeverHappened("bus-off"));
        }
        self.rig.connect()?;
        self.rig.request(self.protocol.read)?;
        Ok(())
    }
}

/// A bus time in picoseconds.
fn picoseconds(at: Instant) -> Picoseconds {
    at.ticks() * 1_000_000
}
