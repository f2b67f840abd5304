//! The angles of a CANopen node in a TPDO.
//!
//! A TPDO with the angles that the node sends already is only listened to. Otherwise one is changed meanwhile: off, type 254, no inhibit
//! time, the event timer, on; a node that is not operational is started. What differed is put back at the end. A TPDO of an operational
//! node that is on, but does not come now, can be needed by other devices: it is changed only after a yes.

mod tpdo;

use crate::cyclic::{LISTENS, Layout, Message, SLICE, Source, Started, Stream};
use crate::error::{Error, RequestError, SensorError, What};
use crate::link::{Link, stopped};
use crate::master::canopen::nmt::{self, State};
use crate::master::canopen::sdo::{Answer, Server};
use crate::note::Note;
use crate::output::Terminal;
use crate::question::Question;
use crate::sample::Sampler;
use crate::session::Session;
use crate::sheet::{Address, Entry};
use plumbline::can::{CanId, Frame};
use plumbline::canopen::cob_id::DISABLED;
use plumbline::time::{Duration, after, millis};
use tpdo::{COB_ID, COMMUNICATION, EVENT, MAPPING, Tpdo, mapped, read};

/// The permitted delay of a TPDO.
const LATE: Duration = millis(100);

/// The objects that have the same angle with 16 bits and with 32 bits (CiA 410).
const WIDTHS: [[u16; 2]; 2] = [[0x6010, 0x6110], [0x6020, 0x6120]];

/// A TPDO with its values and their places.
struct Sent(Tpdo, Vec<Entry>, Layout);

/// The TPDO that is received.
pub(super) struct Pdo {
    node: u8,
    layout: Layout,
    before: Option<Before>,
}

/// The settings before, which are put back.
struct Before {
    tpdo: Tpdo,
    with_mapping: bool,
    /// The node was operational.
    was_operational: bool,
    /// The tool has started it.
    has_started: bool,
}

/// Lets a node send the angles. The period is None if it is not known.
pub(super) fn start(
    session: &mut Session,
    node: u8,
    sampler: &mut Sampler,
    every: u32,
    terminal: &mut Terminal,
) -> Result<Started, Error> {
    let mut tpdos = Vec::new();
    for number in numbers(session) {
        tpdos.extend(Tpdo::read(&mut session.link, node, number)?);
    }
    let sets = sets(session, sampler);
    let sent: Vec<Sent> = tpdos
        .iter()
        .filter_map(|tpdo| fitting(tpdo, &sets))
        .collect();
    let mut others = Vec::new();
    if let Some(own) = heard(&mut session.link, &sent, &mut others, terminal)? {
        return listened(session, node, sampler, own, terminal);
    }
    let Some(state) = nmt::state(&mut session.link, node)? else {
        return Err(SensorError::NoHeartbeat.into());
    };
    let was_operational = state == State::Operational;
    let (longest, _) = LISTENS;
    let is_slow = |Sent(tpdo, ..): &&Sent| tpdo.longest().is_some_and(|time| time + LATE > longest);
    if let Some(own) = sent.iter().find(is_slow).filter(|_| was_operational) {
        return listened(session, node, sampler, own, terminal);
    }
    let (before, wanted, set) = chosen(session, &tpdos, &sets, &others, every)?;
    if was_operational && before.is_on() {
        confirmed(before.number, terminal)?;
    }
    let layout = wanted.layout(&set).ok_or_else(not_mapped)?;
    sampler.take(session, set)?;
    let mut pdo = Pdo {
        node,
        layout,
        before: Some(Before {
            with_mapping: before.objects != wanted.objects,
            tpdo: before,
            was_operational,
            has_started: false,
        }),
    };
    if let Err(failure) = pdo.switch_on(session, wanted) {
        // The cause is the failure of the write.
        if pdo.stop(session).is_err() {
            session.note(Note::NotPutBack);
        }
        return Err(failure);
    }
    Ok(Started::now(pdo, Some(millis(every))))
}

/// A TPDO that is on, if it has all values of one of these sets.
fn fitting(tpdo: &Tpdo, sets: &[Vec<Entry>]) -> Option<Sent> {
    let mut sets = sets.iter().filter(|_| tpdo.is_on());
    sets.find_map(|set| Some(Sent(tpdo.clone(), set.clone(), tpdo.layout(set)?)))
}

/// The first TPDO that is on and has all angles.
pub(super) fn source(
    session: &mut Session,
    node: u8,
    sampler: &Sampler,
) -> Result<Option<Source>, Error> {
    let sets = sets(session, sampler);
    for number in numbers(session) {
        let tpdo = Tpdo::read_on(&mut session.link, node, number)?;
        if let Some(Sent(_, set, layout)) = tpdo.and_then(|tpdo| fitting(&tpdo, &sets)) {
            let own = sampler.entries().into_iter().map(|own| own.address);
            let is_own = own.eq(set.iter().map(|own| own.address));
            return Ok(Some(Source {
                message: Box::new(move |at, frame| {
                    let angles = layout.decode(frame);
                    angles.map(|angles| Message::plain((at, angles)))
                }),
                others: Some(set).filter(|_| !is_own),
            }));
        }
    }
    Ok(None)
}

/// A TPDO that the node sends already is only listened to.
fn listened(
    session: &mut Session,
    node: u8,
    sampler: &mut Sampler,
    Sent(tpdo, set, layout): &Sent,
    terminal: &mut Terminal,
) -> Result<Started, Error> {
    let every = match tpdo.period() {
        Some(every) => Some(every),
        None if tpdo.has_sync() => Layout::period(std::slice::from_ref(layout), &mut session.link)?,
        None => None,
    };
    terminal.note(&Note::SentAlready(tpdo.number + 1, every.into()));
    sampler.take(session, set.clone())?;
    let pdo = Pdo {
        node,
        layout: layout.clone(),
        before: None,
    };
    Ok(Started::now(pdo, every))
}

/// Asks whether a TPDO that is on can be changed.
fn confirmed(number: u16, terminal: &mut Terminal) -> Result<(), Error> {
    if terminal.ask(&Question::Tpdo(number + 1))? {
        return Ok(());
    }
    Err(RequestError::TpdoNotConfirmed.into())
}

/// The numbers of the TPDOs in the sheet, from 0.
fn numbers(session: &Session) -> Vec<u16> {
    let entries = session.sheet.entries.iter();
    let numbers = entries.filter_map(|entry| match entry.address {
        Address::Object {
            index: index @ 0x1800..=0x19FF,
            sub: COB_ID,
        } => Some(index - COMMUNICATION),
        _ => None,
    });
    numbers.collect()
}

/// The angles, then the same with another width.
fn sets(session: &Session, sampler: &Sampler) -> Vec<Vec<Entry>> {
    let angles = sampler.entries();
    let other = |entry: &Entry| {
        let Address::Object { index, sub: 0 } = entry.address else {
            return None;
        };
        let mut widths = WIDTHS.iter();
        let [short, long] = widths.find(|widths| widths.contains(&index))?;
        let index = if index == *short { *long } else { *short };
        let mut entries = session.sheet.entries.iter();
        let wanted = Address::Object { index, sub: 0 };
        entries.find(|entry| entry.address == wanted).cloned()
    };
    let others: Option<Vec<Entry>> = angles.iter().map(other).collect();
    [Some(angles), others].into_iter().flatten().collect()
}

/// The first TPDO that is received. A TPDO with a period longer than [`LISTENS`] is not received. `others` gets the identifiers of all
/// other frames that came.
fn heard<'a>(
    link: &mut Link,
    sent: &'a [Sent],
    others: &mut Vec<CanId>,
    terminal: &Terminal,
) -> Result<Option<&'a Sent>, Error> {
    let (longest, _) = LISTENS;
    let time = |Sent(tpdo, ..): &Sent| tpdo.longest().map_or(longest, |time| time + LATE);
    let time = sent.iter().map(time).max().unwrap_or(longest);
    let until = after(link.now(), time.min(longest));
    while link.now() < until {
        if (terminal.stopped)() {
            return Err(stopped());
        }
        let found = link.wait_for(SLICE, |frame: &Frame| {
            let mut sent = sent.iter();
            let found = sent.find(|Sent(.., layout)| layout.decode(frame).is_some());
            if found.is_none() && !others.contains(&frame.can_id()) {
                others.push(frame.can_id());
            }
            found
        })?;
        if found.is_some() {
            return Ok(found);
        }
    }
    Ok(None)
}

/// The TPDO that is changed, what it becomes, and its values. A TPDO that is off must have an identifier that nobody uses.
fn chosen(
    session: &Session,
    tpdos: &[Tpdo],
    sets: &[Vec<Entry>],
    others: &[CanId],
    every: u32,
) -> Result<(Tpdo, Tpdo, Vec<Entry>), Error> {
    let timed = |tpdo: &&Tpdo| tpdo.timer.is_some();
    let is_used = |id: CanId| {
        let mut on = tpdos.iter().filter(|tpdo| tpdo.is_on());
        others.contains(&id) || on.any(|tpdo| tpdo.id() == id)
    };
    let is_off = |tpdo: &&Tpdo| tpdo.is_free() && !is_used(tpdo.id());
    let changed = |tpdo: &Tpdo, objects: Vec<u32>| Tpdo {
        cob_id: tpdo.cob_id & !DISABLED,
        kind: EVENT[0],
        inhibit: tpdo.inhibit.map(|_| 0),
        timer: Some(every as u16),
        count: objects.len() as u8,
        objects,
        ..tpdo.clone()
    };
    for is_on in [true, false] {
        for set in sets {
            let mut fitting = tpdos.iter().filter(timed);
            let fits = |tpdo: &&Tpdo| {
                let is_wanted = if is_on { tpdo.is_on() } else { is_off(tpdo) };
                is_wanted && tpdo.layout(set).is_some()
            };
            if let Some(tpdo) = fitting.find(fits) {
                let wanted = changed(tpdo, tpdo.objects.clone());
                return Ok((tpdo.clone(), wanted, set.clone()));
            }
        }
    }
    // The angles are mapped into a TPDO that is off.
    let is_free = |tpdo: &&Tpdo| {
        let index = MAPPING + tpdo.number;
        let mut entries = session.sheet.entries.iter();
        let is_writable = entries
            .any(|entry| entry.writable && entry.address == Address::Object { index, sub: 0 });
        is_off(tpdo) && is_writable
    };
    let free = tpdos.iter().filter(timed).find(is_free);
    for set in sets {
        let objects: Option<Vec<u32>> = set.iter().map(mapped).collect();
        if let (Some(tpdo), Some(objects)) = (free, objects) {
            return Ok((tpdo.clone(), changed(tpdo, objects), set.clone()));
        }
    }
    Err(not_mapped())
}

fn not_mapped() -> Error {
    SensorError::NoTpdo.into()
}

impl Pdo {
    /// Changes the TPDO, and starts the node.
    fn switch_on(&mut self, session: &mut Session, wanted: Tpdo) -> Result<(), Error> {
        let Some(before) = &mut self.before else {
            return Ok(());
        };
        let server = Server::of(self.node);
        let link = &mut session.link;
        if before.with_mapping {
            // All entries that are overwritten, also the entries beyond the number of objects.
            let mapping = MAPPING + wanted.number;
            for sub in before.tpdo.objects.len() + 1..=wanted.objects.len() {
                let object = read(link, self.node, mapping, sub as u8)?;
                before.tpdo.objects.extend(object);
            }
        }
        for (index, sub, bytes) in wanted.writes(before.with_mapping) {
            let mut answer = server.write(link, index, sub, &bytes)?;
            if bytes == [EVENT[0]] && matches!(answer, Answer::Aborted(_)) {
                answer = server.write(link, index, sub, &[EVENT[1]])?;
            }
            answer.must(server, What::Angles)?;
        }
        if !before.was_operational {
            before.has_started = true;
            nmt::send(link, nmt::START, self.node)?;
        }
        Ok(())
    }
}

impl Stream for Pdo {
    /// Puts back what was before.
    fn stop(&mut self, session: &mut Session) -> Result<(), Error> {
        let Some(before) = self.before.take() else {
            return Ok(());
        };
        let link = &mut session.link;
        let was_ending = link.set_ending(true);
        let mut done = Ok(());
        if before.has_started {
            done = nmt::send(link, nmt::ENTER_PRE_OPERATIONAL, self.node);
        }
        let server = Server::of(self.node);
        for (index, sub, bytes) in before.tpdo.writes(before.with_mapping) {
            let written = server.put_back(link, (index, sub), &bytes);
            let written = written.and_then(|answer| answer.must(server, What::Settings));
            done = done.and(written);
        }
        link.set_ending(was_ending);
        done
    }

    fn next(
        &mut self,
        session: &mut Session,
        _sampler: &Sampler,
        _wanted: &[(Entry, u32)],
        time: Duration,
    ) -> Result<Option<Message>, Error> {
        let layouts = std::slice::from_ref(&self.layout);
        let message = Layout::next(layouts, &mut session.link, time)?;
        Ok(message.map(Message::plain))
    }
}
