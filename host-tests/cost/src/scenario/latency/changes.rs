//! The phases of a message against the sampling period, and against changes of the heater and of the LEDs.

use super::super::{ERRORS_TO_BUS_OFF, Phases, Scenario};
use super::{Asked, STEP, TRAIN, Trial, us};
use crate::CostError;
use crate::rig::{Rig, Warming};
use plumbline::measure::SAMPLE_PERIOD;
use plumbline::time::{Duration, after, millis};
use std::collections::BTreeSet;
use stm32_sim::board::Board;

/// The step of few phases in us.
const FEW: u64 = 10;

/// The period of the heater's regulator and of blinking LEDs, in us.
const SLOW_PERIOD: u64 = 200_000;

/// The period of a single flash, in us: 200 ms on, 1000 ms off (CiA 303-3).
const FLASH_PERIOD: u64 = 1_200_000;

/// The time in which the integral of the regulator rises, so that the duty is not at a limit later.
const WARM_UP: Duration = millis(30_000);

/// The phases around a change of the heater or of an LED, in us before and after it.
const AROUND: (u64, u64) = (60, 40);

/// The number of changes that are observed without a message, to find their positions in the sampling period.
const OBSERVED: u64 = 16;

/// The number of passes over the phases, if the change has several positions.
const PASSES: usize = 2;

/// The transmit error counter at which the error LED still flashes after some more messages. It flashes from 96 on, and each message
/// decrements the counter.
const ENOUGH_ERRORS: u16 = 120;

impl Scenario {
    /// Every phase of the sampling period; the heater and the LEDs.
    pub(in super::super) fn answers(&mut self) -> Result<(), CostError> {
        let protocol = self.protocol;
        // A reply waits for a sample that is being processed.
        if let Some(slowest) = protocol.slowest_filter {
            self.rig.request(slowest)?;
        }
        if let Some(set_point) = self.product.set_point
            && self.sweep == Phases::All
        {
            let swings = after(self.rig.bus().now(), WARM_UP);
            self.rig.set_motion(Box::new(Warming { set_point, swings }));
            self.rig.run(WARM_UP);
        }
        self.rig.run(us(SLOW_PERIOD));
        let sync = self.asked(protocol.sync, protocol.sync_code)?;
        let read = self.asked(protocol.read, protocol.read_code)?;
        for (asked, median, worst) in [
            (&sync, "sync_median", "sync_worst"),
            (&read, "read_median", "read_worst"),
        ] {
            let mut trials = Vec::new();
            let period = SAMPLE_PERIOD.ticks();
            // With two protocols, a few phases are too coarse: the worst phase is shorter than their step.
            let step = match self.sweep {
                Phases::Few if protocol.j1939.is_none() => FEW,
                _ => STEP,
            };
            self.ask(asked, period / step, period + step, false, &mut trials)?;
            self.record(Some(median), worst, &trials);
        }
        // On the Nucleo, no times are measured. The messages above are sent because they determine the peak of the stack.
        if self.product.board == Board::NucleoF446 || self.sweep == Phases::Few {
            return Ok(());
        }
        let nothing = |_: &mut Self| Ok(());
        if self.product.set_point.is_some() {
            let heater = |rig: &Rig| rig.controller().heater().into();
            self.around(&sync, "heater_worst", SLOW_PERIOD, heater, nothing)?;
            self.around(&read, "heater_read_worst", SLOW_PERIOD, heater, nothing)?;
        }
        if self.next_change(&Rig::led_changes, 1000).is_some() {
            self.around(&sync, "led_worst", SLOW_PERIOD, Rig::led_changes, nothing)?;
            self.around(
                &read,
                "led_read_worst",
                SLOW_PERIOD,
                Rig::led_changes,
                nothing,
            )?;
        }
        Ok(())
    }

    /// The LEDs of a product whose LEDs are steady in normal operation: its error LED flashes from the warning limit of the CAN controller
    /// on.
    pub(in super::super) fn answers_while_flashing(&mut self) -> Result<(), CostError> {
        if self.figures.contains_key("led_worst") {
            return Ok(());
        }
        let protocol = self.protocol;
        self.begin();
        let sync = self.asked(protocol.sync, protocol.sync_code)?;
        let read = self.asked(protocol.read, protocol.read_code)?;
        self.flash()?;
        self.around(
            &sync,
            "led_worst",
            FLASH_PERIOD,
            Rig::led_changes,
            Self::flash,
        )?;
        self.around(
            &read,
            "led_read_worst",
            FLASH_PERIOD,
            Rig::led_changes,
            Self::flash,
        )?;
        self.rig.power_cycle();
        self.rig.run(us(SLOW_PERIOD));
        Ok(())
    }

    /// Corrupts frames of the sensor if necessary, so that its error LED flashes. Each transmitted frame decrements the error counter.
    fn flash(&mut self) -> Result<(), CostError> {
        if self.rig.transmit_errors() < ENOUGH_ERRORS {
            let own = self.rig.source();
            self.rig.bus().corrupt(ERRORS_TO_BUS_OFF / 2, Some(own));
            self.rig.request(self.protocol.read)?;
        }
        Ok(())
    }

    /// Sends a message at each phase around a change that recurs after this period in us, or one sample later. The change is a part of the
    /// processing of a sample, whose duration varies with the number of values. So the change has several positions in the sampling period,
    /// and the phases cover all of them. `prepare` is called before each change.
    fn around(
        &mut self,
        asked: &Asked,
        row: &'static str,
        period: u64,
        state: impl Fn(&Rig) -> u64,
        mut prepare: impl FnMut(&mut Self) -> Result<(), CostError>,
    ) -> Result<(), CostError> {
        const MISSING: CostError = CostError::NeverHappened("a change of heater or LED");
        let grid = SAMPLE_PERIOD.ticks();
        let mut change = self.next_change(&state, 1000).ok_or(MISSING)?;
        let mut places = BTreeSet::new();
        for _ in 0..OBSERVED {
            prepare(self)?;
            let passed = self.rig.bus().now().ticks() - change;
            self.rig.run(us(period - 3_000 - passed));
            change = self.next_change(&state, STEP).ok_or(MISSING)?;
            places.insert(change % grid);
        }
        let (before, behind) = AROUND;
        let first = places.first().map_or(0, |place| place - before.min(*place));
        let end = places.last().map_or(0, |place| place + behind);
        // In one pass, a change with several positions does not occur at each of them.
        let passes = if places.len() == 1 { 1 } else { PASSES };
        let mut trials = Vec::new();
        for place in (0..passes).flat_map(|_| (first..end).step_by(STEP as usize)) {
            prepare(self)?;
            let sample = (change + period) / grid * grid;
            let mut changed = None;
            for sample in [sample, sample + grid] {
                let begin = sample + place - asked.time;
                let now = self.rig.bus().now().ticks();
                self.rig.run(us(begin.saturating_sub(now)));
                changed = self.ask_watching(asked, &state, &mut trials)?;
                if changed.is_some() {
                    break;
                }
            }
            change = match changed {
                Some(at) => at,
                None => self.next_change(&state, STEP).ok_or(MISSING)?,
            };
        }
        self.record(None, row, &trials);
        Ok(())
    }

    /// Sends a message, and returns the time in us at which the state changes; None if it does not change.
    fn ask_watching(
        &mut self,
        asked: &Asked,
        state: &impl Fn(&Rig) -> u64,
        trials: &mut Vec<Trial>,
    ) -> Result<Option<u64>, CostError> {
        self.rig.bus().take_log();
        let old = state(&self.rig);
        let mut changed = None;
        let mut run = |scenario: &mut Self, time: u64| {
            let end = scenario.rig.bus().now().ticks() + time;
            loop {
                let now = scenario.rig.bus().now().ticks();
                if changed.is_none() && state(&scenario.rig) != old {
                    changed = Some(now);
                }
                if now >= end {
                    break;
                }
                scenario.rig.run(us(STEP.min(end - now)));
            }
        };
        let places = self.send_one(asked, &mut run);
        run(self, TRAIN);
        self.collect(asked, [places].into(), false, trials)?;
        Ok(changed)
    }

    /// Runs in steps until the state changes, at most two seconds. Returns the time of the change in us.
    fn next_change(&mut self, state: &impl Fn(&Rig) -> u64, step: u64) -> Option<u64> {
        let before = state(&self.rig);
        (0..2_000_000 / step).find_map(|_| {
            self.rig.run(us(step));
            (state(&self.rig) != before).then(|| self.rig.bus().now().ticks())
        })
    }
}
