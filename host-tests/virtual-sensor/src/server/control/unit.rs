//! A sensor that control clients can change, and what they see of it.

use super::request::Topic;
use crate::server::pattern;
use bench::motion::Motion;
use bench::scene::Axes;
use bench::stage::Stage;
use bench::{Bus, DeviceId, Flash, NodeType, STORE_BUFFER, Sensor};
use plumbline::node::{BusMode, BusState, Leds};
use plumbline::store::Store;
use plumbline::time::{Duration, Instant, millis, reached};
use serde_json::{Value, json};

/// A save has ended if the memory has not changed for this time: an erase takes less.
const QUIET: Duration = millis(50);

/// A sensor with its name and the handle of its motion.
pub struct Unit {
    /// Requests and events name the sensor like this.
    pub name: String,
    /// The sensor on the bus.
    pub device: DeviceId,
    /// Its type.
    pub node_type: NodeType,
    /// Its serial number.
    pub serial: u32,
    /// Its motion.
    pub stage: Stage,
    seen: Seen,
}

/// What the events have told of a sensor.
#[derive(Default)]
struct Seen {
    leds: Option<(Instant, Leds)>,
    state: Value,
    work: Work,
    /// The time of the last operation of a save that has not ended yet, and the work before the save.
    saving: Option<(Instant, Work)>,
    /// Why the file of the memory cannot be written.
    unwritten: Option<String>,
}

/// What the memory has done since the start of the program.
#[derive(Clone, Copy, PartialEq, Eq, Default)]
struct Work {
    /// Bytes programmed.
    programmed: u64,
    /// Pages erased.
    erased: u64,
    /// Operations that failed because the file cannot be written.
    unwritten: u64,
}

impl Work {
    fn of(memory: &Flash) -> Self {
        Self {
            programmed: memory.programmed(),
            erased: memory.erased(),
            unwritten: memory.unwritten_operations(),
        }
    }
}

/// An event for the clients that have subscribed to it.
pub(super) struct Event {
    pub(super) at: Instant,
    pub(super) topic: Topic,
    pub(super) members: Value,
}

impl Unit {
    /// A sensor that is attached to the bus with this motion.
    pub fn new(
        name: String,
        device: DeviceId,
        node_type: NodeType,
        serial: u32,
        stage: Stage,
    ) -> Self {
        Self {
            name,
            device,
            node_type,
            serial,
            stage,
            seen: Seen::default(),
        }
    }

    /// The number of its angles, which its memory can select.
    pub(super) fn axes(&self, bus: &mut Bus) -> Axes {
        let memory = copied(bus.device_mut(self.device).memory());
        Axes::stored(&self.node_type, self.serial, memory).0
    }

    /// The answer to `state`.
    pub(super) fn state(&self, bus: &mut Bus) -> Value {
        let now = bus.now();
        let axes = self.axes(bus);
        let scene = angles(self.stage.angles(now, axes), axes);
        let mut stage = self.stage.clone();
        let sensor = bus.device_mut(self.device);
        let Work {
            programmed, erased, ..
        } = Work::of(sensor.memory());
        let leds = pattern::patterns(now, sensor.led_history().iter());
        let patterns = json!({
            "run": pattern::label(leds.run),
            "error": pattern::label(leds.error),
            "module_green": pattern::label(leds.module_green),
            "module_red": pattern::label(leds.module_red),
        });
        let errors = sensor.error_counters();
        let mut state = json!({ "sensor": self.name, "model": self.node_type.name });
        add(&mut state, presence(sensor));
        let more = json!({
            "transmit_errors": errors.map(|(transmit, _)| transmit),
            "receive_errors": errors.map(|(_, receive)| receive),
            "leds": lamps(sensor.leds()),
            "patterns": patterns,
            "angles": sensor.readout().map(|readout| {
                let degrees = |hundredths| f64::from(hundredths) / 100.0;
                let y = readout.y.map(degrees);
                [Some(degrees(readout.x)), y].into_iter().flatten().collect::<Vec<_>>()
            }),
            "scene": scene,
            "temperature": f64::from(stage.reading(now).temperature) / 100.0,
            "supply": f64::from(stage.supply(now)) / 1000.0,
            "fault": stage.fault(now).map(bench::fault::Fault::name),
            "programmed": programmed,
            "erased": erased,
        });
        add(&mut state, more);
        state
    }

    /// The answer to `image`.
    pub(super) fn image(&self, bus: &mut Bus) -> Value {
        let memory = bus.device_mut(self.device).memory();
        let mut store: Store<_, [u8; STORE_BUFFER]> =
            Store::open(copied(memory), self.node_type.owner(self.serial));
        let boot = store.boot();
        json!({
            "memory": hexadecimal(memory.bytes()),
            "parameters": boot.parameters.map(hexadecimal),
            "damaged": boot.damaged,
        })
    }

    /// Adds what has happened since the last call.
    pub(super) fn watch(&mut self, bus: &mut Bus, events: &mut Vec<Event>) {
        let now = bus.now();
        let sensor = bus.device_mut(self.device);
        let mut note = |at, topic, more: Value| {
            let mut members = json!({ "sensor": self.name });
            add(&mut members, more);
            events.push(Event { at, topic, members });
        };
        let history = sensor.led_history();
        let is_new = |entry: &&(Instant, Leds)| {
            let seen = self.seen.leds;
            seen.is_none_or(|seen| entry.0 >= seen.0 && **entry != seen)
        };
        let news = history.iter().rev().take_while(is_new).count();
        for (at, leds) in history.iter().skip(history.len() - news) {
            note(*at, Topic::Leds, lamps(*leds));
        }
        self.seen.leds = history.back().copied();
        let state = presence(sensor);
        if state != self.seen.state {
            self.seen.state = state.clone();
            note(now, Topic::State, state);
        }
        let memory = sensor.memory();
        let work = Work::of(memory);
        let before = core::mem::replace(&mut self.seen.work, work);
        if work != before {
            let begin = self.seen.saving.map_or(before, |(_, begin)| begin);
            self.seen.saving = Some((now, begin));
        }
        if let Some((at, begin)) = self.seen.saving
            && reached(now, at + QUIET)
        {
            self.seen.saving = None;
            let mut members = json!({
                "programmed": work.programmed - begin.programmed,
                "erased": work.erased - begin.erased,
            });
            if let Some(why) = memory.unwritten()
                && work.unwritten != begin.unwritten
            {
                add(&mut members, json!({ "error": why }));
            }
            note(at, Topic::Stored, members);
        }
    }

    /// Why the file of the memory cannot be written, when this has begun or changed since the last call.
    pub(in crate::server) fn newly_unwritten(&mut self, bus: &mut Bus) -> Option<String> {
        let why = bus.device_mut(self.device).memory().unwritten();
        if self.seen.unwritten.as_deref() == why {
            return None;
        }
        self.seen.unwritten = why.map(str::to_owned);
        self.seen.unwritten.clone()
    }
}

/// Adds the members of one object to another.
pub(super) fn add(object: &mut Value, more: Value) {
    if let (Value::Object(object), Value::Object(more)) = (object, more) {
        object.extend(more);
    }
}

/// The angles that a sensor with these axes measures.
pub(super) fn angles((x, y): (f64, f64), axes: Axes) -> [f64; 2] {
    // Not -0.
    let rounded = |angle: f64| (angle * 1e6).round() / 1e6 + 0.0;
    let x = match axes {
        Axes::One => x.rem_euclid(360.0),
        Axes::Two => x,
    };
    [rounded(x), rounded(y)]
}

/// The time of an instant, in seconds.
pub(super) fn seconds(at: Instant) -> f64 {
    at.ticks() as f64 / 1e6
}

fn copied(memory: &Flash) -> Flash {
    Flash::with_content(memory.geometry(), memory.bytes().to_vec())
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02X}")).collect()
}

fn lamps(leds: Leds) -> Value {
    json!({
        "run": leds.run,
        "error": leds.error,
        "module_green": leds.module_green,
        "module_red": leds.module_red,
    })
}

/// Whether and how a sensor is on the bus.
fn presence(sensor: &dyn Sensor) -> Value {
    let mode = sensor.mode().map(|mode| match mode {
        BusMode::Listen => "listen",
        BusMode::Normal => "normal",
    });
    let bus = sensor.bus_state().map(|state| match state {
        BusState::Active => "active",
        BusState::Warning => "warning",
        BusState::Passive => "passive",
        BusState::BusOff => "bus-off",
    });
    json!({
        "on": sensor.is_on(),
        "boots": sensor.boots(),
        "mode": mode,
        "bit_rate": sensor.rate().map(|rate| rate.bits_per_second()),
        "bus": bus,
    })
}
