//! The standard scenario: it uses every function of a sensor at least once, and measures the cost.

use super::CostError;
use super::calls::{exchange, median, middle, most, reply, save};
use super::function::{Angles, CALIBRATION, NODE, STORE_SAVE, STORE_STEP};
use super::products::{Filter, MeasuredProduct, Message, Protocol};
use super::rig::Rig;
use can_wire::frame_length::frame_bits;
use can_wire::protocol::{Picoseconds, bit_time};
use plumbline::time::{Duration, Instant, millis};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use stm32_sim::elf::Image;
use stm32_sim::profile::Call;

/// Figures by the keys of their rows.
pub type Figures = BTreeMap<&'static str, u64>;

/// SYNC frames whose reply time is measured.
const PHASES: usize = 5_000;

/// The period of the SYNC frames. Relative to the 5 ms sampling period, with five ticks in it, each of the five thousand frames has
/// a different phase, in steps of 1 us, so that they cover the period and find the longest time to 1 us.
const SYNC_PERIOD: Duration = Duration::from_ticks(1_001);

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
    /// The peak of the stack in bytes.
    pub stack: u64,
    /// Simulated instructions.
    pub instructions: u64,
}

/// Runs the scenario.
///
/// # Errors
/// The sensor does not behave as expected, or a measured function is missing.
pub fn run(product: MeasuredProduct, image: Rc<Image>) -> Result<Outcome, CostError> {
    let mut scenario = Scenario {
        rig: Rig::new(product, image),
        protocol: product.protocol,
        angles: product.angles,
        figures: Figures::new(),
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
    })
}

struct Scenario {
    rig: Rig,
    protocol: &'static Protocol,
    angles: Angles,
    figures: Figures,
    /// The calls of all sampling phases.
    samples: Vec<Call>,
}

impl Scenario {
    fn watch(&mut self) -> Result<(), CostError> {
        let node = NODE;
        let of_node = [
            node.receive,
            node.poll,
            node.transmit,
            node.sample,
            node.stored,
        ];
        let shared = [CALIBRATION, STORE_SAVE, STORE_STEP];
        let filters = self.protocol.filters.iter();
        let of_filters = filters.flat_map(|filter| filter.step.into_iter().chain(filter.tune));
        let of_rows = of_filters.chain(self.angles.0.iter().copied());
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
        self.quiet()?;
        self.requests()?;
        self.samples()?;
        self.sync()?;
        self.cyclic()?;
        for message in self.protocol.set_up {
            self.rig.request(*message)?;
        }
        self.saves()?;
        self.boot()?;
        self.bus_off()?;
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
        let poll = median(&calls, NODE.poll)?;
        self.figures.insert("idle_poll", poll);
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
            self.figures.insert(row, total);
            self.figures.extend(reply_row.map(|row| (row, until_reply)));
        }
        for message in self.protocol.others {
            self.rig.request(*message)?;
        }
        Ok(())
    }

    /// The maximum for this message: all instructions in core, and those until its reply is returned.
    fn exchange(&mut self, message: Message) -> Result<(u64, u64), CostError> {
        let (mut total, mut until_reply) = (0, 0);
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
        parts.extend(self.angles.0);
        for (row, function) in parts {
            self.figures.insert(row, most(&self.samples, function)?);
        }
        if let Some(both) = self.figures.get("perpendicular") {
            self.figures.insert("angle", both.div_ceil(2));
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
        let figure = most(&calls, NODE.sample)?;
        self.figures.insert(filter.sample, figure);
        for (part, calls) in [(filter.step, &calls), (filter.tune, &tuned)] {
            if let Some((row, function)) = part {
                let figure = most(calls, function)?;
                let most = self.figures.entry(row).or_default();
                *most = figure.max(*most);
            }
        }
        self.samples.extend(calls);
        Ok(())
    }

    /// Sends SYNC frames at every phase of the periods of the firmware.
    fn sync(&mut self) -> Result<(), CostError> {
        let Protocol {
            sync,
            slowest_filter,
            ..
        } = *self.protocol;
        // A reply waits for a sample that is being processed.
        self.rig.request(slowest_filter)?;
        self.rig.bus().take_log();
        for _ in 0..PHASES {
            self.rig.send(sync);
            self.rig.run(SYNC_PERIOD);
        }
        let own = self.rig.source();
        let log = self.rig.bus().take_log();
        let length = Picoseconds::from(frame_bits(&sync.frame())) * bit_time(self.rig.bus().rate());
        let mut times: Vec<Picoseconds> = log
            .windows(2)
            .filter(|pair| pair[0].source != own && pair[1].source == own)
            .map(|pair| pair[1].start - pair[0].start - length)
            .collect();
        if times.len() != PHASES {
            let answered = times.len();
            return Err(self
                .rig
                .silent(format!("SYNC: only {answered} replies to {PHASES} frames")));
        }
        times.sort_unstable();
        for (row, time) in [
            ("sync_median", times[PHASES / 2]),
            ("sync_worst", times[PHASES - 1]),
        ] {
            self.figures.insert(row, time.div_ceil(1_000));
        }
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
        let mut figures = Vec::new();
        while self.rig.erased() == before {
            if figures.len() == SAVES {
                return Err(CostError::NeverHappened("the erase of a page"));
            }
            let calls = self.rig.request(self.protocol.save)?;
            figures.push(save(&calls, &NODE)?);
        }
        let most = figures.iter().copied().max().unwrap_or_default();
        self.figures.insert("save_most", most);
        let median = middle(figures).unwrap_or_default();
        self.figures.insert("save", median);
        Ok(())
    }

    /// Measures a power-up with the saved bit rate.
    fn boot(&mut self) -> Result<(), CostError> {
        let instructions = |rig: &Rig| rig.controller().core().instructions();
        let (start, before) = (self.rig.bus().now(), instructions(&self.rig));
        self.rig.bus().take_log();
        self.rig.power_cycle();
        for _ in 0..1_000_000 {
            self.rig.run(Duration::from_ticks(1));
            if self.rig.offers() {
                break;
            }
        }
        let figure = instructions(&self.rig) - before;
        self.figures.insert("boot", figure);
        self.rig
            .receive(self.protocol.boot_up, millis(100), || "boot-up".to_owned())?;
        let log = self.rig.bus().take_log();
        let first = log
            .first()
            .ok_or(CostError::NeverHappened("a boot-up message"))?;
        let time = first.start - picoseconds(start);
        self.figures.insert("boot_time", time.div_ceil(1_000));
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
        self.rig.request(self.protocol.read)?;
        Ok(())
    }
}

/// A bus time in picoseconds.
fn picoseconds(at: Instant) -> Picoseconds {
    at.ticks() * 1_000_000
}
