//! `commission`: sensors as delivered, which have the same address, get the settings of a plan one after the other.
//!
//! A sensor is taken when it answers at the address as delivered: after it was switched on, or, after an interruption, at its new address
//! too. Its serial number selects it in the plan. The file with the state is written before the first write, and after the comparison.

mod fastscan;
pub mod plan;
pub mod state;

use super::adjust::{self, What};
use super::report::Report;
use super::{address, diff, restore};
use crate::error::{Differing, Error, SensorError, Silence};
use crate::identify::{self, Found};
use crate::labels::Labels;
use crate::link::Link;
use crate::master::{Target, factory_rate, factory_target};
use crate::note::Note;
use crate::output::Terminal;
use crate::session::Session;
use adapter::Mode;
use plan::{Find, Item, Plan};
use plumbline::can::BitRate;
use plumbline::time::{Duration, after, millis};
use serde::Serialize;
use state::{Row, State};

/// The time between two questions for the next sensor.
const PAUSE: Duration = millis(300);

/// The bit rate at which sensors that detect the bit rate are asked, without `--rate` and without a sensor that has one.
const DETECTED: BitRate = BitRate::K250;

/// The sensors of a plan.
#[derive(Clone, Debug, Serialize)]
pub struct Commissioned {
    /// Each sensor.
    pub sensors: Vec<Row>,
}

impl Commissioned {
    /// For people.
    pub fn lines(&self) -> Vec<String> {
        self.sensors.iter().map(Row::line).collect()
    }
}

/// What a user selects.
#[derive(Clone, Copy, Debug)]
pub struct Wish {
    /// The bit rate of the sensors as delivered; None: that of their product, or of the others on the bus.
    pub rate: Option<BitRate>,
    /// How long the tool waits for the next sensor.
    pub wait: Duration,
}

/// Commissions all sensors of the plan that are not done yet.
pub(crate) fn commission(
    link: Link,
    (plan, state): (&Plan, &mut State),
    wish: Wish,
    labels: &mut Labels,
    terminal: &mut Terminal,
) -> Result<Commissioned, Error> {
    let mut link = link;
    let is_done = |state: &State, item: &Item| state.row(&item.name).is_some_and(|row| row.done);
    while let Some(first) = plan.sensors.iter().find(|item| !is_done(state, item)) {
        let product = first.product();
        let waiting: Vec<&Item> = plan
            .sensors
            .iter()
            .filter(|item| !is_done(state, item) && item.is_found_as(first))
            .collect();
        let rate = wish.rate.or(factory_rate(product)).or(plan.rate());
        link.open(Some(rate.unwrap_or(DETECTED)), Mode::Active)?;
        let (item, found) = match first.find {
            Find::PowerUp => {
                terminal.note(&Note::SwitchOn(first.name.clone(), product.name));
                next(&mut link, &waiting, state, wish.wait, terminal)?
            }
            Find::Fastscan => {
                terminal.note(&Note::Scans(product.name));
                fastscan::next(&mut link, plan, &waiting, state, wish.wait)?
            }
        };
        let mut session = Session::new(link, found.target, item.product());
        let result = one(&mut session, item, found, (state, labels), terminal);
        for note in session.notes.drain(..) {
            terminal.note(&note);
        }
        if result.is_err() {
            session.link.end();
        }
        let released = session.release();
        let row = result?;
        released?;
        terminal.note(&Note::Commissioned(row.line()));
        let target = session.target;
        link = session.link;
        let is_last = plan.sensors.iter().all(|item| is_done(state, item));
        if plan.alone && !is_last {
            terminal.note(&Note::SwitchOff(row.name.clone()));
            gone(&mut link, target, row.name, wish.wait)?;
        }
    }
    link.close();
    let rows = plan.sensors.iter();
    let rows = rows.filter_map(|item| state.row(&item.name).cloned());
    Ok(Commissioned {
        sensors: rows.collect(),
    })
}

/// Waits for a sensor of the plan.
fn next<'a>(
    link: &mut Link,
    waiting: &[&'a Item],
    state: &State,
    wait: Duration,
    terminal: &mut Terminal,
) -> Result<(&'a Item, Found), Error> {
    let [first, ..] = waiting else {
        return Err(Silence::Request.into());
    };
    let product = first.product();
    let delivered = link.rate();
    let target = factory_target(product);
    let mut places: Vec<(Option<BitRate>, Target)> =
        target.map(|own| (delivered, own)).into_iter().collect();
    // One whose commissioning was interrupted can have its new address and its new bit rate.
    for item in waiting
        .iter()
        .filter(|item| state.row(&item.name).is_some())
    {
        let Some(own) = item.target() else {
            continue;
        };
        for rate in [delivered, item.rate().or(delivered)] {
            let is_own = |(other, at): &(_, Target)| *other == rate && at.is_at(own);
            if !places.iter().any(is_own) {
                places.push((rate, own));
            }
        }
    }
    let until = after(link.now(), wait);
    loop {
        for (rate, target) in &places {
            at(link, *rate)?;
            let Some(found) = identify::ask_all(link, *target, identify::PATIENT)? else {
                continue;
            };
            if !found.twins.is_empty() {
                let all = found.serial.iter().chain(&found.twins);
                let all: Vec<String> = all.map(u32::to_string).collect();
                return Err(SensorError::Together(target.named(), all.join(" and ")).into());
            }
            if state.is_done(&found) {
                continue;
            }
            let is_own = |item: &&Item| found.products.iter().any(|own| item.is_of(own));
            let own: Vec<&Item> = waiting.iter().copied().filter(is_own).collect();
            if let Some(item) = chosen(&own, state, found.serial) {
                return Ok((item, found));
            }
            let sensor = found.line(link.rate());
            return Err(SensorError::NotInPlan(sensor).into());
        }
        if link.now() >= until {
            let seconds = wait.ticks() / 1_000_000;
            return Err(Silence::Next(first.name.clone(), seconds).into());
        }
        terminal.hide();
        link.wait_for(PAUSE, |_| None::<()>)?;
    }
}

/// Opens the adapter at this bit rate, unless it has it already.
fn at(link: &mut Link, rate: Option<BitRate>) -> Result<(), Error> {
    match link.rate() == rate {
        true => Ok(()),
        false => link.open(rate, Mode::Active),
    }
}

/// The sensor of the plan that has this serial number, or takes any.
fn chosen<'a>(waiting: &[&'a Item], state: &State, serial: Option<u32>) -> Option<&'a Item> {
    let begun = |item: &&&Item| {
        let row = state.row(&item.name);
        row.is_some_and(|row| row.serial.is_some() && row.serial == serial)
    };
    let own = |item: &&&Item| item.serial.is_some() && item.serial == serial;
    let any = |item: &&&Item| item.serial.is_none() && state.row(&item.name).is_none();
    // One that has begun, but whose sensor was exchanged since.
    let other = |item: &&&Item| item.serial.is_none();
    let mut ways: [&dyn Fn(&&&Item) -> bool; 4] = [&begun, &own, &any, &other];
    let found = ways
        .iter_mut()
        .find_map(|way| waiting.iter().find(|item| way(item)));
    found.copied()
}

/// Gives one sensor its name and settings, restarts it, and compares.
fn one(
    session: &mut Session,
    item: &Item,
    mut found: Found,
    (state, labels): (&mut State, &mut Labels),
    terminal: &mut Terminal,
) -> Result<Row, Error> {
    let mut row = Row {
        firmware: found.firmware.clone(),
        ..Row::begun(item, found.serial, found.target)
    };
    if item.zero {
        // Before the first change, so that a no changes nothing.
        adjust::confirm(session, &found, What::Zero.change(), terminal)?;
    }
    state.keep(row.clone())?;
    match labels.set(&found, Some(&item.name)) {
        Ok(()) => found.label = Some(item.name.clone()),
        Err(failure) => terminal.note(&Note::NotLabelled(failure)),
    }
    let mut settings = item.settings.clone();
    settings.serial = found.serial;
    restore::restore(
        session,
        &found,
        (settings.clone(), item.name.clone()),
        &[],
        terminal,
    )?;
    found.target = session.target;
    if item.zero {
        let chosen = adjust::chosen(session, What::Zero, None)?;
        let report = adjust::write(session, What::Zero, &chosen, true, terminal)?;
        if let Report::Adjusted(adjusted) = report {
            let angles = adjusted.angles.0.into_iter();
            row.zero = angles
                .map(|own| format!("{} {}", own.name, own.text))
                .collect();
        }
    }
    let rate = item.rate().or(session.link.rate());
    session.restart()?;
    at(&mut session.link, rate)?;
    let target = item.target().unwrap_or(session.target);
    address::arrive(session, target)?;
    found.target = target;
    identify::is_same(session, &found)?;
    match diff::compare(session, settings)? {
        0 => {}
        count => return Err(SensorError::NotKept(item.name.clone(), Differing::of(count)).into()),
    }
    row.address = target.named();
    row.rate = rate.map(|rate| rate.name().to_owned());
    row.done = true;
    state.keep(row.clone())?;
    Ok(row)
}

/// Waits until a sensor is switched off.
fn gone(link: &mut Link, target: Target, name: String, wait: Duration) -> Result<(), Error> {
    let until = after(link.now(), wait);
    let mut silent = 0;
    while silent < 3 {
        if link.now() >= until {
            return Err(SensorError::StillOn(name, wait.ticks() / 1_000_000).into());
        }
        silent = match identify::ask(link, target, identify::PATIENT)? {
            Some(_) => 0,
            None => silent + 1,
        };
        link.wait_for(PAUSE, |_| None::<()>)?;
    }
    Ok(())
}
