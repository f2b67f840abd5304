//! What the requests of control clients do.

use super::refused::Refused;
use super::request::{MemoryFault, Request, Side, Topic, parse};
use super::unit::{Unit, angles, seconds};
use crate::server::passage::Rule;
use crate::server::port::QUEUE_MAX;
use crate::server::{ClientId, Clock, RunError, Server};
use bench::fault::Fault;
use bench::scene::{Axes, SUPPLIES, Scene, SceneError, TEMPERATURES};
use bench::{Bus, Source};
use can_wire::text;
use plumbline::node::BusMode;
use plumbline::time::{Duration, Instant, after};
use serde_json::{Value, json};
use std::path::Path;
use stm32_sim::Microcontroller;

/// The longest advance in s: the server does nothing else meanwhile.
const LONGEST_ADVANCE: f64 = 60.0;

/// The members of the answer, or why the request was refused.
pub type Answer = Result<Value, String>;

impl Server {
    /// Performs the request in a line.
    pub(super) fn perform(&mut self, id: ClientId, line: &[u8]) -> Result<Answer, RunError> {
        Ok(match parse(line) {
            Err(error) => Err(error),
            Ok((request, Some(_))) if request.is_of_all() => Err(Refused::OfAll.into()),
            Ok((Request::Advance { seconds }, _)) => match self.advance_limit(seconds) {
                Err(error) => Err(error),
                Ok(limit) => {
                    self.advance_until(limit)?;
                    Ok(json!({}))
                }
            },
            Ok((request, sensor)) => self.change(id, request, sensor.as_deref()),
        })
    }

    /// The index of the sensor with this name, or of the only one.
    fn named(&self, name: Option<&str>) -> Result<usize, String> {
        let names: Vec<&str> = self.units.iter().map(|unit| &*unit.name).collect();
        let names = names.join(", ");
        match name {
            None if self.units.len() == 1 => Ok(0),
            None => Err(format!("name the sensor: {names}")),
            Some(name) => {
                let at = self.units.iter().position(|unit| unit.name == name);
                at.ok_or_else(|| format!("there is no sensor {name}, only {names}"))
            }
        }
    }

    /// The time at which an advance by this number of seconds ends.
    fn advance_limit(&self, seconds: f64) -> Result<Instant, String> {
        if self.clock != Clock::Client {
            return Err(
                "the time is that of the computer: start the sensor with --clock client".into(),
            );
        }
        Ok(after(self.bus.now(), span(seconds, LONGEST_ADVANCE)?))
    }

    /// Performs a request that takes no time.
    fn change(&mut self, id: ClientId, request: Request, sensor: Option<&str>) -> Answer {
        let unit = self.named(sensor);
        match request {
            Request::Sensors {} => {
                let units = self.units.iter();
                let sensors: Vec<Value> = units
                    .map(|unit| json!({ "sensor": unit.name, "model": unit.node_type.name }))
                    .collect();
                return Ok(json!({ "sensors": sensors }));
            }
            Request::Corrupt { count } if sensor.is_none() => self.bus.corrupt(count, None),
            Request::HideAcknowledge { count } => self.bus.drop_acknowledges(count),
            Request::Lose {
                count,
                from,
                identifier,
            } => return self.disturb(count, from, identifier.as_deref(), None),
            Request::Delay {
                count,
                from,
                identifier,
                seconds,
            } => return self.disturb(count, from, identifier.as_deref(), Some(seconds)),
            Request::Send { frame } => {
                let frame = text::parse(&frame)?;
                let adapter = self.adapter_of(id).ok_or("the client has left")?;
                if self.bus.queued(adapter) >= QUEUE_MAX {
                    return Err(format!("{QUEUE_MAX} frames already wait for the bus"));
                }
                self.bus.send(adapter, frame);
            }
            // `perform` has done it.
            Request::Advance { .. } => {}
            Request::Subscribe { events } => {
                if events.contains(&Topic::Frames) {
                    self.adapter_of(id);
                }
                if let Some(control) = self.controls.get_mut(&id) {
                    control.topics = events;
                }
            }
            request => return Ok(self.units[unit?].perform(&mut self.bus, request)?),
        }
        Ok(json!({}))
    }

    /// Disturbs the next frames between the clients and the bus.
    fn disturb(
        &mut self,
        count: u32,
        from: Side,
        identifier: Option<&str>,
        seconds: Option<f64>,
    ) -> Answer {
        let rule = Rule::new(count, identifier, seconds)?;
        let mut clients = 0;
        for passage in self.passages(from) {
            passage.add(rule);
            clients += 1;
        }
        Ok(json!({ "clients": clients }))
    }
}

impl Unit {
    /// Performs a request for this sensor, which takes no time.
    ///
    /// # Errors
    /// It is not possible, or not for one sensor. Then nothing has changed.
    pub fn perform(&self, bus: &mut Bus, request: Request) -> Result<Value, Refused> {
        match request {
            Request::State {} => return Ok(self.state(bus)),
            Request::Image {} => return Ok(self.image(bus)),
            Request::Tilt { x, y } => {
                let tilted = self.play(bus, |_, axes| Scene::tilt(x, y, axes));
                return tilted.map_err(|why| Refused::Tilt(x, y, why.to_string()));
            }
            Request::Rate { x, y, seconds } => {
                return self.play(bus, |from, axes| Scene::turn(from, (x, y), seconds, axes));
            }
            Request::Sine { x, y, hertz } => {
                return self.play(bus, |from, axes| Scene::sine(from, (x, y), hertz, axes));
            }
            Request::Scene { file, csv } => {
                return self.play(bus, |_, _| read(file.as_deref(), csv.as_deref()));
            }
            Request::Temperature { celsius } => {
                let celsius = within(celsius, TEMPERATURES, Refused::Temperature)?;
                self.stage.set_temperature(celsius);
            }
            Request::Supply { volts } => {
                let volts = within(volts, SUPPLIES, Refused::Supply)?;
                self.stage.set_supply(volts);
            }
            Request::Accelerometer { fault } => {
                self.check_fault(bus, fault)?;
                self.stage.set_fault(bus.now(), fault);
            }
            Request::Memory { fault } => {
                let flash = bus.device_mut(self.device).flash();
                flash.fail_writes(fault == Some(MemoryFault::Programming));
                flash.fail_erases(fault == Some(MemoryFault::Erasing));
            }
            Request::Damage {} => {
                if !bus.device_mut(self.device).flash().corrupt_newest() {
                    return Err(Refused::NothingSaved);
                }
            }
            Request::Power { on } => {
                let now = bus.now();
                let sensor = bus.device_mut(self.device);
                match on {
                    true if !sensor.is_on() => sensor.power_on(now),
                    false if sensor.is_on() => sensor.power_off(now),
                    _ => {}
                }
                return Ok(json!({ "on": sensor.is_on(), "boots": sensor.boots() }));
            }
            Request::Restart {} => {
                let now = bus.now();
                let sensor = bus.device_mut(self.device);
                sensor.power_cycle(now);
                return Ok(json!({ "boots": sensor.boots() }));
            }
            Request::CutInSave { operations, seed } => {
                let sensor = bus.device_mut(self.device);
                if !sensor.is_on() {
                    return Err(Refused::Off);
                }
                sensor.flash().cut_in_operation_after(operations, seed);
            }
            Request::BusOff {} => return self.drive_bus_off(bus),
            Request::Corrupt { count } => bus.corrupt(count, Some(Source::Device(self.device))),
            _ => return Err(Refused::OfAll),
        }
        Ok(json!({}))
    }

    /// Gives a sensor another scene, which `make` makes from its present angles and its axes.
    fn play(
        &self,
        bus: &mut Bus,
        make: impl FnOnce((f64, f64), Axes) -> Result<Scene, SceneError>,
    ) -> Result<Value, Refused> {
        let now = bus.now();
        let axes = self.axes(bus);
        let scene = make(self.stage.angles(now, axes), axes);
        let scene = scene.map_err(|error| Refused::Scene(error.to_string()))?;
        let end = scene.end();
        let to = end.map(|end| angles(scene.angles(end, axes), axes));
        self.stage.play(now, scene);
        Ok(json!({
            "scene": angles(self.stage.angles(now, axes), axes),
            "ends": end.map(|end| seconds(now) + seconds(end)),
            "to": to,
        }))
    }

    /// Refuses a fault that the accelerometer of a firmware image cannot have.
    fn check_fault(&self, bus: &Bus, fault: Option<Fault>) -> Result<(), Refused> {
        let device = bus.device(self.device);
        let chip = Microcontroller::of(device);
        let is_adxl355 = chip.is_some_and(|chip| chip.io().adxl355.is_some());
        match fault {
            Some(fault @ (Fault::Silent | Fault::Stopped | Fault::Frozen)) if is_adxl355 => {
                Err(Refused::NotOfElement(fault.name()))
            }
            _ => Ok(()),
        }
    }

    /// Disturbs the frames of a sensor until it is bus-off.
    fn drive_bus_off(&self, bus: &mut Bus) -> Result<Value, Refused> {
        let sensor = bus.device(self.device);
        let takes_part = sensor.mode() == Some(BusMode::Normal);
        let Some((errors, _)) = sensor.error_counters().filter(|_| takes_part) else {
            return Err(Refused::NotOnBus);
        };
        // A frame on the wire may still end well, which takes 1 from the counter. Bus-off is above 255.
        let errors = u32::from(errors).saturating_sub(1);
        let frames = 256_u32.saturating_sub(errors).div_ceil(8);
        bus.corrupt(frames, Some(Source::Device(self.device)));
        Ok(json!({ "frames": frames }))
    }
}

/// A number of seconds as a span.
pub(in crate::server) fn span(seconds: f64, longest: f64) -> Result<Duration, Refused> {
    if !(0.0..=longest).contains(&seconds) {
        return Err(Refused::Seconds(longest));
    }
    Ok(Duration::from_ticks((seconds * 1e6).round() as u64))
}

/// The value if it is within these limits.
fn within(
    value: Option<f64>,
    (low, high): (f64, f64),
    refused: fn(f64, f64) -> Refused,
) -> Result<Option<f64>, Refused> {
    match value {
        Some(value) if !(low..=high).contains(&value) => Err(refused(low, high)),
        value => Ok(value),
    }
}

fn read(file: Option<&Path>, csv: Option<&str>) -> Result<Scene, SceneError> {
    match (file, csv) {
        (Some(file), None) => Scene::recording(file),
        (None, Some(csv)) => Scene::recorded(csv),
        _ => Err(SceneError::Argument(
            "a scene is either a file or a csv text".into(),
        )),
    }
}
