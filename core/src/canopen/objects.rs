//! Read and write access to objects: the function of each kind of row in the node.

use super::Abort;
use super::consumer::{self, Consumers};
use super::dictionary::Service;
use super::feature::Feature;
use super::lookup::lookup;
use super::lss::UNCONFIGURED;
use super::mapping::is_mapping;
use super::own::{Own, Read, Scope, Then};
use super::pdo::{MAPPED, Tpdo, Tpdos};
use super::product::{ContextOf, ParametersOf, Product};
use super::protocol::Services;
use super::row::{Kind, Row};
use super::saved::{End, LOAD, SAVE};
use super::saving::What;
use super::sdo::message::Address;
use super::sdo::{Buffer, Objects, Written};
use super::wide;
use crate::application::{Effect, Values};
use crate::param::{ParameterId, ParameterRow, number};
use crate::store::{Name, Unit};
use crate::time::Instant;

/// The objects of a node, for the SDO server.
pub(super) struct View<'a, P: Product> {
    pub services: &'a mut Services<P>,
    pub cx: &'a mut ContextOf<P>,
}

impl<P: Product> Objects for View<'_, P> {
    type Object = &'static Row;
    type Text = P::Text;
    const WRITABLE: usize = P::WRITABLE;

    fn find(&self, address: Address) -> Result<&'static Row, Abort> {
        lookup::<P>(address)
    }

    fn check_read(&self, row: &'static Row, sub: u8) -> Result<(), Abort> {
        if !row.is_readable() {
            return Err(Abort::WriteOnly);
        }
        // CiA 301 has no value for an error that did not occur.
        if row.service() == Some(Service::ErrorHistory)
            && row.kind() == Kind::Service
            && u32::from(sub) > self.services.emergency.count()
        {
            return Err(Abort::NoData);
        }
        Ok(())
    }

    fn is_writable(row: &'static Row) -> bool {
        row.is_writable()
    }

    fn size(row: &'static Row) -> u8 {
        row.size()
    }

    fn lengths(row: &'static Row) -> (u32, u32) {
        match row.size() {
            0 if Services::<P>::is_wide(row) => (wide::SIZE.into(), wide::SIZE.into()),
            0 => (0, P::WRITABLE as u32),
            size => (size.into(), size.into()),
        }
    }

    fn other_length(
        &mut self,
        now: Instant,
        row: &'static Row,
        length: u32,
        abort: Abort,
    ) -> Result<(), Abort> {
        match (row.kind(), row.service()) {
            (Kind::Constant, _) => Err(self.services.refuse_mapping(now, row)),
            // Some manuals print UNSIGNED32.
            (Kind::Service, Some(Service::ErrorCount)) if length == 4 => Ok(()),
            _ => Err(abort),
        }
    }

    fn number(&self, row: &'static Row, sub: u8) -> u32 {
        self.services.number(self.cx, row, sub)
    }

    fn text(&self, row: &'static Row) -> P::Text {
        if let Some(place) = row.own() {
            return self.services.own_text(self.cx, place);
        }
        let mut text = P::Text::EMPTY;
        // There is always room: the size of the buffer is checked at compile time.
        if Services::<P>::is_wide(row) {
            text.append(&Services::<P>::wide_number(self.cx, row).to_le_bytes());
            return text;
        }
        let constant = P::TEXTS.get(row.number() as usize);
        let constant = constant.map_or(&[][..], |constant| constant.as_bytes());
        text.append(given_text(self.cx.shell.unit(), row).map_or(constant, Name::bytes));
        text
    }

    fn write(&mut self, now: Instant, row: &'static Row, data: &[u8]) -> Result<Written, Abort> {
        let Self { services, cx } = self;
        cx.shell.wake_up();
        match row.kind() {
            Kind::Parameter if Services::<P>::is_wide(row) => services.write_wide(cx, row, data),
            Kind::Parameter | Kind::CobId | Kind::Command => {
                let value = number(data);
                services.write(cx, now, row, value)
            }
            Kind::Service => services.write_service(cx, now, row, data),
            _ => services.write_fixed_mapping(cx, now, row, number(data)),
        }
    }
}

impl<P: Product> Services<P> {
    /// The number in an object. A signed number can have more bits than its type.
    pub(super) fn number(&self, cx: &ContextOf<P>, row: &Row, sub: u8) -> u32 {
        match row.kind() {
            Kind::Parameter => cx.parameters.get(row.id()),
            Kind::CobId => self.on_bus(cx.parameters.get(row.id())),
            Kind::Value | Kind::Command => cx.values.number(row.value_id()),
            Kind::Constant if row.is_mapped_count() && !self.is_mapped(row) => 0,
            Kind::Constant => given_number(cx.shell.unit(), row).unwrap_or(row.number()),
            Kind::NodeRelative => row.number() + u32::from(self.node_id),
            Kind::Service => self.service(cx, row, sub),
            Kind::Text => 0,
        }
    }

    fn service(&self, cx: &ContextOf<P>, row: &Row, sub: u8) -> u32 {
        if let Some(place) = row.own() {
            return self.own_number(cx, place);
        }
        match row.service() {
            Some(Service::ErrorRegister) => self.emergency.register().into(),
            Some(Service::ErrorCount) => self.emergency.count(),
            Some(Service::ErrorHistory | Service::ErrorHistoryOrZero) => {
                P::logged(self.emergency.entry(sub))
            }
            Some(Service::SerialNumber) => cx.shell.serial(),
            // The device stores and restores on command (7.5.2.13 of CiA 301).
            Some(Service::StoreGroup | Service::RestoreGroup) => 1,
            _ => 0,
        }
    }

    fn write(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        row: &Row,
        value: u32,
    ) -> Result<Written, Abort> {
        let at_once = ParametersOf::<P>::row(row.id()).is_some_and(ParameterRow::is_stored_at_once);
        // The value in force is accepted in each state, and changes nothing. A command is carried out again.
        let is_command = at_once || row.kind() == Kind::Command || !row.is_readable();
        if !is_command && value == self.number(cx, row, row.address().sub) {
            return Ok(Written::Done);
        }
        if P::Tpdos::DYNAMIC && is_mapping(row.index()) {
            let address = row.address();
            self.write_dynamic_mapping(cx, now, address, row.id(), value)?;
            return Ok(Written::Done);
        }
        if cx.is_saving() && (at_once || self.saved.overwrites()) {
            return if cx.would_change(row.id(), value)? {
                Err(Abort::DeviceState)
            } else {
                Ok(Written::Done)
            };
        }
        self.check_state(row.index())?;
        self.check_sync(cx, row.index(), value)?;
        self.check_consumer(cx, row, value)?;
        let mut value = value;
        if row.kind() == Kind::CobId {
            let stored = cx.parameters.get(row.id());
            value = self.take_cob_id(row.index(), row.id(), stored, value)?;
        }
        // Only LSS takes the node-ID away.
        if P::Lss::PRESENT && row.id() == P::NODE_ID && value == u32::from(UNCONFIGURED) {
            return Err(Abort::Value);
        }
        let effect = cx.write(row.id(), value)?;
        if row.is_communication() {
            self.apply(cx, now, row.index());
            return Ok(Written::Done);
        }
        cx.apply();
        Ok(self.carry_out(cx, effect))
    }

    /// Writes a part of a fixed mapping: its present contents, or 0 as the number of mapped objects. Another value is refused.
    fn write_fixed_mapping(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        row: &Row,
        value: u32,
    ) -> Result<Written, Abort> {
        let is_count = row.is_mapped_count();
        if value != row.number() && !(is_count && value == 0) {
            return Err(self.refuse_mapping(now, row));
        }
        if is_count && let Some(tpdo) = self.tpdos.all_mut().get_mut(number_of(row.index())) {
            tpdo.set(now, MAPPED, value != 0);
            self.withdraw(cx);
        }
        Ok(Written::Done)
    }

    /// The fixed mapping is in force again, so that a refused mapping does not leave the TPDO silent.
    fn refuse_mapping(&mut self, now: Instant, row: &Row) -> Abort {
        if let Some(tpdo) = self.tpdos.all_mut().get_mut(number_of(row.index())) {
            tpdo.set(now, MAPPED, true);
        }
        Abort::NotMappable
    }

    fn is_mapped(&self, row: &Row) -> bool {
        let tpdo = self.tpdos.all().get(number_of(row.index()));
        tpdo.is_some_and(Tpdo::is_mapped)
    }

    pub(super) fn carry_out(&mut self, cx: &mut ContextOf<P>, effect: Effect) -> Written {
        match effect {
            Effect::None => Written::Done,
            Effect::Store => self.save(cx, What::AtOnce),
        }
    }

    fn write_service(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        row: &Row,
        data: &[u8],
    ) -> Result<Written, Abort> {
        if let Some(place) = row.own() {
            return self.write_own(cx, now, place, data);
        }
        let service = row.service().ok_or(Abort::ReadOnly)?;
        // All others are stored at once.
        if cx.is_saving() && service != Service::ErrorCount {
            return Err(Abort::DeviceState);
        }
        let sub = row.address().sub;
        match (service, number(data)) {
            (Service::StoreGroup, SAVE) if Self::HAS_RANGES => Ok(self.store_range(cx, sub)),
            (Service::RestoreGroup, LOAD) if Self::HAS_RANGES => Ok(self.restore_range(cx, sub)),
            (Service::ErrorCount, 0) => {
                self.emergency.clear_history();
                Ok(Written::Done)
            }
            (Service::ErrorCount, _) => Err(Abort::Value),
            (Service::Store, SAVE) => Ok(self.save(cx, What::Everything)),
            (Service::RestoreCommunication, LOAD) => Ok(self.save(cx, What::FactoryCommunication)),
            _ => Err(Abort::Signature),
        }
    }

    /// The functions of the own object at this place.
    fn own(place: u8) -> Option<&'static Own<P>> {
        P::OWN.get(usize::from(place))
    }

    /// The number in an own object.
    pub(super) fn own_number(&self, cx: &ContextOf<P>, place: u8) -> u32 {
        match Self::own(place).map(|own| &own.read) {
            Some(Read::Number(read)) => read(&self.own, cx),
            _ => 0,
        }
    }

    /// The text in an own object.
    fn own_text(&self, cx: &ContextOf<P>, place: u8) -> P::Text {
        match Self::own(place).map(|own| &own.read) {
            Some(Read::Text(read)) => read(&self.own, cx),
            _ => P::Text::EMPTY,
        }
    }

    fn write_own(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        place: u8,
        data: &[u8],
    ) -> Result<Written, Abort> {
        let write = Self::own(place).and_then(|own| own.write);
        match write.ok_or(Abort::ReadOnly)?(&mut self.scope(cx), data)? {
            Then::Reply => {}
            Then::Save => {
                let has_end = Self::own(place).is_some_and(|own| own.stored.is_some());
                self.saved.end = if has_end {
                    End::Own(place)
                } else {
                    End::Nothing
                };
                return Ok(Written::Storing);
            }
            Then::Reset => self.prepare_reset(now),
            Then::Restart => {
                self.saved.restart();
                self.prepare_reset(now);
            }
        }
        Ok(Written::Done)
    }

    /// Tells an own object that the save that it has begun has ended.
    pub(super) fn finish_own(&mut self, cx: &mut ContextOf<P>, place: u8, succeeded: bool) {
        if let Some(stored) = Self::own(place).and_then(|own| own.stored) {
            stored(&mut self.scope(cx), succeeded);
        }
    }

    pub(super) fn scope<'a>(&'a mut self, cx: &'a mut ContextOf<P>) -> Scope<'a, P> {
        Scope {
            cx,
            state: &mut self.own,
            stored: &self.saved.parameters,
            history: self.emergency.history_mut(),
        }
    }

    /// Applies a parameter of the communication profile.
    fn apply(&mut self, cx: &mut ContextOf<P>, now: Instant, index: u16) {
        let mut identifiers_changed = false;
        match index {
            0x1005 | 0x1014 => identifiers_changed = self.take_sync(cx),
            0x100C | 0x100D => self.configure_guarding(cx, now),
            0x1015 => self.configure_emergency(cx),
            consumer::INDEX if P::Consumers::COUNT > 0 => {
                identifiers_changed = self.configure_consumers(cx);
            }
            0x1017 => {
                self.configure_heartbeat(cx, now);
                self.configure_guarding(cx, now);
            }
            0x1800..0x1A00 => {
                identifiers_changed = self.configure_tpdo(cx, now, number_of(index));
                identifiers_changed |= self.take_sync(cx);
            }
            _ => {}
        }
        if identifiers_changed {
            self.readdress(cx);
        }
    }
}

/// Whether a running save refuses a change of this parameter.
pub(super) fn is_busy<P: Product>(
    services: &Services<P>,
    cx: &ContextOf<P>,
    id: ParameterId,
) -> bool {
    let at_once = ParametersOf::<P>::row(id).is_some_and(ParameterRow::is_stored_at_once);
    cx.is_saving() && (at_once || services.saved.overwrites())
}

/// The number that the unit has in place of a constant; None: it has the constant.
fn given_number(unit: &Unit, row: &Row) -> Option<u32> {
    match (row.index(), row.address().sub) {
        (0x1018, 1) => unit.vendor,
        (0x1018, 2) => unit.product_code,
        (0x1018, 3) => unit.revision,
        _ => None,
    }
}

/// Whether the object at this index is a name, which the unit can have in place of a constant text.
pub(super) const fn is_name(index: u16) -> bool {
    matches!(index, 0x1008..=0x100A)
}

/// The text that the unit has in place of a constant; None: it has the constant.
fn given_text<'a>(unit: &'a Unit, row: &Row) -> Option<&'a Name> {
    match row.index() {
        0x1008 => unit.name.as_ref(),
        0x1009 => unit.hardware.as_ref(),
        0x100A => unit.software.as_ref(),
        _ => None,
    }
}

/// The number of the TPDO (from 0) with this object: 1800h, 1A00h and following.
fn number_of(index: u16) -> usize {
    usize::from(index & 0x1FF)
}
