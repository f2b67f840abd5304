//! The angles that the sensor sends by itself.

use super::Live;
use crate::cyclic::Message;
use crate::error::Error;
use crate::sample::{Sample, Sampler};
use crate::serve::events::Hub;
use plumbline::time::{Duration, Instant, after, millis};
use texts::Kind as Refusal;

/// The permitted delay of a message that the sensor sends by itself.
const LATE: Duration = millis(10);

/// The maximum number of frames that are received before a poll.
const MOST: usize = 1000;

impl Live {
    /// Takes the angles that the sensor sends by itself, as it is set now.
    pub(super) fn follow(&mut self) -> Result<(), Error> {
        self.pace.restart();
        let source = match &self.sampler {
            Some(sampler) => {
                let target = self.session.target;
                target.source(&mut self.session, sampler)
            }
            None => Ok(None),
        };
        let source = match source {
            Err(failure) if failure.kind() == Refusal::Bus => return Err(failure),
            source => source.ok().flatten(),
        };
        let others = source.as_ref().and_then(|source| source.others.clone());
        self.sent = match others {
            Some(angles) => Some(Sampler::of(&mut self.session, angles)?),
            None => None,
        };
        self.lease
            .with_tap(|tap| tap.follow(self.connection, source));
        Ok(())
    }

    /// The period with which the sensor sends its angles by itself; None: it does not, or without a period.
    pub fn sends_every(&self) -> Option<Duration> {
        let now = self.session.link.now();
        self.pace.period().filter(|_| !self.pace.has_ended(now))
    }

    /// Receives what has come until now.
    pub(super) fn drain(&mut self, now: Instant) -> Result<(), Error> {
        for _ in 0..MOST {
            if self.session.link.receive(now)?.is_none() {
                break;
            }
        }
        Ok(())
    }

    /// Takes the messages that the sensor has sent by itself. A poll is due only if they come less often than the user wants samples.
    pub(super) fn hear(&mut self, hub: &Hub) {
        let messages = self.lease.with_tap(|tap| tap.messages(self.connection));
        let Some(period) = self.period else {
            return;
        };
        for message in messages {
            self.pace.take(&message);
            let pause = period.ticks() + (period.ticks() / 2).max(LATE.ticks());
            self.next = self
                .next
                .max(after(message.at, Duration::from_ticks(pause)));
            self.streak = 0;
            self.take_message(message, hub);
        }
    }

    fn take_message(&mut self, message: Message, hub: &Hub) {
        let Some(sampler) = self.sent.as_mut().or(self.sampler.as_mut()) else {
            return;
        };
        let time = message.at.ticks().saturating_sub(self.origin.ticks());
        let sample = Sample {
            time: Duration::from_ticks(time),
            numbers: sampler.taken(message.numbers),
            status: message.status,
        };
        let document = sampler.json(&self.session, &sample);
        self.show(&sample, &document, hub);
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.lease.with_tap(|tap| tap.follow(self.connection, None));
    }
}
