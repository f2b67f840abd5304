//! How long an answer takes, at every phase of the message against the firmware's own work: samples and ticks, heater, LEDs ([`changes`]),
//! saves ([`saves`]) and boot ([`boot`]), in steps of 2 us. For the worst phase, the table has the functions that the processor executes
//! before the end of the message and after the receive interrupt: the answer waits for these.

mod boot;
mod changes;
mod saves;

use super::super::CostError;
use super::super::products::Message;
use super::Scenario;
use bench::Logged;
use can_wire::frame_length::frame_bits;
use can_wire::protocol::{Picoseconds, bit_time};
use plumbline::can::Frame;
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

/// A message whose answer is awaited.
struct Asked {
    message: Message,
    /// The duration of the message on the bus in us.
    time: u64,
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
            time: u64::from(frame_bits(&message.frame())) * bit_time(self.rig.bus().rate())
                / 1_000_000,
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
            places.push_back(self.send_one(asked, |scenario, time| scenario.rig.run(us(time))));
            self.rig.run(us(period - asked.time - AFTER));
        }
        self.collect(asked, places, joining, trials)
    }

    /// Sends a message, and returns the addresses that the processor executes before and after its end. `run` lets a time in us pass.
    fn send_one(&mut self, asked: &Asked, mut run: impl FnMut(&mut Self, u64)) -> [Option<u32>; 2] {
        self.rig.send(asked.message);
        // Before the receive interrupt, which comes a bit before the end of the frame.
        run(self, asked.time - 2);
        let before = self.rig.place();
        run(self, 2 + AFTER);
        [before, self.rig.place()]
    }

    /// Adds the times of the answers in the log to `trials`. `places` are the addresses that the processor executed at each message.
    fn collect(
        &mut self,
        asked: &Asked,
        mut places: VecDeque<[Option<u32>; 2]>,
        joining: bool,
        trials: &mut Vec<Trial>,
    ) -> Result<(), CostError> {
        let count = places.len();
        self.rig.run(us(ANSWER));
        let own = self.rig.source();
        let length: Picoseconds = asked.time * 1_000_000;
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
