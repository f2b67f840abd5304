//! Clients that control the sensors: JSON lines on TCP. `README.md` of this package describes them.

mod perform;
mod refused;
mod request;
mod unit;

pub(super) use perform::span;
pub use refused::Refused;
pub use request::{MemoryFault, Request, Side, Topic};
pub use unit::Unit;

use super::Server;
use super::event::{Client, ClientId};
use bench::{AdapterId, Logged, Source};
use serde_json::{Value, json};
use unit::{Event, seconds};

/// The longest request with its line end, in bytes.
const LINE_MAX: usize = 1 << 20;

/// A client that controls the sensors.
pub(super) struct Control {
    client: Client,
    /// The incomplete line.
    line: Vec<u8>,
    /// The line is longer than a request; the rest of it is ignored.
    too_long: bool,
    topics: Vec<Topic>,
    /// Its adapter, which is on the bus since the client sends frames or sees them.
    pub(super) adapter: Option<AdapterId>,
}

impl Control {
    pub(super) fn new(client: Client) -> Self {
        Self {
            client,
            line: Vec::new(),
            too_long: false,
            topics: Vec::new(),
            adapter: None,
        }
    }

    /// The next line of the input, without its end, which is taken from the input. Err: it is too long.
    fn next_line(&mut self, input: &mut &[u8]) -> Option<Result<Vec<u8>, ()>> {
        let end = input.iter().position(|byte| *byte == b'\n');
        let (piece, rest) = input.split_at(end.map_or(input.len(), |end| end + 1));
        *input = rest;
        self.too_long |= self.line.len() + piece.len() > LINE_MAX;
        if self.too_long {
            self.line.clear();
        } else {
            self.line.extend_from_slice(piece);
        }
        end?;
        let line = core::mem::take(&mut self.line);
        match core::mem::take(&mut self.too_long) {
            true => Some(Err(())),
            false => Some(Ok(line.trim_ascii().to_vec())),
        }
    }

    /// Sends one line; false when the client had to be dropped because it does not read.
    fn push(&self, value: &Value) -> bool {
        self.client.push(format!("{value}\n").as_bytes())
    }
}

impl Server {
    /// Watches all these sensors, and lets control clients change them.
    pub fn control(&mut self, units: Vec<Unit>) {
        self.units = units;
    }

    /// Handles input of a control client: answers each complete line with one line.
    pub(super) fn input_of_control(
        &mut self,
        id: ClientId,
        mut input: &[u8],
    ) -> Result<(), super::RunError> {
        while !input.is_empty() {
            let Some(control) = self.controls.get_mut(&id) else {
                return Ok(());
            };
            let answer = match control.next_line(&mut input) {
                None => return Ok(()),
                Some(Ok(line)) if line.is_empty() => continue,
                Some(Ok(line)) => self.perform(id, &line)?,
                Some(Err(())) => Err(format!("a request has at most {LINE_MAX} bytes")),
            };
            let answer = match answer {
                Ok(members) => {
                    let mut all = json!({ "time": seconds(self.bus.now()) });
                    unit::add(&mut all, members);
                    json!({ "ok": all })
                }
                Err(error) => json!({ "error": error }),
            };
            // Events that the request has caused come before its answer.
            self.report(&[]);
            let reads = |control: &Control| control.push(&answer);
            if !self.controls.get(&id).is_none_or(reads) {
                self.leave_control(id);
            }
        }
        Ok(())
    }

    /// Sends the events since the last call, in the order of their times; `logged` are the frames of this time.
    pub(super) fn report(&mut self, logged: &[Logged]) {
        if self.controls.is_empty() {
            return;
        }
        let mut events = Vec::new();
        for unit in &mut self.units {
            unit.watch(&mut self.bus, &mut events);
        }
        events.extend(logged.iter().map(|entry| Event {
            at: entry.at,
            topic: Topic::Frames,
            members: json!({
                "sensor": self.sender(entry.source),
                "frame": format!("{:?}", entry.frame),
            }),
        }));
        events.sort_by_key(|event| event.at);
        let mut silent = Vec::new();
        for Event { at, topic, members } in events {
            let mut line = json!({ "event": topic.name(), "time": seconds(at) });
            unit::add(&mut line, members);
            for (id, control) in &self.controls {
                if control.topics.contains(&topic) && !control.push(&line) {
                    silent.push(*id);
                }
            }
        }
        silent.into_iter().for_each(|id| self.leave_control(id));
    }

    /// The name of the sensor that has sent a frame; None: a client.
    fn sender(&self, source: Source) -> Option<&str> {
        let mut units = self.units.iter();
        let unit = units.find(|unit| source == Source::Device(unit.device))?;
        Some(&unit.name)
    }

    /// The adapter of a control client, on the bus.
    fn adapter_of(&mut self, id: ClientId) -> Option<AdapterId> {
        let control = self.controls.get_mut(&id)?;
        let bus = &mut self.bus;
        Some(*control.adapter.get_or_insert_with(|| {
            let adapter = bus.adapter();
            bus.open(adapter, None, false);
            adapter
        }))
    }

    pub(super) fn leave_control(&mut self, id: ClientId) {
        if let Some(adapter) = self.controls.remove(&id).and_then(|one| one.adapter) {
            self.leaving.add(&mut self.bus, adapter);
        }
    }
}
