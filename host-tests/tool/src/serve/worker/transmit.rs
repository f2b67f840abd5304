//! Starts and stops the frames of the transmit list and of a log.

use super::action::Answers;
use super::{State, Worker};
use crate::cli::frames::speed;
use crate::counted::Lines;
use crate::decode::log::each_of;
use crate::error::{Error, Fault, FileError, PageError};
use crate::note::Note;
use crate::ops::replay::{Recording, Replay};
use crate::ops::transmit;
use crate::serve::events::Kind;
use crate::serve::lease::Lease;
use crate::serve::line::{self, Words};
use crate::serve::transmission::{Log, Transmit, item};
use adapter::{Adapter, AdapterError};
use serde_json::{Value, json};
use texts::Text;

impl Worker {
    /// Changes what is sent.
    pub(super) fn transmit(&mut self, wanted: Transmit) -> Result<Value, Error> {
        let result = match wanted {
            Transmit::Add { frame, every } => {
                let item = item(&frame, every)?;
                self.transmission.borrow_mut().add(&[item])
            }
            Transmit::Open { text, name } => {
                let items = transmit::items(&text);
                let items = items.map_err(|why| FileError::List(name, Fault::from(why)))?;
                self.transmission.borrow_mut().add(&items)
            }
            Transmit::Start(number) => self.start(number),
            Transmit::Stop(number) => {
                let mut transmission = self.transmission.borrow_mut();
                transmission.line(number).map(|line| line.next = None)
            }
            Transmit::Remove(number) => {
                self.transmission.borrow_mut().list.remove(number);
                Ok(())
            }
            Transmit::Replay(log) => self.replay(&log),
            Transmit::StopReplay => {
                self.transmission.borrow_mut().stop_replay();
                Ok(())
            }
        };
        self.show_transmission();
        result.map(|()| json!({}))
    }

    /// Publishes what is sent, if it has changed.
    pub(super) fn show_transmission(&mut self) {
        let shown = self.transmission.borrow().json();
        if shown != self.status.transmission {
            self.hub.publish(Kind::Transmission, &shown);
            self.status.transmission = shown;
        }
    }

    /// A frame that the adapter has refused stops what is sent, and is told; the connection goes on.
    pub(super) fn go_on_sending(&mut self, result: Result<(), Error>) -> Result<(), Error> {
        match result {
            Err(Error::Adapter(
                refused @ (AdapterError::FrameRefused(_) | AdapterError::QueueFull),
            )) => {
                self.transmission.borrow_mut().stop();
                self.error = Some(refused.texts());
                self.report();
                Ok(())
            }
            result => result,
        }
    }

    /// The adapter, if it can send, with the command that would send the same.
    fn sending(&self) -> Result<(Lease, Words), Error> {
        let link = match &self.state {
            State::Active(live) => &live.session.link,
            State::Open(link) => link,
            State::Closed | State::Listening(_) => return Err(PageError::SendsNothing.into()),
        };
        let (port, lease) = self.port.as_ref().ok_or(PageError::SendsNothing)?;
        Ok((lease.clone(), line::bus(port, link.rate())))
    }

    fn start(&mut self, number: u64) -> Result<(), Error> {
        let (lease, mut words) = self.sending()?;
        self.error = None;
        let item = self.transmission.borrow_mut().line(number)?.item;
        words.extend(["send".to_owned(), format!("{:?}", item.frame)]);
        if let Some(every) = item.every {
            words.extend(["--every".to_owned(), every.to_string()]);
        }
        self.action(&words, &Answers::default(), |worker, _| {
            let mut transmission = worker.transmission.borrow_mut();
            transmission.line(number)?.next = Some(lease.now());
            Ok(())
        })
    }

    fn replay(&mut self, log: &Log) -> Result<(), Error> {
        let (lease, mut words) = self.sending()?;
        self.error = None;
        let factor = log.speed.to_string();
        speed(&factor).map_err(|_| PageError::Speed)?;
        words.extend(["replay".to_owned(), "--speed".to_owned(), factor]);
        if log.repeats {
            words.push("--loop".to_owned());
        }
        if let Some(interface) = &log.interface {
            words.push(format!("--interface={interface}"));
        }
        line::positional(&mut words, std::slice::from_ref(&log.name));
        self.action(&words, &Answers::default(), |worker, terminal| {
            let mut recording = Recording::default();
            let mut text = log.text.as_bytes();
            let others = each_of(&mut text, &log.name, terminal, &mut |_, line| {
                let wanted = log.interface.as_ref();
                if wanted.is_none_or(|name| *name == line.interface) {
                    recording.take(line);
                }
                Ok(())
            })?;
            if others > 0 {
                terminal.note(&Note::OtherLines(Lines(others)));
            }
            let round = recording.finish(log.name.clone())?;
            let total = round.count();
            let frames = Replay::new(round, log.speed, log.repeats, lease.now());
            let mut transmission = worker.transmission.borrow_mut();
            transmission.replay(log.name.clone(), total, frames);
            Ok(())
        })
    }
}
