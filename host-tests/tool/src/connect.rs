//! From the options of the command line to a session with one sensor: bit rate, address, product.

mod product;
mod wanted;

pub use wanted::Wanted;

use crate::eds;
use crate::error::{Error, Place, Rates, RequestError, Silence};
use crate::identify::{self, Found};
use crate::link::Link;
use crate::master::{PROTOCOLS, Protocol, Target, factory_target, factory_targets};
use crate::note::Note;
use crate::output::Terminal;
use crate::question::Question;
use crate::scan::listen::{self, Traffic};
use crate::scan::passive;
use crate::scan::schedule::Schedule;
use crate::scan::{Memory, Questions};
use crate::session::Session;
use crate::sheet::Sheet;
use adapter::Adapter;
use plumbline::can::BitRate;
use plumbline::model::catalog::Product;
use plumbline::time::{Duration, after, millis};

/// The order in which unknown rates are tried: the common ones first.
pub const RATES: [BitRate; 10] = [
    BitRate::K250,
    BitRate::K125,
    BitRate::K500,
    BitRate::M1,
    BitRate::K100,
    BitRate::K50,
    BitRate::K20,
    BitRate::K800,
    BitRate::K62_5,
    BitRate::K10,
];

/// How long a sensor that must be there is asked: a sensor that has just been switched on makes its duplicate MAC ID check first.
const PATIENCE: Duration = millis(3000);

/// Opens the adapter and finds the sensor; it is asked only with reads.
///
/// Without a rate or an address, the tool listens first. On a bus with traffic it asks at the rate of the traffic, and at the addresses
/// of the nodes that it has heard. On a bus without traffic it asks at the addresses as delivered; at all rates only after a yes.
///
/// # Errors
/// Nobody answers, several sensors do, a question was answered with no, or the adapter fails.
pub fn find(
    adapter: Box<dyn Adapter>,
    wanted: &Wanted,
    terminal: &mut Terminal,
) -> Result<(Link, Found), Error> {
    let mut link = Link::new(adapter, &terminal.stopped);
    let (rates, heard) = listened(&mut link, wanted, terminal)?;
    let frames = heard.as_ref().map_or(&[][..], |heard| &heard.frames);
    let owned = named(wanted).filter(|_| wanted.listens);
    if let Some(found) = owned.and_then(|target| target.owned(frames)) {
        listen::open(&mut link, rates.first().copied().flatten(), terminal)?;
        terminal.note(&Note::Here(found.line(link.rate())));
        return Ok((link, found));
    }
    let sightings = passive::sightings(frames);
    let mut targets: Vec<Target> = match wanted.target {
        Some(target) => vec![target],
        None => sightings
            .iter()
            .filter(|sighting| sighting.is_sure)
            .filter_map(|sighting| sighting.target)
            .filter(|target| is_of(*target, wanted.product))
            .collect(),
    };
    let mut found = Vec::new();
    if !targets.is_empty() {
        let is_known = rates.len() == 1;
        found = asked(&mut link, &rates, &targets, is_known, wanted)?;
    }
    // A foreign node has told its identity, but it is not a sensor that the tool looks for.
    let is_ours = |found: &Found| wanted.product.is_some() || !found.products.is_empty();
    if wanted.target.is_none() && !found.iter().any(is_ours) {
        let questions = Questions {
            frames,
            protocol: passive::protocol(&sightings),
            search: false,
        };
        let mut delivered = match wanted.product {
            Some(product) => factory_target(product).into_iter().collect(),
            None => factory_targets(),
        };
        // The user can name a product whose protocol differs from the protocol of the bus.
        let is_named =
            |target: Target| wanted.product.is_some() && !passive::is_used(target, frames);
        delivered.retain(|target| {
            (questions.permit(*target) || is_named(*target)) && !targets.contains(target)
        });
        let is_of_bus = delivered.iter().all(|target| questions.permit(*target));
        // A product is no yes to a bus whose protocol is not known.
        let is_known = wanted.product.is_some() && questions.protocol.is_some();
        let may = heard.is_none() || (is_known && is_of_bus);
        if targets.is_empty() && delivered.is_empty() {
            return Err(RequestError::NotAsked.into());
        }
        if !delivered.is_empty() && !may && !terminal.ask(&Question::Delivered)? {
            return Err(RequestError::NotRecognised.into());
        }
        found.extend(asked(&mut link, &rates, &delivered, false, wanted)?);
        if found.is_empty() {
            found = told(&mut link, &rates, wanted, &questions)?;
        }
        targets.extend(delivered);
    }
    if found.iter().any(is_ours) {
        found.retain(is_ours);
    }
    match &found[..] {
        [Found { twins, .. }] if !twins.is_empty() => Err(found[0].twins().into()),
        [only] => {
            let only = only.clone();
            terminal.note(&Note::Here(only.line(link.rate())));
            Ok((link, only))
        }
        [] => Err(silent(&targets, &rates)),
        several => {
            let lines: Vec<String> = several
                .iter()
                .map(|found| found.line(link.rate()))
                .collect();
            Err(RequestError::SeveralSensors(lines.join("; ")).into())
        }
    }
}

/// The sensor that the user has named by its address, or by a product that has its address as delivered.
fn named(wanted: &Wanted) -> Option<Target> {
    wanted.target.or_else(|| factory_target(wanted.product?))
}

/// The bit rates that the sensor can have, and the traffic that was heard at these rates.
fn listened(
    link: &mut Link,
    wanted: &Wanted,
    terminal: &mut Terminal,
) -> Result<(Vec<Option<BitRate>>, Option<Traffic>), Error> {
    let needs_rate = link.adapter().capabilities().needs_rate;
    if wanted.is_remembered && needs_rate {
        return heard_again(link, wanted, terminal);
    }
    if wanted.rate.is_some() || !needs_rate {
        let may_be_owned =
            wanted.listens && named(wanted).is_some_and(|target| target.can_be_owned());
        let heard = match wanted.target {
            Some(_) if !may_be_owned => None,
            _ => listen::once(link, wanted.rate, terminal)?,
        };
        return Ok((vec![wanted.rate], heard));
    }
    if let Some(heard) = remembered(link, &wanted.memory, terminal)? {
        return Ok((vec![heard.rate], Some(heard)));
    }
    if !terminal.ask(&Question::AllRates)? {
        return Err(RequestError::NoRate.into());
    }
    Ok((RATES.iter().copied().map(Some).collect(), None))
}

/// The same with the bit rate of the last command. A request at a wrong bit rate destroys frames, so it is only used if there is traffic at this
/// bit rate, or none at all.
fn heard_again(
    link: &mut Link,
    wanted: &Wanted,
    terminal: &mut Terminal,
) -> Result<(Vec<Option<BitRate>>, Option<Traffic>), Error> {
    let heard = match listen::once(link, wanted.rate, terminal)? {
        None => remembered(link, &wanted.memory, terminal)?,
        heard => heard,
    };
    let rate = heard.as_ref().map_or(wanted.rate, |heard| heard.rate);
    Ok((vec![rate], heard))
}

/// What is heard at the rate of the traffic; the tool only listens, for 12 s and the time to open the adapter at most.
///
/// # Errors
/// The adapter has no listen-only mode, or has failed.
pub fn traffic(link: &mut Link, terminal: &mut Terminal) -> Result<Option<Traffic>, Error> {
    remembered(link, &Memory::default(), terminal)
}

/// The same, if something was heard before.
fn remembered(
    link: &mut Link,
    memory: &Memory,
    terminal: &mut Terminal,
) -> Result<Option<Traffic>, Error> {
    terminal.note(&Note::Listens);
    let schedule = Schedule::of(&RATES.map(Some), false);
    match memory.listen(link, &schedule, terminal) {
        Err(failure) if failure.lacks_listen_only() => Err(RequestError::ListenRate.into()),
        heard => heard,
    }
}

/// The nodes that answer at these addresses, at the first rate at which a node answers. Sensors at an address that was heard or given are
/// asked for [`PATIENCE`] if their rate is known.
fn asked(
    link: &mut Link,
    rates: &[Option<BitRate>],
    targets: &[Target],
    is_expected: bool,
    wanted: &Wanted,
) -> Result<Vec<Found>, Error> {
    let latency = match is_expected {
        true => identify::PATIENT,
        false => identify::QUICK,
    };
    let mut found: Vec<Found> = Vec::new();
    for rate in rates {
        if !link.try_rate(*rate, rates)? {
            continue;
        }
        let until = after(link.now(), if is_expected { PATIENCE } else { millis(0) });
        loop {
            for target in targets {
                // A sensor that detects the bit rate needs a frame before it answers.
                for _ in 0..2 {
                    let answer = identify::ask_all(link, *target, latency)?;
                    if answer.is_some() {
                        add(&mut found, answer, wanted);
                        break;
                    }
                }
            }
            for target in link.take_booted()? {
                if !is_wanted(target, wanted) {
                    continue;
                }
                let answer = identify::ask_all(link, target, identify::PATIENT)?;
                add(&mut found, answer, wanted);
            }
            if !found.is_empty() || link.now() >= until {
                break;
            }
        }
        if !found.is_empty() {
            break;
        }
        link.close();
    }
    Ok(found)
}

/// The nodes that tell their addresses, at the first rate at which one does.
fn told(
    link: &mut Link,
    rates: &[Option<BitRate>],
    wanted: &Wanted,
    questions: &Questions,
) -> Result<Vec<Found>, Error> {
    let is_of = |own: &Protocol| wanted.product.is_none_or(|product| own.is_of(product));
    let mut found = Vec::new();
    for protocol in PROTOCOLS {
        let Some(find) = protocol.announced_nodes else {
            continue;
        };
        if !is_of(protocol) || !questions.permits(protocol.name) {
            continue;
        }
        for rate in rates {
            if !link.try_rate(*rate, rates)? {
                continue;
            }
            for target in find(link)? {
                let answer = identify::ask_all(link, target, identify::PATIENT)?;
                add(&mut found, answer, wanted);
            }
            if !found.is_empty() {
                return Ok(found);
            }
            link.close();
        }
    }
    Ok(found)
}

/// Adds a sensor that is wanted and not known yet. A boot-up message can come from another sensor.
fn add(found: &mut Vec<Found>, answer: Option<Found>, wanted: &Wanted) {
    let answer = answer.filter(|answer| is_wanted(answer.target, wanted));
    let is_same = |own: &Found, other: &Found| own.target.address() == other.target.address();
    if let Some(mut answer) = answer
        && !found.iter().any(|own| is_same(own, &answer))
    {
        answer.label = wanted.labels.name(&answer);
        found.push(answer);
    }
}

pub(crate) fn silent(targets: &[Target], rates: &[Option<BitRate>]) -> Error {
    let addresses: Vec<String> = targets.iter().map(|target| target.named()).collect();
    let rates = match rates[..] {
        [Some(rate)] => Rates::One(rate.name()),
        [None] => Rates::Own,
        _ => Rates::Any,
    };
    let at = match addresses[..] {
        [] => Place::Nowhere,
        _ => Place::At(addresses.join(", ")),
    };
    Silence::Nobody(at, rates).into()
}

/// Whether a sensor is the one of the user. A boot-up message can come from another sensor.
fn is_wanted(target: Target, wanted: &Wanted) -> bool {
    match wanted.target {
        Some(wanted) => target.is_at(wanted),
        None => is_of(target, wanted.product),
    }
}

/// Whether a product has the protocol of an address.
fn is_of(target: Target, product: Option<&'static Product>) -> bool {
    product.is_none_or(|product| target.protocol().is_of(product))
}

/// A session with the sensor.
///
/// # Errors
/// Nobody answers, the product is not known, or the adapter fails.
pub fn session(
    adapter: Box<dyn Adapter>,
    wanted: &Wanted,
    terminal: &mut Terminal,
) -> Result<(Session, Found), Error> {
    let (mut link, found) = find(adapter, wanted, terminal)?;
    let product = match product::decide(&found, wanted, terminal) {
        Err(failure) => {
            link.adapter().close();
            return Err(failure);
        }
        Ok(product) => product,
    };
    let sheet = match &wanted.sheet {
        Some(sheet) => sheet.clone(),
        None => Sheet::of(product),
    };
    let mut session = Session::with_sheet(link, found.target, sheet);
    session.only_listens = found.is_owned && wanted.listens;
    let checked = eds::check(&mut session, terminal);
    if checked.is_err() {
        session.link.end();
        session.release()?;
        session.link.adapter().close();
    }
    checked?;
    Ok((session, found))
}
