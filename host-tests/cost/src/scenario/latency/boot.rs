//! The phases of a message after power-up, until the first measurement.

use super::super::{Scenario, picoseconds};
use super::{AFTER, STEP, TRAIN, us};
use crate::CostError;

/// The maximum time of a start, in us.
const START: u64 = 200_000;

/// The time of the boot-up messages at 1 Mbit/s, in us.
const BOOT_UP: u64 = 400;

/// The time between messages that do not disturb each other's sample: longer than a tick and the read of a sample, in us.
const APART: u64 = 1_500;

/// The time between requests for the first angle: longer than a request and its reply, in us.
const EXCHANGE: u64 = 500;

impl Scenario {
    /// Asks after the boot-up messages. The saves before have filled one page, and the other one is not erased.
    pub(in super::super) fn answers_after_boot(&mut self) -> Result<(), CostError> {
        let protocol = self.protocol;
        let read = self.asked(protocol.starting, protocol.read_code)?;
        let erased = self.rig.erased();
        let (_, time) = self.switch_on()?;
        if self.rig.erased() != erased + 1 {
            return Err(CostError::NeverHappened("a start that erases ahead"));
        }
        self.figures.insert("boot_erase_time", time);
        self.rig.run(us(START));
        let measured = self.first_angle()?;
        let mut left = self.busy_phases(measured)?;
        let mut trials = Vec::new();
        while !left.is_empty() {
            self.rig.power_cycle();
            let start = self.rig.bus().now().ticks();
            // A message also wakes the main loop, so the next one comes only after the next tick and the sample that it starts.
            let mut free = 0;
            let mut later = Vec::new();
            for phase in left {
                if phase < free {
                    later.push(phase);
                    continue;
                }
                free = phase + APART;
                let now = self.rig.bus().now().ticks();
                self.rig.run(us(start + phase - read.time - now));
                self.ask(&read, 1, TRAIN, true, &mut trials)?;
            }
            left = later;
        }
        self.record(None, "boot_worst", &trials);
        Ok(())
    }

    /// Switches the sensor off and on, and runs until the first boot-up message has been sent: the time of the power-up in us, and
    /// the time from it to the start of the message in ns.
    fn switch_on(&mut self) -> Result<(u64, u64), CostError> {
        let own = self.rig.source();
        self.rig.bus().take_log();
        self.rig.power_cycle();
        let start = self.rig.bus().now();
        while self.rig.bus().now().ticks() < start.ticks() + START {
            self.rig.run(us(STEP));
            let log = self.rig.bus().take_log();
            if let Some(first) = log.iter().find(|logged| logged.source == own) {
                let time = first.start - picoseconds(start);
                return Ok((start.ticks(), time.div_ceil(1_000)));
            }
        }
        Err(CostError::NeverHappened("a boot-up message"))
    }

    /// Measures the time from power-up to the first angle; returns it in us.
    pub(in super::super) fn first_angle(&mut self) -> Result<u64, CostError> {
        let protocol = self.protocol;
        let read = self.asked(protocol.read, protocol.read_code)?;
        let own = self.rig.source();
        let (start, _) = self.switch_on()?;
        self.rig.run(us(BOOT_UP));
        self.rig.bus().take_log();
        while self.rig.bus().now().ticks() < start + START {
            self.rig.send(protocol.read);
            self.rig.run(us(EXCHANGE));
            let mut log = self.rig.bus().take_log().into_iter();
            let first = log.find(|logged| {
                let answers = logged.source == own && read.is_answered_by(logged);
                answers && (protocol.has_angle)(logged.frame.bytes())
            });
            if let Some(first) = first {
                let time = first.start - start * 1_000_000;
                self.figures.insert("first_angle", time.div_ceil(1_000));
                return Ok(time / 1_000_000);
            }
        }
        Err(CostError::NeverHappened("an angle after power-up"))
    }

    /// The phases between a start and `end`, in us after power-up, at which the processor executes instructions, or begins to within
    /// [`AFTER`]. All phases in its sleep are equal, so only the first of them is included.
    fn busy_phases(&mut self, end: u64) -> Result<Vec<u64>, CostError> {
        let (start, _) = self.switch_on()?;
        self.rig.run(us(BOOT_UP));
        let first = self.rig.bus().now().ticks() - start;
        let phases = (first..end).step_by(STEP as usize);
        let places: Vec<_> = phases
            .map(|phase| {
                let busy = self.rig.place().is_some();
                self.rig.run(us(STEP));
                (phase, busy)
            })
            .collect();
        let ahead = (AFTER / STEP) as usize;
        let asleep = places.iter().position(|(_, busy)| !busy);
        let matters = |index: &usize| {
            let soon = &places[*index..places.len().min(index + ahead)];
            Some(*index) == asleep || soon.iter().any(|(_, busy)| *busy)
        };
        Ok((0..places.len())
            .filter(matters)
            .map(|index| places[index].0)
            .collect())
    }
}
