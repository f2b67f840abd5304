//! Loads another program into the sensor of the session, or into one that waits in its bootloader.

use super::Worker;
use super::action::Answers;
use crate::error::{Asks, Error, FileError, PageError, SensorError};
use crate::identify;
use crate::image::ImageFile;
use crate::link::Link;
use crate::ops::update::{self, Updated, Waiting};
use crate::output::Terminal;
use crate::serve::job::{Connect, Update};
use crate::serve::line::{self, Words};
use crate::session::Session;
use adapter::Mode;
use serde_json::{Value, json};

impl Worker {
    /// Loads the program. A question without a yes goes back to the page.
    pub(super) fn update(&mut self, wanted: &Update) -> Result<Value, Error> {
        // The file is checked before the sensor is asked.
        let image = wanted.parse()?;
        let answers = Answers::new(&wanted.yes, &[]);
        let done = match &wanted.waiting {
            None => self.update_running(wanted, &image, &answers),
            Some(place) => self.update_waiting(wanted, place, &image, &answers),
        }?;
        Ok(json!(done))
    }

    fn update_running(
        &mut self,
        wanted: &Update,
        image: &ImageFile,
        answers: &Answers,
    ) -> Result<Updated, Error> {
        let own = self.sheet.as_ref().map(|kept| kept.key.as_str());
        let kept = wanted.backup.as_deref();
        let kept = kept.map(|text| self.sheets.backup(text, own)).transpose();
        let mut kept = kept.map_err(FileError::Fault)?;
        let result = self.on_sensor(words(wanted), answers, |live, terminal| {
            let (session, found) = (&mut live.session, &live.found);
            let target = session.target;
            if !target.is_bootloader(&mut session.link)? {
                identify::same(session, found)?;
            }
            let mut keep = |_: &mut Session, _: &mut Terminal| {
                let file = format!("{}.toml", image.product());
                Ok(kept.take().map(|backup| (backup, file)))
            };
            let done = update::update(session, image, false, &mut keep, terminal);
            asked(done, answers)
        });
        match &result {
            Ok(Updated { loaded: true, .. }) => {
                // The sensor runs, which is told, also if it cannot be shown.
                let _ = self.again();
            }
            result => self.follow(result)?,
        }
        result
    }

    fn update_waiting(
        &mut self,
        wanted: &Update,
        place: &Connect,
        image: &ImageFile,
        answers: &Answers,
    ) -> Result<Updated, Error> {
        let (bus, _) = place.wanted(&self.sheets, self.config.as_deref(), Default::default())?;
        let waiting = Waiting::of(image, bus.target);
        let waiting = waiting.ok_or_else(|| PageError::NotInCatalogue(image.product()))?;
        let shown = [place.words(&self.sheets)?, words(wanted)].concat();
        self.error = None;
        self.close()?;
        let done = self.action(&shown, answers, |worker, terminal| {
            let lease = worker.lease(&place.port)?;
            let mut link = Link::new(Box::new(lease.clone()), &terminal.stopped);
            link.open(place.rate, Mode::Active)?;
            let mut session = Session::new(link, waiting.target, waiting.product);
            let done = update::go_on(&mut session, waiting.via, image, false, terminal);
            session.link.end();
            let released = session.release();
            lease.end();
            let done = asked(done, answers)?;
            released.map(|()| done)
        })?;
        let target = waiting.target;
        let there = Connect {
            protocol: Some(target.protocol().name.to_owned()),
            address: Some(target.address()),
            ..place.clone()
        };
        // The sensor runs, which is told, also if it cannot be shown.
        let _ = self.connect(&there);
        Ok(done)
    }
}

/// The words of the command. The page has read the settings before.
fn words(wanted: &Update) -> Words {
    let mut words = ["update", "--no-backup"].map(str::to_owned).to_vec();
    line::positional(&mut words, std::slice::from_ref(&wanted.name));
    words
}

/// The question instead of the failure that follows from it.
fn asked<T>(done: Result<T, Error>, answers: &Answers) -> Result<T, Error> {
    match (done, answers.asked()) {
        (Err(Error::Sensor(SensorError::ImageOlder(_))), asked) if !asked.is_empty() => {
            Err(Asks(asked).into())
        }
        (done, _) => done,
    }
}
