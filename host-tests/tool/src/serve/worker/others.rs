//! More sensors on the bus of the session, whose angles the chart shows beside those of its sensor. Commands do not reach them. They end with
//! the connection.

use super::action::Answers;
use super::{Live, State, Worker};
use crate::connect;
use crate::error::{Error, PageError, SensorError};
use crate::identify;
use crate::scan::Memory;
use crate::serve::events::Kind;
use crate::serve::job::{Chart, Connect, Other, Part};
use plumbline::time::Instant;
use serde_json::{Value, json};
use texts::Kind as Refusal;

/// The maximum number of sensors in the chart.
const MOST: usize = 4;

impl Worker {
    /// Adds a sensor to the chart, or removes it.
    pub(super) fn chart(&mut self, wanted: &Chart) -> Result<Value, Error> {
        match wanted {
            Chart::Add(other) => self.add(other)?,
            Chart::Remove(number) => self.others.retain(|own| own.connection != *number),
        }
        self.show_others();
        Ok(json!({}))
    }

    fn add(&mut self, other: &Other) -> Result<(), Error> {
        let (State::Active(live), Some((port, lease))) = (&self.state, self.port.clone()) else {
            return Err(PageError::NotConnected.into());
        };
        let is_shown = |live: &Live| {
            (live.found.protocol(), live.session.target.address())
                == (&other.protocol, other.address.clone())
        };
        if is_shown(live) || self.others.iter().any(is_shown) {
            return Err(PageError::AlreadyShown(other.address.clone()).into());
        }
        if self.others.len() + 1 >= MOST {
            return Err(PageError::TooManySensors(MOST).into());
        }
        let rate = live.session.link.rate();
        let wanted = Connect {
            port,
            rate,
            mode: Part::Active,
            protocol: Some(other.protocol.clone()),
            address: Some(other.address.clone()),
            product: other.product.clone(),
            yes: other.yes.clone(),
            names: Vec::new(),
        };
        let words = wanted.words(&self.sheets)?;
        let (bus, _) = wanted.wanted(&self.sheets, self.config.as_deref(), Memory::default())?;
        let shown = [words, vec!["watch".to_owned()]].concat();
        let answers = Answers::new(&wanted.yes, &[]);
        let added = self.action(&shown, &answers, |worker, terminal| {
            let opened = connect::session(Box::new(lease.clone()), &bus, terminal);
            let (session, found) = answers.instead(opened)?;
            worker.connection += 1;
            let number = worker.connection;
            let mut added = Live::new(session, (found, number), lease, worker.samples)?;
            if let State::Active(live) = &mut worker.state {
                added.join(live)?;
                live.go_on();
            }
            Ok(added)
        });
        self.others.push(added?);
        Ok(())
    }

    /// When the first of them is due.
    pub(super) fn others_due(&self) -> Option<Instant> {
        self.others.iter().map(Live::due).min()
    }

    /// Polls those that are due, and takes what they have sent.
    pub(super) fn turn_others(&mut self) -> Result<(), Error> {
        let mut exchanged = Vec::new();
        for other in &mut self.others {
            let was_silent = other.is_silent();
            let now = other.session.link.now();
            other.turn(&self.hub, Some(now))?;
            if was_silent && !other.is_silent() {
                match identify::is_same(&mut other.session, &other.found) {
                    Err(error) if error.kind() == Refusal::Bus => return Err(error),
                    Err(Error::Sensor(SensorError::Other(_))) => exchanged.push(other.connection),
                    _ => other.resume()?,
                }
            }
        }
        if !exchanged.is_empty() {
            self.others
                .retain(|own| !exchanged.contains(&own.connection));
            self.show_others();
        }
        Ok(())
    }

    /// Tells the tabs which sensors they are.
    pub(super) fn show_others(&self) {
        let devices = self.others.iter().map(|other| other.device(&self.sheets));
        self.hub
            .publish(Kind::Others, &devices.collect::<Vec<_>>().into());
    }
}
