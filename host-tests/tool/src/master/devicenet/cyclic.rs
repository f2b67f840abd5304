//! The angles of a DeviceNet slave in its I/O messages.
//!
//! The tool allocates the poll connection, sets its time-out (expected packet rate), polls with the period, and releases it at the end.
//! If the tool is cut off, the slave releases it itself after four times this rate. A slave of another master is only listened to.
//!
//! ```text
//!  identifier          data
//!  405h + 8 x MAC ID   none                                                  poll command
//!  3C0h + MAC ID       the words of the assembly, low byte first             response to a poll
//!  340h + MAC ID       the same                                              change of state, cyclic
//! ```

use crate::cyclic::{LISTENS, Layout, Message, Started, Stream};
use crate::error::{Error, SensorError, What};
use crate::link::Link;
use crate::master::devicenet::explicit::{Path, Slave};
use crate::note::Note;
use crate::output::Terminal;
use crate::sample::Sampler;
use crate::session::Session;
use crate::sheet::Entry;
use plumbline::devicenet::{Assembly, service};
use plumbline::model::listing::devicenet::Tables;
use plumbline::time::{Duration, Instant, after, millis};
use texts::Kind;

/// The poll connection, and its attribute with the expected packet rate in ms.
const CONNECTION: Path = Path {
    class: 5,
    instance: 2,
};
const RATE: u8 = 9;

/// The least expected packet rate in ms: the connection lasts for four times as long without a poll.
const LEAST: u32 = 1000;

/// The maximum number of polls that wait for a response, and the maximum time of this wait: on a bus that is too slow, polls must not fill
/// a queue.
const WAITING: (usize, Duration) = (8, millis(50));

/// The I/O messages that are received.
pub(super) struct Io {
    slave: Slave,
    /// Each identifier with the same data.
    layouts: Vec<Layout>,
    polls: Option<Polls>,
}

/// The polls of the tool.
struct Polls {
    every: Duration,
    next: Instant,
    /// The polls whose time has come, also those for which the computer was late.
    count: u64,
    /// The time of the last poll.
    last: Instant,
    /// The polls without a response.
    waiting: usize,
}

/// Lets a slave send the angles, or listens to one of another master. The period is None if it is not known.
pub(super) fn start(
    session: &mut Session,
    (slave, tables): (Slave, &Tables),
    sampler: &mut Sampler,
    every: u32,
    terminal: &mut Terminal,
) -> Result<Started, Error> {
    if session.only_listens {
        return listened(session, (slave, tables), sampler, terminal);
    }
    let entry = session.entry(tables.roles.polled_assembly)?;
    let instance = session.read(&entry)?;
    let mut assemblies = tables.assemblies.iter();
    let assembly = assemblies.find(|own| u32::from(own.instance) == instance);
    let layout = assembly.map(|own| taken(session, slave, own, sampler));
    let Some(layout) = layout.transpose()?.flatten() else {
        let (name, text) = (&entry.name, entry.text(instance));
        return Err(SensorError::NoAngle(name.clone(), text).into());
    };
    let mut io = Io {
        slave,
        layouts: vec![layout],
        polls: Some(Polls {
            every: millis(every),
            next: session.link.now(),
            count: 0,
            last: session.link.now(),
            waiting: 0,
        }),
    };
    if let Err(failure) = io.connect(session, every) {
        // The cause is the first failure. An adapter that is lost cannot release; the slave does it itself.
        let _ = io.stop(session);
        return Err(failure);
    }
    Ok(Started::now(io, Some(millis(every))))
}

/// The places of the angles in an assembly. The sampler keeps the angles that are in the assembly; None: the assembly has no angle.
fn taken(
    session: &mut Session,
    slave: Slave,
    assembly: &Assembly,
    sampler: &mut Sampler,
) -> Result<Option<Layout>, Error> {
    let place = |entry: &Entry| {
        let mut words = assembly.words.iter();
        words.position(|id| {
            session
                .sheet
                .value(*id)
                .is_some_and(|own| own.name == entry.name)
        })
    };
    let angles = sampler.entries();
    let found = angles
        .into_iter()
        .filter_map(|entry| Some((place(&entry)?, entry)));
    let (words, entries): (Vec<usize>, Vec<Entry>) = found.unzip();
    if entries.is_empty() {
        return Ok(None);
    }
    let types = entries.iter().map(|entry| entry.data_type);
    let places = words.iter().map(|word| 16 * *word as u32);
    let layout = Layout {
        id: slave.poll_response(),
        size: assembly.size().into(),
        places: places.zip(types).collect(),
    };
    sampler.take(session, entries)?;
    Ok(Some(layout))
}

/// Listens to a slave of another master. Its messages do not say which assembly they are: the first one of their size is taken.
fn listened(
    session: &mut Session,
    (slave, tables): (Slave, &Tables),
    sampler: &mut Sampler,
    terminal: &mut Terminal,
) -> Result<Started, Error> {
    let (longest, _) = LISTENS;
    let size = session.link.wait_for(longest, |frame| {
        let is_io = slave.io().contains(&frame.can_id()) && !frame.is_remote();
        is_io.then(|| frame.bytes().len()).filter(|size| *size > 0)
    })?;
    let Some(size) = size else {
        let mac = slave.mac;
        return Err(SensorError::OwnedSilent(mac).into());
    };
    let mut assemblies = tables.assemblies.iter();
    let assembly = assemblies.find(|own| usize::from(own.size()) == size);
    let layout = assembly.map(|own| taken(session, slave, own, sampler));
    let Some(layout) = layout.transpose()?.flatten() else {
        return Err(SensorError::IoSize(size.into()).into());
    };
    let layouts = slave.io().map(|id| Layout {
        id,
        ..layout.clone()
    });
    let io = Io {
        slave,
        layouts: layouts.to_vec(),
        polls: None,
    };
    let every = Layout::period(&io.layouts, &mut session.link)?;
    let names: Vec<String> = sampler.entries().into_iter().map(|own| own.name).collect();
    terminal.note(&Note::OwnedByOther(every.into(), names.join(" and ")));
    Ok(Started::now(io, every))
}

impl Io {
    /// Allocates the poll connection and sets its time-out.
    fn connect(&mut self, session: &mut Session, every: u32) -> Result<(), Error> {
        let slave = self.slave;
        if let Err(failure) = slave.allocate_poll(&mut session.link) {
            // Without an answer it can be allocated.
            if !matches!(failure.kind(), Kind::Silent | Kind::Bus) {
                self.polls = None;
            }
            return Err(failure);
        }
        let rate = (every.max(LEAST) as u16).to_le_bytes();
        let data = [RATE, rate[0], rate[1]];
        let response = slave.request_in(session, service::SET, CONNECTION, &data)?;
        response.must(slave.mac, What::PacketRate)?;
        if let Some(polls) = &mut self.polls {
            polls.next = session.link.now();
        }
        Ok(())
    }

    /// The next angles until then, with the time of their reception. Polls when it is time.
    fn receive(
        &mut self,
        link: &mut Link,
        until: Instant,
    ) -> Result<Option<(Instant, Vec<i64>)>, Error> {
        loop {
            let now = link.now();
            let mut step = until;
            if let Some(polls) = &mut self.polls {
                if now >= polls.next && now < until {
                    // The tool skips the polls for which the computer or the bus is late.
                    let every = polls.every.ticks().max(1);
                    let passed = (now.ticks() - polls.next.ticks()) / every + 1;
                    polls.next = Instant::from_ticks(polls.next.ticks() + passed * every);
                    polls.count += passed;
                    let (most, time) = WAITING;
                    if now >= after(polls.last, time) {
                        polls.waiting = 0;
                    }
                    if polls.waiting < most {
                        polls.last = now;
                        polls.waiting += 1;
                        self.slave.poll(link)?;
                    }
                }
                // The loop sends no poll after `until`, so it does not wait for the next one.
                if now < until {
                    step = step.min(polls.next);
                }
            }
            let time = Duration::from_ticks(step.ticks().saturating_sub(now.ticks()));
            let message = Layout::next(&self.layouts, link, time)?;
            if let (Some(polls), Some(_)) = (&mut self.polls, &message) {
                polls.waiting = polls.waiting.saturating_sub(1);
            }
            if message.is_some() || step >= until {
                return Ok(message);
            }
        }
    }
}

impl Stream for Io {
    fn stop(&mut self, session: &mut Session) -> Result<(), Error> {
        match self.polls.take() {
            Some(_) => self.slave.release_poll(&mut session.link),
            None => Ok(()),
        }
    }

    fn polled(&self, now: Instant) -> Option<u64> {
        let polls = self.polls.as_ref()?;
        let passed = now.ticks().saturating_sub(polls.last.ticks());
        let is_waiting = polls.waiting > 0 && passed < polls.every.ticks();
        Some(polls.count - u64::from(is_waiting))
    }

    fn next(
        &mut self,
        session: &mut Session,
        _sampler: &Sampler,
        _wanted: &[(Entry, u32)],
        time: Duration,
    ) -> Result<Option<Message>, Error> {
        let until = after(session.link.now(), time);
        let message = self.receive(&mut session.link, until)?;
        Ok(message.map(Message::plain))
    }

    fn left(&self) -> Note {
        Note::NotReleased
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::tests::{Scripted, link};

    #[test]
    fn wait_for_polls_ends_if_the_computer_is_late() {
        for late in [1, 999, 30_000, 100_000] {
            let adapter = Scripted::default();
            adapter.0.borrow_mut().late = late;
            let mut link = link(&adapter);
            let (slave, start) = (Slave { mac: 63 }, link.now());
            let polls = Polls {
                every: millis(20),
                next: start,
                count: 0,
                last: start,
                waiting: 0,
            };
            let mut io = Io {
                slave,
                layouts: Vec::new(),
                polls: Some(polls),
            };
            let mut slices = 0;
            while link.now() < after(start, millis(1000)) {
                let until = after(link.now(), millis(50));
                assert_eq!(io.receive(&mut link, until).unwrap(), None);
                slices += 1;
            }
            assert!(slices <= 20, "{late}: {slices}");
        }
    }
}
