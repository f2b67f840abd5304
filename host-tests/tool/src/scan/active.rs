//! The third part of a scan: asks, one question at a time, only after a yes.
//!
//! The questions are reads. To read from a DeviceNet node its connection is allocated and released, and LSS fastscan switches a node
//! without node-ID to configuration mode and back.

use super::listen::Frames;
use super::passive::is_used;
use super::row::{By, Heard, Row, Rows};
use crate::error::Error;
use crate::identify;
use crate::link::Link;
use crate::master::factory_targets;
use crate::master::fsc::boot_up::boot_up;
use crate::master::fsc::request::{self as fsc, Sensor};
use crate::master::{PROTOCOLS, Target};
use crate::note::{At, Note, Step};
use crate::output::{Progress, Terminal};
use plumbline::can::{BitRate, CanId, Frame};
use plumbline::time::{Duration, millis};

/// The wait for an answer in a search of all identifiers, in addition to the time on the bus.
const SEARCH: Duration = millis(20);

/// The bits of a question and an answer of the search.
const SEARCH_BITS: u32 = 150;

/// What a bootloader is called in documents.
const BOOTLOADER: &str = "bootloader";

/// The identifiers of the search between two updates of the progress.
const STEP: u16 = 32;

/// How many identifiers before an answer are asked again: the answer can be late.
const LATE: u16 = 3;

/// How long an adapter may take in a pass over the addresses as delivered, and what the user reads meanwhile.
type Pass = (Duration, fn(At) -> Step);

const PASSES: [Pass; 2] = [
    (identify::QUICK, Step::Delivered),
    (millis(60), Step::DeliveredAgain),
];

/// What is known before the questions.
pub struct Questions<'a> {
    /// The frames that were heard.
    pub frames: &'a Frames,
    /// The protocol of the bus, if it is known. The others are not asked.
    pub protocol: Option<&'static str>,
    /// Ask at all identifiers of 11 bits.
    pub search: bool,
}

impl Questions<'_> {
    /// Asks at these rates until somebody answers at one of them.
    ///
    /// # Errors
    /// The adapter fails, or the user presses Ctrl-C.
    pub(super) fn ask(
        &self,
        link: &mut Link,
        rates: &[Option<BitRate>],
        rows: &mut Rows,
        terminal: &mut Terminal,
    ) -> Result<(), Error> {
        let total = PASSES.len() * rates.len();
        for (pass, (latency, step)) in (0..).zip(PASSES) {
            for (place, rate) in (0..).zip(rates) {
                say(
                    terminal,
                    &step(At::from(*rate)),
                    (pass * rates.len() + place, total),
                );
                if !link.try_rate(*rate, rates)? {
                    continue;
                }
                let before = rows.answers();
                for target in factory_targets() {
                    self.one(link, target, latency, rows, terminal)?;
                }
                self.booted(link, rows, terminal)?;
                if rows.answers() > before {
                    return self.everywhere(link, rows, terminal);
                }
                if pass > 0 && self.bootloaders(link, rows, terminal)? {
                    return Ok(());
                }
                link.close();
            }
        }
        for (place, rate) in (0..).zip(rates) {
            say(
                terminal,
                &Step::Everybody(At::from(*rate)),
                (place, rates.len()),
            );
            if !link.try_rate(*rate, rates)? {
                continue;
            }
            let before = rows.answers();
            for target in factory_targets() {
                self.one(link, target, fsc::ANSWER, rows, terminal)?;
            }
            self.everywhere(link, rows, terminal)?;
            if rows.answers() > before {
                return Ok(());
            }
            link.close();
        }
        Ok(())
    }

    /// Whether the bus can have this protocol.
    pub fn permits(&self, protocol: &str) -> bool {
        self.protocol.is_none_or(|own| own == protocol)
    }

    /// Whether a question to an address cannot be a command to another device, as far as the frames show.
    pub fn permit(&self, target: Target) -> bool {
        self.permits(target.protocol().name) && !is_used(target, self.frames)
    }

    /// Asks at an address, unless it has answered already.
    fn one(
        &self,
        link: &mut Link,
        target: Target,
        latency: Duration,
        rows: &mut Rows,
        terminal: &mut Terminal,
    ) -> Result<(), Error> {
        if self.permit(target)
            && !rows.has_answered(target)
            && let Some(found) = identify::ask_all(link, target, latency)?
        {
            rows.add(link.rate(), Row::Found(found), terminal)?;
        }
        Ok(())
    }

    /// The bootloaders of sensors that do not speak CANopen, at the addresses as delivered only: their requests have eight bytes, which can
    /// be a command to another device. Returns whether there is one.
    fn bootloaders(
        &self,
        link: &mut Link,
        rows: &mut Rows,
        terminal: &mut Terminal,
    ) -> Result<bool, Error> {
        let mut is_one = false;
        for target in factory_targets() {
            let time = identify::question(link, identify::QUICK);
            if self.permit(target) && target.waits(link, time)? {
                is_one = true;
                let row = Row::Heard(Heard {
                    protocol: target.protocol().name,
                    address: Some(target.address()),
                    serial: None,
                    text: Some(BOOTLOADER.to_owned()),
                    by: By::Bootloader,
                });
                rows.add(link.rate(), row, terminal)?;
            }
        }
        Ok(is_one)
    }

    /// All node-IDs and MAC IDs, a node without address, and the nodes that tell their addresses.
    fn everybody(
        &self,
        link: &mut Link,
        rows: &mut Rows,
        terminal: &mut Terminal,
    ) -> Result<(), Error> {
        let everybody = Step::Everybody(link.rate().into());
        let (mut done, total) = (0, searched());
        for protocol in PROTOCOLS {
            for target in protocol.searched() {
                let progress = Progress {
                    done,
                    total,
                    step: &everybody,
                };
                terminal.progress(progress, None);
                done += 1;
                self.one(link, target, identify::QUICK, rows, terminal)?;
            }
            if !self.permits(protocol.name) {
                continue;
            }
            if let Some(find) = protocol.unaddressed
                && let Some(heard) = find(link, self.frames)?
            {
                rows.add(link.rate(), Row::Heard(heard), terminal)?;
            }
            let nodes = protocol.announced_nodes.map(|find| find(link));
            for target in nodes.transpose()?.into_iter().flatten() {
                self.one(link, target, identify::PATIENT, rows, terminal)?;
            }
        }
        self.booted(link, rows, terminal)
    }

    /// The sensors that have detected the bit rate since the last call, independent of the question.
    fn booted(
        &self,
        link: &mut Link,
        rows: &mut Rows,
        terminal: &mut Terminal,
    ) -> Result<(), Error> {
        for target in link.take_booted()? {
            for _ in 0..3 {
                self.one(link, target, fsc::ANSWER, rows, terminal)?;
            }
        }
        Ok(())
    }

    /// All addresses, and all identifiers, if the user wants it, independent of the protocol of the bus. The adapter and the computer add
    /// their time to each request.
    fn everywhere(
        &self,
        link: &mut Link,
        rows: &mut Rows,
        terminal: &mut Terminal,
    ) -> Result<(), Error> {
        if !self.search {
            return self.everybody(link, rows, terminal);
        }
        let nodes = searched() as u64;
        let time = nodes * identify::question(link, identify::QUICK).to_micros() + searching(link);
        terminal.note(&Note::SearchTakes(time / 1_000_000));
        self.everybody(link, rows, terminal)?;
        self.identifiers(link, rows, terminal)
    }

    /// All identifiers of 11 bits: the request for the status has no effect. Identifiers of network management are left out.
    fn identifiers(
        &self,
        link: &mut Link,
        rows: &mut Rows,
        terminal: &mut Terminal,
    ) -> Result<(), Error> {
        const STATUS: u8 = 0x02;
        let wait = search_wait(link);
        let seconds = searching(link) / 1_000_000;
        let (last, step) = (0x7FF, Step::Identifiers(seconds, link.rate().into()));
        for id in 1..=last {
            let progress = Progress {
                done: id.into(),
                total: last.into(),
                step: &step,
            };
            let line = (id == 1).then_some(&step);
            if id % STEP == 1 {
                terminal.progress(progress, line);
            }
            let request = CanId::standard(id);
            let sensor = |request| Sensor {
                request,
                reply: None,
            };
            let is_managing = |id: u16| matches!(id, 0x000 | 0x080 | 0x100 | 0x7E4 | 0x7E5);
            if is_managing(id) || is_used(Target::Fsc(sensor(request)), self.frames) {
                continue;
            }
            let question = Frame::of(request, [STATUS, 0, 0, 0, 0, 0, 0, 0], 1);
            let judge = |frame: &Frame| {
                let is_reply = matches!(frame.bytes(), [STATUS, _]) && frame.can_id() != request;
                (is_reply || boot_up(frame).is_some()).then_some(())
            };
            if link.ask(&question, wait, judge)?.is_none() {
                continue;
            }
            for late in (id.saturating_sub(LATE)..=id).rev() {
                if !is_managing(late) {
                    let target = Target::Fsc(sensor(CanId::standard(late)));
                    self.one(link, target, identify::PATIENT, rows, terminal)?;
                }
            }
            self.booted(link, rows, terminal)?;
        }
        Ok(())
    }
}

/// The number of all node-IDs and MAC IDs.
fn searched() -> usize {
    let all = PROTOCOLS.iter().map(|protocol| protocol.searched().len());
    all.sum()
}

/// The wait for an answer in a search of all identifiers.
fn search_wait(link: &Link) -> Duration {
    let bits = link.rate().map_or(250_000, BitRate::bits_per_second);
    SEARCH + Duration::micros((SEARCH_BITS * 1_000_000 / bits).into())
}

/// The time of a search of all identifiers, in us.
fn searching(link: &Link) -> u64 {
    2048 * search_wait(link).to_micros()
}

fn say(terminal: &mut Terminal, step: &Step, (done, total): (usize, usize)) {
    terminal.progress(Progress { done, total, step }, Some(step));
}
