//! `commission`: the plan, the state beside it, and the report.

use super::bus::Bus;
use super::{distinct, replaced};
use crate::backup::write_file;
use crate::error::Error;
use crate::labels::Labels;
use crate::link::Link;
use crate::note::Note;
use crate::ops::Report;
use crate::ops::commission::plan::Plan;
use crate::ops::commission::state::State;
use crate::ops::commission::{Wish, commission};
use crate::output::Terminal;
use plumbline::time::Duration;
use std::path::Path;

/// Commissions the sensors of a plan. Nothing is sent before the whole plan is valid.
pub(super) fn run(
    plan: &Path,
    report: Option<&Path>,
    wait: u32,
    bus: &mut Bus,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let rate = bus.options.rate.filter(|_| bus.is_rate_given);
    let content = Plan::read(plan, rate)?;
    let mut state = State::beside(plan, &content)?;
    let mut labels = Labels::open(bus.options.config.as_deref())?;
    if let Some(report) = report {
        distinct(&[plan, state.path(), report])?;
        replaced(report, terminal)?;
    }
    let wish = Wish {
        rate,
        wait: Duration::from_ticks(u64::from(wait) * 1_000_000),
    };
    let link = Link::new(bus.adapter()?, &terminal.stopped);
    let done = commission(link, (&content, &mut state), wish, &mut labels, terminal);
    let done = match done {
        Ok(done) => done,
        Err(failure) => {
            if !state.rows.is_empty() {
                terminal.note(&Note::GoesOn(state.path().display().to_string()));
            }
            return Err(failure);
        }
    };
    let text: String = done
        .lines()
        .iter()
        .map(|line| format!("{line}\n"))
        .collect();
    terminal.report(&Report::Commissioned(done))?;
    match report {
        Some(report) => write_file(report, &text).map_err(Error::after_document),
        None => Ok(()),
    }
}
