//! How long an answer takes, at every phase of the message against the firmware's own work: samples and ticks, heater, LEDs, saves
//! and boot, in steps of 2 us. The worst phase has a name: the function that the processor executes at the end of the message, and the one behind
//! the receive interrupt, for which the answer waits.

mod erases;

use super::super::CostError;
use super::super::products::Message;
use super::super::rig::{Rig, Warming};
use super::{Scenario, picoseconds};
use bench::Logged;
use can_wire::frame_length::frame_bits;
use can_wire::protocol::{Picoseconds, bit_time};
use erases::Erases;
use plumbline::can::Frame;
use plumbline::measure::SAMPLE_PERIOD;
use plumbline::time::Duration;
use std::collections::VecDeque;

/// The step of the phases in us.
const STEP: u64 = 2;

/// The time of an answer, with which the next message does not disturb it, in us.
const ANSWER: u64 = 400;

/// From the end of a message, the time until the receive interrupt is over, in us.
const AFTER: u64 = 8;

/// The period of the messages in a train, in us: a save is swept by trains, each a step later. It keeps the processor awake, so that
/// the messages do not shift its work.
const TRAIN: u64 = 500;

/// The period of the heater's regulator and of blinking LEDs, in us.
const SLOW_PERIOD: u64 = 200_000;

/// The phases around a change of the heater or of an LED, in us before and after it.
const AROUND: (u64, u64) = (60, 40);

/// How long a save that erases a page takes at most, in us.
const ERASING: u64 = 60_000;

/// The time of the boot-up messages at 1 Mbit/s, in us.
const BOOT_UP: u64 = 400;

/// The time between messages that do not disturb each other's sample: longer than a tick and the read of a sample, in us.
const APART: u64 = 1_500;

/// From the boot-up message, how long the boot is swept, in us.
const BOOTING: u64 = 12_000;

/// A message whose answer is awaited.
struct Asked {
    message: Message,
    /// Its duration in us.
    bits: u64,
    /// An answer, and how many of its first bytes every answer has.
    answer: (Frame, usize),
}

impl Asked {
    fn is_answered_by(&self, logged: &Logged) -> bool {
        let (answer, code) = &self.answer;
        let same_code = logged.frame.bytes().get(..*code) == answer.bytes().get(..*code);
        logged.frame.id() == answer.id() && same_code
    }
}

/// One message and its answer.
#[derive(Clone, Copy)]
struct Trial {
    /// From the end of the message to the start of the answer.
    time: Picoseconds,
    /// The addresses that the processor executes 2 us before the end of the message, and behind the receive interrupt; None while
    /// it sleeps.
    places: [Option<u32>; 2],
}

/// A message without an answer yet.
struct Waiting {
    end: Picoseconds,
    places: [Option<u32>; 2],
    /// Another frame of the sensor has come in between.
    disturbed: bool,
}

const fn us(time: u64) -> Duration {
    Duration::from_ticks(time)
}

impl Scenario {
    /// Every phase of the sampling period; the heater and the LEDs.
    pub(super) fn answers(&mut self) -> Result<(), CostError> {
        let protocol = self.protocol;
        // A reply waits for a sample that is being processed.
        self.rig.request(protocol.slowest_filter)?;
        self.rig.set_motion(Box::new(Warming));
        self.rig.run(us(SLOW_PERIOD));
        let sync = self.asked(protocol.sync, protocol.sync_code)?;
        let read = self.asked(protocol.read, protocol.read_code)?;
        for (asked, median, worst) in [
            (&sync, "sync_median", "sync_worst"),
            (&read, "read_median", "read_worst"),
        ] {
            let mut trials = Vec::new();
            let period = SAMPLE_PERIOD.ticks();
            self.ask(asked, period / STEP, period + STEP, false, &mut trials)?;
            self.record(Some(median), worst, &trials);
        }
        let heater = |rig: &Rig| rig.controller().heater().into();
        self.around(&sync, "heater_worst", heater)?;
        self.around(&sync, "led_worst", Rig::led_changes)?;
        Ok(())
    }

    /// A message with its answer, which it asks for once.
    fn asked(&mut self, message: Message, code: usize) -> Result<Asked, CostError> {
        self.rig.run(us(ANSWER));
        self.rig.bus().take_log();
        self.rig.send(message);
        self.rig.run(us(10 * ANSWER));
        let own = self.rig.source();
        let log = self.rig.bus().take_log();
        let answer = log.iter().find(|logged| logged.source == own);
        let answer = answer.ok_or_else(|| self.rig.silent(format!("{message:?}")))?;
        Ok(Asked {
            message,
            bits: frame_bits(&message.frame()).into(),
            answer: (answer.frame, code),
        })
    }

    /// Sends a message `count` times with this period in us. An answer behind another frame of the sensor is not counted, because
    /// it waits for the bus. `joining`: messages before another frame of the sensor get no answer.
    fn ask(
        &mut self,
        asked: &Asked,
        count: u64,
        period: u64,
        joining: bool,
        trials: &mut Vec<Trial>,
    ) -> Result<(), CostError> {
        self.rig.bus().take_log();
        let mut places = VecDeque::new();
        for _ in 0..count {
            self.rig.send(asked.message);
            // Before the receive interrupt, which comes a bit before the end of the frame.
            self.rig.run(us(asked.bits - 2));
            let before = self.rig.place();
            self.rig.run(us(2 + AFTER));
            places.push_back([before, self.rig.place()]);
            self.rig.run(us(period - asked.bits - AFTER));
        }
        self.rig.run(us(ANSWER));
        let own = self.rig.source();
        let length = Picoseconds::from(asked.bits) * bit_time(self.rig.bus().rate());
        let frame = asked.message.frame();
        let mut waiting: VecDeque<Waiting> = VecDeque::new();
        for logged in self.rig.bus().take_log() {
            if logged.source != own {
                if logged.frame == frame {
                    waiting.push_back(Waiting {
                        end: logged.start + length,
                        places: places.pop_front().unwrap_or_default(),
                        disturbed: false,
                    });
                }
            } else if asked.is_answered_by(&logged) {
                if let Some(first) = waiting.pop_front().filter(|first| !first.disturbed) {
                    trials.push(Trial {
                        time: logged.start - first.end,
                        places: first.places,
                    });
                }
            } else if joining {
                waiting.clear();
            } else {
                waiting.iter_mut().for_each(|one| one.disturbed = true);
            }
        }
        if waiting.is_empty() {
            Ok(())
        } else {
            let missing = waiting.len();
            Err(self
                .rig
                .silent(format!("{missing} of {count} messages {frame:?}")))
        }
    }

    /// Asks around a change that recurs with [`SLOW_PERIOD`]; no row without such a change.
    fn around(
        &mut self,
        asked: &Asked,
        row: &'static str,
        state: impl Fn(&Rig) -> u64,
    ) -> Result<(), CostError> {
        if self.next_change(&state, 1000).is_none() {
            return Ok(());
        }
        self.rig.run(us(SLOW_PERIOD - 3_000));
        if self.next_change(&state, STEP).is_none() {
            return Err(CostError::NeverHappened("the next change of heater or LED"));
        }
        let change = self.rig.bus().now().ticks();
        let mut trials = Vec::new();
        let (before, after) = AROUND;
        let phases = (0..before + after).step_by(STEP as usize);
        for (change, phase) in (change..).step_by(SLOW_PERIOD as usize).skip(1).zip(phases) {
            let begin = change + phase - before - asked.bits;
            let now = self.rig.bus().now().ticks();
            self.rig.run(us(begin - now));
            self.ask(asked, 1, TRAIN, false, &mut trials)?;
        }
        self.record(None, row, &trials);
        Ok(())
    }

    /// Runs in steps until the state changes, at most a second.
    fn next_change(&mut self, state: &impl Fn(&Rig) -> u64, step: u64) -> Option<()> {
        let before = state(&self.rig);
        (0..1_000_000 / step).find_map(|_| {
            self.rig.run(us(step));
            (state(&self.rig) != before).then_some(())
        })
    }

    /// Asks while saves program, and while a save has no erased page.
    pub(super) fn answers_while_saving(&mut self) -> Result<(), CostError> {
        let protocol = self.protocol;
        let sync = self.asked(protocol.sync, protocol.sync_code)?;
        self.save_until_erase()?;
        let between = self.save_until_erase()? - 1;
        let begin = self.rig.bus().now();
        self.rig.request(protocol.save)?;
        let duration = (picoseconds(self.rig.bus().now()) - picoseconds(begin)) / 1_000_000;
        let mut later = between - 1;
        let (mut saving, mut erasing) = (Vec::new(), Vec::new());
        let mut shifts = (0..TRAIN).step_by(STEP as usize);
        let mut erases = Erases::default();
        loop {
            for _ in 0..later {
                let Some(shift) = shifts.next() else {
                    self.rig.request(protocol.save)?;
                    continue;
                };
                self.begin_save(shift);
                let count = duration / TRAIN + 1;
                self.ask(&sync, count, TRAIN, false, &mut saving)?;
                self.rig.run(us(20 * ANSWER));
            }
            later = between;
            let before = self.rig.erased();
            let Some(phase) = erases.next() else { break };
            self.begin_save(phase);
            let mut one = Vec::new();
            self.ask(&sync, 1, ERASING + ANSWER, false, &mut one)?;
            if self.rig.erased() == before {
                return Err(CostError::NeverHappened("the erase of a page"));
            }
            erases.note(one.first().map_or(0, |trial| trial.time));
            erasing.extend(one);
        }
        self.record(None, "save_worst", &saving);
        self.record(None, "erase_worst", &erasing);
        Ok(())
    }

    /// The number of saves until one has erased a page, that one included.
    fn save_until_erase(&mut self) -> Result<u64, CostError> {
        let before = self.rig.erased();
        for count in 1..=super::SAVES as u64 {
            self.rig.request(self.protocol.save)?;
            if self.rig.erased() != before {
                return Ok(count);
            }
        }
        Err(CostError::NeverHappened("the erase of a page"))
    }

    /// Requests a save, and runs until this long after the end of the request, in us.
    fn begin_save(&mut self, later: u64) {
        let save = self.protocol.save;
        self.rig.run(us(10 * ANSWER));
        self.rig.send(save);
        self.rig
            .run(us(u64::from(frame_bits(&save.frame())) + 3 + later));
    }

    /// Asks after the boot-up messages.
    pub(super) fn answers_after_boot(&mut self) -> Result<(), CostError> {
        let protocol = self.protocol;
        let read = self.asked(protocol.starting, protocol.read_code)?;
        // This start erases a page ahead, and takes longer.
        self.rig.power_cycle();
        self.rig.run(us(SLOW_PERIOD));
        let mut left = self.busy_phases()?;
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
                self.rig.run(us(start + phase - read.bits - now));
                self.ask(&read, 1, TRAIN, true, &mut trials)?;
            }
            left = later;
        }
        self.record(None, "boot_worst", &trials);
        Ok(())
    }

    /// The phases after a start at which the processor executes, or will within [`AFTER`], in us after power-up. In its sleep all
    /// phases are equal, so the first of them stands for them.
    fn busy_phases(&mut self) -> Result<Vec<u64>, CostError> {
        self.rig.power_cycle();
        let start = self.rig.bus().now().ticks();
        let own = self.rig.source();
        self.rig.bus().take_log();
        let limit = start + SLOW_PERIOD;
        while !self
            .rig
            .bus()
            .take_log()
            .iter()
            .any(|one| one.source == own)
        {
            if self.rig.bus().now().ticks() > limit {
                return Err(CostError::NeverHappened("a boot-up message"));
            }
            self.rig.run(us(STEP));
        }
        self.rig.run(us(BOOT_UP));
        let first = self.rig.bus().now().ticks() - start;
        let phases = (0..BOOTING / STEP).map(|step| first + step * STEP);
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

    fn record(&mut self, median: Option<&'static str>, worst: &'static str, trials: &[Trial]) {
        let mut sorted = trials.to_vec();
        sorted.sort_by_key(|trial| trial.time);
        let Some(last) = sorted.last() else { return };
        let nanoseconds = |trial: &Trial| trial.time.div_ceil(1_000);
        self.figures.insert(worst, nanoseconds(last));
        let [before, after] = last.places.map(|place| self.rig.name_of(place));
        let phase = if before == after {
            before
        } else {
            format!("{before}, {after}")
        };
        self.phases.insert(worst, phase);
        if let Some(row) = median {
            self.figures
                .insert(row, nanoseconds(&sorted[sorted.len() / 2]));
        }
    }
}
