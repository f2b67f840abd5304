//! Which sensor the worker has: a command of a page that shows another sensor is refused, and the worker connects again to a sensor that
//! has another address.

use super::{State, Worker};
use crate::error::{Error, PageError};
use crate::identify::Found;
use crate::question::Question;
use crate::scan::Memory;
use crate::serve::job::Connect;
use crate::serve::line::Words;
use std::rc::Rc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

impl Worker {
    /// Refuses a command for another sensor than the one that is connected.
    pub(super) fn check(&self, sensor: Option<u64>) -> Result<(), Error> {
        match &self.state {
            State::Active(live) if sensor != Some(live.connection) => {
                let line = live.found.line(live.session.link.rate());
                Err(PageError::SensorChanged(line).into())
            }
            _ => Ok(()),
        }
    }

    /// The number of a sensor. It is the number of the last sensor if it is certain that both are the same sensor.
    pub(super) fn number(&mut self, found: &Found) -> u64 {
        let identity = found.identity();
        match &self.last {
            Some((last, number)) if identity.is_unique() && *last == identity => *number,
            _ => {
                self.connection += 1;
                self.unsaved.clear();
                self.last = Some((identity, self.connection));
                self.connection
            }
        }
    }

    /// Connects again where the sensor is now, or where another one is.
    pub(super) fn again(&mut self) -> Result<(), Error> {
        let (State::Active(live), Some((port, _)), Some(given)) =
            (&self.state, &self.port, &self.given)
        else {
            return Ok(());
        };
        let target = live.session.target;
        let own = live.session.sheet.product.name;
        let is_told = live.found.product().is_some_and(|told| told.name == own);
        let product = match &self.sheet {
            Some(kept) => Some(kept.key.clone()),
            None => (!is_told).then(|| own.to_owned()),
        };
        // The same question about the same sensor is not asked again.
        let wanted = Connect {
            port: port.clone(),
            rate: live.session.link.rate(),
            protocol: Some(target.protocol().name.to_owned()),
            address: Some(target.address()),
            product,
            ..given.clone()
        };
        self.connect(&wanted).map(|_| ())
    }

    /// True while the running job is to be stopped. The last requests of a command, which release the sensor, are sent nevertheless.
    pub(super) fn stopped(&self) -> Rc<dyn Fn() -> bool> {
        let stop = self.stop.clone();
        Rc::new(move || stop.load(Ordering::Relaxed))
    }
}

/// How long what was heard before a question counts after it.
const RECENT: Duration = Duration::from_secs(120);

/// A request that has ended with a question, and what was heard before.
pub(super) struct Asked {
    words: Words,
    questions: Vec<Question>,
    since: Instant,
    /// What the scan has heard.
    pub(super) memory: Memory,
}

impl Worker {
    /// What was heard before the question that this request answers with yes; nothing for another request, or too late.
    pub(super) fn asked(&mut self, words: &Words, yes: &[Question]) -> Asked {
        let is_answer = |asked: &Asked| {
            let is_yes = asked.questions.iter().any(|own| yes.contains(own));
            asked.words == *words && is_yes && asked.since.elapsed() < RECENT
        };
        self.asked
            .take()
            .filter(is_answer)
            .unwrap_or_else(|| Asked {
                words: words.clone(),
                questions: Vec::new(),
                since: Instant::now(),
                memory: Memory::default(),
            })
    }

    /// Keeps what was heard until the user has answered one of these questions.
    pub(super) fn wait(&mut self, asked: Asked, questions: Vec<Question>) {
        self.asked = Some(Asked { questions, ..asked });
    }
}

/// A command of the page is not stopped by Ctrl-C.
pub(super) fn on_request(failure: Error) -> Error {
    match failure.is_stopped() {
        true => PageError::Stopped.into(),
        false => failure,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo;
    use crate::link::Link;
    use crate::serve::events::Hub;
    use crate::serve::lease::Lease;
    use adapter::{Adapter, Mode};
    use plumbline::can::{CanId, Frame};
    use plumbline::time::millis;
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;
    use std::sync::mpsc::channel;

    #[test]
    fn stop_while_the_last_frame_leaves_the_adapter_ends_the_command_but_not_its_last_requests() {
        let (stop, (_jobs, receiver)) = (Arc::new(AtomicBool::new(false)), channel());
        let opener = Box::new(|_: &str| -> Result<Box<dyn Adapter>, Error> {
            Err(crate::error::RequestError::NoAdapter.into())
        });
        let worker = Worker::new(receiver, Arc::new(Hub::default()), opener, stop.clone());
        let demo = demo::unpaced("is2").expect("a sensor");
        let mut link = Link::new(
            Box::new(Lease::new(Box::new(demo), Rc::default(), Box::new(|_| {}))),
            &worker.stopped(),
        );
        let request = Frame::of(CanId::standard(0x300), [0x02, 0, 0, 0, 0, 0, 0, 0], 1);
        link.open(None, Mode::Active).expect("it opens");
        link.send(&request).expect("it is sent");
        stop.store(true, Ordering::Relaxed);
        link.open(None, Mode::Active).expect("it opens");
        let ask = |link: &mut Link| link.ask(&request, millis(100), |_| Some(()));
        for _ in 0..2 {
            let failure = ask(&mut link)
                .map_err(on_request)
                .expect_err("it is stopped");
            assert_eq!(failure.code(), "stopped");
            assert!(failure.to_string().contains("by the user"), "{failure}");
        }
        link.end();
        assert_eq!(ask(&mut link), Ok(Some(())));
    }
}
