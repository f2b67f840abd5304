//! The standard scenario: it uses every function of a sensor at least once, and measures the cost.

mod j1939;
mod latency;

use super::CostError;
use super::calls::{Count, exchange, median, most, reply, save};
use super::function::{CALIBRATION, NODE, STORE_SAVE, STORE_STEP};
use super::products::{Filter, MeasuredProduct, Message, Protocol, Service, Step};
use super::rig::Rig;
use can_wire::protocol::Picoseconds;
use plumbline::time::{Duration, Instant, millis};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use stm32_sim::cortex_m::timing::Cycles;
use stm32_sim::elf::Image;
use stm32_sim::profile::Call;

/// Figures by the keys of their rows.
pub type Figures = BTreeMap<&'static str, u64>;

/// Requests of one type that are counted.
const REPETITIONS: usize = 20;

/// Sampling time for each filter: 100 samples.
const SAMPLING: Duration = millis(500);

/// Saves after which both pages must have been full.
const SAVES: usize = 1000;

/// Transmit errors that lead to bus-off: each counts 8, and bus-off begins above 255 (ISO 11898-1).
const ERRORS_TO_BUS_OFF: u32 = 32;

/// The result of the scenario.
pub struct Outcome {
    /// The figures.
    pub figures: Figures,
    /// Cycles of the rows whose figures are instructions.
    pub cycles: Figures,
    /// The worst phases of the rows that have one.
    pub phases: BTreeMap<&'static str, String>,
    /// The peak of the stack in bytes.
    pub stack: u64,
    /// Simulated instructions.
    pub instructions: u64,
}

/// Runs the scenario.
///
/// # Errors
/// The sensor does not behave as expected, or a measured function is missing.
pub fn run(
    product: MeasuredProduct,
    image: Rc<Image>,
    cycles: Cycles,
) -> Result<Outcome, CostError> {
    let mut scenario = Scenario {
        rig: Rig::new(product, image, cycles),
        protocol: product.protocol,
        product,
        figures: Figures::new(),
        cycles: Figures::new(),
        phases: BTreeMap::new(),
        samples: Vec::new(),
    };
    scenario.watch()?;
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
        cycles: scenario.cycles,
        phases: scenario.phases,
    })
}

struct Scenario {
    rig: Rig,
    protocol: &'static Protocol,
    product: MeasuredProduct,
    figures: Figures,
    cycles: Figures,
    phases: BTreeMap<&'static str, String>,
    /// The calls of all sampling phases.
    samples: Vec<Call>,
}

impl Scenario {
    fn watch(&mut self) -> Result<(), CostError> {
        let node = NODE;
        let of_node = [
            node.receive,
            node.is_idle,
            node.tick,
            node.action,
            node.transmit,
            node.sample,
            node.stored,
        ];
        let shared = [CALIBRATION, STORE_SAVE, STORE_STEP];
        let filters = self.protocol.filters.iter();
        let of_filters = filters.flat_map(|filter| filter.step.into_iter().chain(filter.tune));
        let of_services = self.protocol.services.iter();
        let of_services = of_services.filter_map(|service| Some((service.row, service.function?)));
        let of_rows = of_filters
            .chain(of_services)
            .chain(self.product.angles.0.iter().copied());
        // Each function once, though several filters share some.
        let functions: BTreeSet<&'static str> = of_node
            .into_iter()
            .chain(shared)
            .chain(of_rows.map(|(_, function)| function))
            .collect();
        functions
            .into_iter()
            .try_for_each(|function| self.rig.watch(function))
    }

    fn play(&mut self) -> Result<(), CostError> {
        self.rig.detect()?;
        for message in self.protocol.preparation {
            self.rig.request(*message)?;
        }
        if !self.protocol.connection.is_empty() {
            // The sensor has restarted.
            self.rig.detect()?;
        }
        self.quiet()?;
        self.requests()?;
        self.samples()?;
        self.answers()?;
        self.cyclic()?;
        for message in self.protocol.set_up {
            self.rig.request(*message)?;
        }
        self.saves()?;
        self.boot()?;
        if self.product.swept {
            self.answers_while_saving()?;
            self.answers_after_boot()?;
            self.answers_while_flashing()?;
        }
        self.bus_off()?;
        if let Some(messages) = self.protocol.j1939 {
            return self.j1939(messages);
        }
        self.rig.request(self.protocol.load)?;
        self.rig.send(self.protocol.restart);
        self.rig.run(millis(50));
        self.rig.detect()
    }

    /// Measures without any input.
    fn quiet(&mut self) -> Result<(), CostError> {
        // Waits until the LEDs are steady.
        self.rig.run(millis(500));
        self.rig.take_calls();
        self.rig.run(millis(100));
        let calls = self.rig.take_calls();
        let poll = median(&calls, NODE.is_idle)?;
        self.count("idle_poll", poll);
        Ok(())
    }

    fn requests(&mut self) -> Result<(), CostError> {
        let Protocol {
            read, write, sync, ..
        } = *self.protocol;
        for (row, reply_row, message) in [
            ("read_request", Some("read_reply"), read),
            ("write_request", None, write),
            ("sync", Some("sync_reply"), sync),
        ] {
            let (total, until_reply) = self.exchange(message)?;
            self.count(row, total);
            if let Some(row) = reply_row {
                self.count(row, until_reply);
            }
        }
        for message in self.protocol.others {
            self.rig.request(*message)?;
        }
        self.protocol
            .services
            .iter()
            .try_for_each(|service| self.service(service))
    }

    /// The maximum for the request of a service.
    fn service(&mut self, service: &Service) -> Result<(), CostError> {
        let mut total = Count::default();
        for _ in 0..REPETITIONS {
            self.steps(service.before)?;
            let calls = self.rig.request(service.message)?;
            total = total.max(match service.function {
                Some(function) => most(&calls, function)?,
                None => exchange(&calls, &NODE)?,
            });
            self.steps(service.after)?;
        }
        self.count(service.row, total);
        Ok(())
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

    /// Instructions and cycles of a row.
    fn count(&mut self, row: &'static str, count: Count) {
        self.figures.insert(row, count.instructions);
        self.cycles.insert(row, count.cycles);
    }

    /// The maximum for this message: all counts in core, and those until its reply is returned.
    fn exchange(&mut self, message: Message) -> Result<(Count, Count), CostError> {
        let (mut total, mut until_reply) = (Count::default(), Count::default());
        for _ in 0..REPETITIONS {
            let calls = self.rig.request(message)?;
            total = total.max(exchange(&calls, &NODE)?);
            until_reply = until_reply.max(reply(&calls, &NODE)?);
        }
        Ok((total, until_reply))
    }

    /// Measures each filter.
    fn samples(&mut self) -> Result<(), CostError> {
        for filter in self.protocol.filters {
            self.filter(filter)?;
        }
        let mut parts = vec![("calibration", CALIBRATION)];
        parts.extend(self.product.angles.0);
        for (row, function) in parts {
            let count = most(&self.samples, function)?;
            self.count(row, count);
        }
        for figures in [&mut self.figures, &mut self.cycles] {
            if let Some(both) = figures.get("perpendicular") {
                figures.insert("angle", both.div_ceil(2));
            }
        }
        Ok(())
    }

    /// Sets a filter, with the measured setting last, and takes samples.
    fn filter(&mut self, filter: &Filter) -> Result<(), CostError> {
        let mut tuned = Vec::new();
        for setting in filter.settings {
            tuned.extend(self.rig.request(*setting)?);
        }
        self.rig.run(millis(20));
        self.rig.take_calls();
        self.rig.run(SAMPLING);
        let calls = self.rig.take_calls();
        let count = most(&calls, NODE.sample)?;
        self.count(filter.sample, count);
        for (part, calls) in [(filter.step, &calls), (filter.tune, &tuned)] {
            if let Some((row, function)) = part {
                let count = most(calls, function)?;
                let before = Count {
                    instructions: self.figures.get(row).copied().unwrap_or_default(),
                    cycles: self.cycles.get(row).copied().unwrap_or_default(),
                };
                self.count(row, count.max(before));
            }
        }
        self.samples.extend(calls);
        Ok(())
    }

    fn cyclic(&mut self) -> Result<(), CostError> {
        for message in self.protocol.cyclic {
            self.rig.request(*message)?;
        }
        self.rig
            .receive(10, millis(500), || "cyclic mode".to_owned())?;
        self.rig.request(self.protocol.not_cyclic)?;
        Ok(())
    }

    /// Saves until a page must be erased.
    fn saves(&mut self) -> Result<(), CostError> {
        let before = self.rig.erased();
        let mut saves = self.protocol.saves.iter().cycle();
        let mut figures = Vec::new();
        while self.rig.erased() == before {
            if figures.len() == SAVES {
                return Err(CostError::NeverHappened("the erase of a page"));
            }
            let message = saves.next().ok_or(CostError::NeverHappened("a save"))?;
            let mut calls = self.rig.request(*message)?;
            self.rig.run(self.protocol.saves_later);
            calls.extend(self.rig.take_calls());
            figures.push(save(&calls, &NODE)?);
        }
        let most = figures.iter().copied().reduce(Count::max);
        self.count("save_most", most.unwrap_or_default());
        let median = Count::middle(&figures).unwrap_or_default();
        self.count("save", median);
        Ok(())
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
        let count = |rig: &Rig| {
            let core = rig.controller().core();
            (core.instructions(), core.cycle())
        };
        let (start, before) = (self.rig.bus().now(), count(&self.rig));
        self.rig.bus().take_log();
        self.rig.power_cycle();
        for _ in 0..1_000_000 {
            self.rig.run(Duration::from_ticks(1));
            if self.rig.offers() {
                break;
            }
        }
        let after = count(&self.rig);
        let boot = Count {
            instructions: after.0 - before.0,
            cycles: after.1 - before.1,
        };
        self.count("boot", boot);
        self.rig
            .receive(self.protocol.boot_up, millis(100), || "boot-up".to_owned())?;
        let log = self.rig.bus().take_log();
        let first = log
            .first()
            .ok_or(CostError::NeverHappened("a boot-up message"))?;
        let time = first.start - picoseconds(start);
        self.figures.insert("boot_time", time.div_ceil(1_000));
        // Until the first measurement.
        self.rig.run(millis(100));
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
