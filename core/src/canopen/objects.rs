//! Reading and writing objects: what each home in the dictionary means in the device.

use super::abort::Abort;
use super::device::Device;
use super::dictionary::{Home, Live, Rule};
use super::key::{Key, OWN, TPDOS};
use super::model::{Effect, Model, Text};
use super::saving::What;
use super::sdo::{Written, fits};
use super::values::{check, number};
use crate::time::Instant;

/// "save", as the number that its bytes make (1010h).
const SAVE: u32 = u32::from_le_bytes(*b"save");
/// "load", as the number that its bytes make (1011h).
const LOAD: u32 = u32::from_le_bytes(*b"load");

impl<M: Model> Device<M> {
    /// The number in an object; a signed one as its bytes make it.
    pub(super) fn number(&self, rule: &Rule, sub: u8) -> u32 {
        match rule.home {
            Home::Constant(number) if rule.is_node_relative() => number + u32::from(self.node_id),
            Home::Constant(number) => number,
            Home::Any(slot)
            | Home::Range(slot, ..)
            | Home::OneOf(slot, _)
            | Home::Transmission(slot)
            | Home::SyncId(slot) => self.values.at(slot),
            Home::Measured(which) => self.model.measured(which),
            Home::Live(live) => self.live(live, sub),
            Home::Text(_) | Home::Key => 0,
        }
    }

    fn live(&self, live: Live, sub: u8) -> u32 {
        match live {
            Live::ErrorRegister => self.emergency.register().into(),
            Live::ErrorCount => self.emergency.count(),
            Live::ErrorHistory => self.emergency.entry(sub),
            Live::Store | Live::Restore => 0,
            Live::Serial => self.serial,
        }
    }

    /// The text in an object.
    pub(super) fn text(&self, rule: &Rule) -> Text {
        match rule.home {
            Home::Text(text) => Text::from_slice(text.as_bytes()).unwrap_or_default(),
            _ => self.model.text(&self.values),
        }
    }

    /// Writes `data` to an object that can be written; on an error nothing has changed.
    pub(super) fn write(
        &mut self,
        now: Instant,
        rule: &Rule,
        data: &[u8],
    ) -> Result<Written, Abort> {
        self.attention = true;
        fits(rule, data.len() as u32)?;
        if rule.home == Home::Key {
            let effect = self.model.write_text(data, &mut self.values)?;
            return Ok(self.carry_out(now, effect));
        }
        let value = number(data, rule.data_type().size()).ok_or(Abort::Length)?;
        if let Home::Live(live) = rule.home {
            return self.write_live(live, value);
        }
        check(rule.home, value)?;
        match rule.home.slot() {
            Some(slot) if slot >= OWN => {
                let effect = self.model.write(now, slot, value, &mut self.values)?;
                Ok(self.carry_out(now, effect))
            }
            Some(slot) => {
                self.values.set(slot, value);
                self.apply(now, slot);
                Ok(Written::Done)
            }
            None => Err(Abort::ReadOnly),
        }
    }

    fn write_live(&mut self, live: Live, value: u32) -> Result<Written, Abort> {
        let what = match (live, value) {
            (Live::ErrorCount, 0) => {
                self.emergency.clear_history();
                return Ok(Written::Done);
            }
            (Live::ErrorCount, _) => return Err(Abort::Value),
            (Live::Store, SAVE) => What::Everything,
            (Live::Restore, LOAD) => What::FactoryCommunication,
            _ => return Err(Abort::Signature),
        };
        Ok(self.begin_save(what))
    }

    /// What a written value of the model has made necessary.
    fn carry_out(&mut self, now: Instant, effect: Effect) -> Written {
        self.model.configure(&self.values);
        match effect {
            Effect::None => Written::Done,
            Effect::Store => self.begin_save(What::AtOnce),
            Effect::FactoryReset => self.begin_save(What::FactoryOwn),
            Effect::Restart => {
                self.restart(now);
                Written::Done
            }
        }
    }

    /// Puts a value of the communication profile into force.
    fn apply(&mut self, now: Instant, slot: u8) {
        const SYNC: u8 = Key::SyncId as u8;
        const GUARD_TIME: u8 = Key::GuardTime as u8;
        const LIFE_TIME_FACTOR: u8 = Key::LifeTimeFactor as u8;
        const EMCY_INHIBIT: u8 = Key::EmcyInhibit as u8;
        const HEARTBEAT: u8 = Key::Heartbeat as u8;
        const FIRST_TPDO: u8 = Key::Tpdo as u8;
        match slot {
            SYNC => self.readdress(),
            GUARD_TIME | LIFE_TIME_FACTOR => self.configure_guarding(now),
            EMCY_INHIBIT => self.emergency.configure(self.values.get(Key::EmcyInhibit)),
            HEARTBEAT => {
                self.heartbeat.start(now, self.values.get(Key::Heartbeat));
                self.configure_guarding(now);
            }
            FIRST_TPDO.. => self.configure_tpdos(now),
            _ => {}
        }
    }

    /// Life guarding as the parameters say; the heartbeat goes before it.
    pub(super) fn configure_guarding(&mut self, now: Instant) {
        let guards = self.values.get(Key::Heartbeat) == 0;
        let guard_time = if guards {
            self.values.get(Key::GuardTime)
        } else {
            0
        };
        self.guarding
            .configure(now, guard_time, self.values.get(Key::LifeTimeFactor));
        self.tell_guarding(now);
    }

    /// The TPDOs as their parameters say.
    pub(super) fn configure_tpdos(&mut self, now: Instant) {
        for (number, tpdo) in (0..TPDOS as u8).zip(&mut self.tpdos) {
            tpdo.configure(now, number, &self.values);
        }
        self.readdress();
    }
}
