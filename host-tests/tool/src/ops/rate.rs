//! `rate`: another bit rate. The order is: check the adapter and the product, ask, write, store, restart, and ask the sensor at the new
//! rate.

use super::report::Done;
use super::{Report, adjust, set};
use crate::error::{Error, RequestError, SensorError, Silence, Why};
use crate::identify::{self, Found};
use crate::master::Target;
use crate::master::{Codes, Storing};
use crate::meaning::{Named, german};
use crate::output::Terminal;
use crate::question::Change;
use crate::scan::kbits;
use crate::session::Session;
use crate::sheet::Entry;
use adapter::Mode;
use plumbline::can::BitRate;
use plumbline::param::ParameterId;
use plumbline::time::{Duration, after, millis};
use std::fmt::{self, Display, Formatter};
use texts::Text;

/// The time in which a DeviceNet sensor has stored a change by itself.
const STORING: Duration = millis(1500);

/// The longest time until a sensor has restarted, with the duplicate MAC ID check of DeviceNet.
const RESTART: Duration = millis(4000);

/// The time in which the request to restart leaves the adapter. The adapter must not be at the old rate any more when the sensor sends
/// its first message at the new one: its error frames can bring the sensor to bus-off.
pub(super) const SOON: Duration = millis(4);

/// The name of the value of a bit rate that the sensor detects.
const AUTOMATIC: &str = "automatic detection";

/// A bit rate for a sensor.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum NewRate {
    /// The sensor detects the bit rate of the bus.
    Automatic,
    /// This one.
    Fixed(BitRate),
}

impl NewRate {
    /// The rate; None: automatic detection.
    pub fn fixed(self) -> Option<BitRate> {
        Option::from(self)
    }

    /// As the command line takes it.
    pub fn word(self) -> String {
        let rate = self.fixed().map(kbits);
        rate.map_or("auto".to_owned(), |rate| rate.to_string())
    }
}

impl From<Option<BitRate>> for NewRate {
    fn from(rate: Option<BitRate>) -> Self {
        rate.map_or(Self::Automatic, Self::Fixed)
    }
}

impl From<NewRate> for Option<BitRate> {
    fn from(rate: NewRate) -> Self {
        match rate {
            NewRate::Automatic => None,
            NewRate::Fixed(rate) => Some(rate),
        }
    }
}

impl Display for NewRate {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.fixed().map_or(AUTOMATIC, BitRate::name))
    }
}

impl Text for NewRate {
    fn german(&self) -> String {
        let rate = self.fixed().map(BitRate::name);
        rate.unwrap_or_else(|| german(AUTOMATIC)).replace('.', ",")
    }
}

/// One of the ten bit rates, in kbit/s, or `auto`.
pub(crate) fn new_rate(text: &str) -> Result<NewRate, String> {
    match text {
        "auto" => Ok(NewRate::Automatic),
        _ => bench::bit_rate(text).map(NewRate::Fixed),
    }
}

pub(super) fn rate(
    session: &mut Session,
    found: &Found,
    new: NewRate,
    terminal: &mut Terminal,
) -> Result<Report, Error> {
    let (entry, raw) = code(session, new)?;
    let old = session.link.rate();
    if session.read(&entry)? == raw && (new == NewRate::Automatic || old == new.fixed()) {
        return Ok(Done::RateAlready(new).into());
    }
    reachable(session, new)?;
    adjust::confirm(session, found, Change::Rate(new), terminal)?;
    let target = next_target(session)?;
    store(session, &entry, new, raw)?;
    session.restart()?;
    session.link.leave_within(SOON);
    // With automatic detection the sensor takes the rate of the bus.
    if let Some(rate) = new.fixed()
        && let Err(failure) = session.link.open(Some(rate), Mode::Active)
    {
        // The rate of an interface is not changed by this program. The message says what to type.
        terminal.note(&failure);
        return Ok(Done::RestartsWith(new).into());
    }
    match answers(session, target, found)? {
        true => {
            session.moved(target);
            Ok(Done::Rate(new).into())
        }
        false => {
            session.link.open(old, Mode::Active)?;
            // It has its old address too. The questions at the wrong rate disturb it for a while.
            let is_at_old = answers(session, session.target, found)?;
            Err(match (is_at_old, old) {
                (true, Some(old)) => SensorError::NotRestarted(new, old.name()).into(),
                _ => Silence::Rate(new).into(),
            })
        }
    }
}

/// The parameter of the bit rate, and its raw numbers.
fn codes(session: &Session) -> Result<(ParameterId, Codes), Error> {
    let rate = session.roles().and_then(|roles| roles.rate);
    Ok(rate.ok_or(RequestError::NoRateParameter)?)
}

/// The parameter of the bit rate, and its raw number for a rate.
fn code(session: &Session, new: NewRate) -> Result<(Entry, u32), Error> {
    let product = session.sheet.product;
    let wanted = new.fixed();
    let (id, mut rates) = codes(session)?;
    let entry = session.entry(id)?;
    // A product does not need to have all rates of its protocol.
    rates.retain(|(raw, _)| entry.check(*raw, &entry.scale).is_ok());
    let found = rates.iter().find(|(_, rate)| *rate == wanted);
    found.map(|(raw, _)| (entry, *raw)).ok_or_else(|| {
        let names = Named::of(|language| {
            let names = rates.iter();
            let names = names.map(|(_, rate)| rate.map_or(language(AUTOMATIC), BitRate::name));
            names.collect::<Vec<_>>().join(", ")
        });
        RequestError::NoSuchRate(product.name, new, names).into()
    })
}

/// Refuses a rate that the adapter does not have: the sensor could not be reached any more. The adapter only listens meanwhile.
fn reachable(session: &mut Session, new: NewRate) -> Result<(), Error> {
    let sets_rate = session.link.adapter().capabilities().sets_rate;
    let (Some(rate), true) = (new.fixed(), sets_rate) else {
        return Ok(());
    };
    let old = session.link.rate();
    let opened = session.link.open(Some(rate), Mode::Listen);
    session.link.open(old, Mode::Active)?;
    match opened {
        Err(failure) if failure.is_rate_refused() => Err(failure.explained(Why::NotChanged)),
        // An adapter without listen-only mode is not tried.
        _ => Ok(()),
    }
}

/// The bit rate after the restart: a changed one acts then. With automatic detection it is that of the bus.
pub(crate) fn next_rate(session: &mut Session) -> Result<Option<BitRate>, Error> {
    let (id, rates) = codes(session)?;
    let entry = session.entry(id)?;
    let raw = session.read(&entry)?;
    let next = rates.iter().find(|(code, _)| *code == raw);
    Ok(next.and_then(|(_, rate)| *rate).or(session.link.rate()))
}

/// The address after the restart: a changed one acts then too.
pub(crate) fn next_target(session: &mut Session) -> Result<Target, Error> {
    let Some(roles) = session.roles() else {
        return Ok(session.target);
    };
    let entry = session.entry(roles.address)?;
    (roles.target)(session.read(&entry)?)
}

/// Writes the rate and stores it: by LSS where the product has it, which stores nothing else.
fn store(session: &mut Session, entry: &Entry, new: NewRate, raw: u32) -> Result<(), Error> {
    let target = session.target;
    if let Some(rate) = new.fixed()
        && target.store_rate(session, rate)?
    {
        return set::read_back(session, &vec![(entry.clone(), raw)]);
    }
    set::write(session, &vec![(entry.clone(), raw)])?;
    if session.storing() == Storing::Command {
        session.save()?;
    } else {
        session.link.wait_for(STORING, |_| None::<()>)?;
    }
    Ok(())
}

/// Waits until the sensor answers after its restart.
pub(super) fn answers(session: &mut Session, target: Target, found: &Found) -> Result<bool, Error> {
    let until = after(session.link.now(), RESTART);
    loop {
        let answer = identify::ask(&mut session.link, target, identify::PATIENT)?;
        if answer.is_some_and(|answer| answer.serial == found.serial) {
            return Ok(true);
        }
        if session.link.now() >= until {
            return Ok(false);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rate_that_the_sensor_detects_has_a_german_name() {
        for (rate, english, german) in [
            (None, "automatic detection", "automatische Erkennung"),
            (Some(BitRate::K62_5), "62.5 kbit/s", "62,5 kbit/s"),
        ] {
            let rate = NewRate::from(rate);
            assert_eq!([rate.to_string(), Text::german(&rate)], [english, german]);
        }
    }
}
