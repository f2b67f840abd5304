//! `load-factory`. A sensor that takes its factory values only at its next start is restarted, and stores them then: otherwise that start
//! would also replace settings that are written and stored before it.

use super::rate::answers;
use super::report::Done;
use super::{Report, address, adjust};
use crate::error::Error;
use crate::identify::Found;
use crate::master::{factory_rate, factory_target};
use crate::note::Note;
use crate::output::Terminal;
use crate::question::Change;
use crate::session::Session;
use adapter::Mode;

/// Loads the factory values after a yes.
pub(super) fn load(
    session: &mut Session,
    found: &Found,
    terminal: &mut Terminal,
) -> Result<Report, Error> {
    let product = session.sheet.product;
    let after_restart = session
        .loads_at_restart()
        .then(|| Some((factory_target(product)?, factory_rate(product)?)))
        .flatten();
    let change = match after_restart {
        Some((target, rate)) => Change::LoadFactoryAndRestart(target.named(), rate.name()),
        None => Change::LoadFactory,
    };
    adjust::confirm(session, found, change, terminal)?;
    if let Some((target, rate)) = after_restart
        && target != session.target
        && session.link.rate() == Some(rate)
    {
        address::free(session, target)?;
    }
    let done = session.load_factory()?;
    let Some((target, rate)) = after_restart else {
        return Ok(done.into());
    };
    session.restart()?;
    if session.link.rate() != Some(rate) {
        session.link.leave_within(super::rate::SOON);
        if let Err(failure) = session.link.open(Some(rate), Mode::Active) {
            // The rate of an interface is not changed by this program. The message says what to type.
            terminal.note(&failure);
            terminal.note(&Note::ThenSave);
            return Ok(Done::FactoryRestartsAt.into());
        }
    }
    if !answers(session, target, found)? {
        return Err(address::missing(target));
    }
    session.moved(target);
    session.save()?;
    Ok(Done::Factory(target.named(), rate.name()).into())
}
