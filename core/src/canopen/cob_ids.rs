//! COB-IDs of a node: their numbers on the bus, and writes.
//!
//! The parameter of a COB-ID has the stored form, which contains the node-ID only if the identifier is not the default. So the
//! default follows the node-ID.

use super::Abort;
use super::cob_id;
use super::dictionary::has_free_cob_ids;
use super::pdo::{Tpdo, Tpdos};
use super::product::{ContextOf, ParametersOf, Product};
use super::protocol::Services;
use crate::can::CanId;
use crate::param::ParameterId;

/// The object with the COB-ID of the EMCY.
const EMCY: u16 = 0x1014;

impl<P: Product> Services<P> {
    /// Whether a master can change the identifiers.
    pub(super) const FREE: bool = has_free_cob_ids(P::OBJECTS);

    /// The COB-ID on the bus for its stored form.
    pub(super) fn on_bus(&self, stored: u32) -> u32 {
        if Self::FREE {
            return cob_id::on_bus(stored, self.node_id);
        }
        stored.wrapping_add(self.node_id.into())
    }

    /// The identifier of emergency messages for its COB-ID; None if they are disabled.
    pub(super) fn emergency_id(&self, cob_id: u32) -> Option<CanId> {
        if Self::FREE && cob_id & (cob_id::DISABLED | cob_id::BIT_29) == cob_id::BIT_29 {
            return Some(CanId::extended(cob_id));
        }
        cob_id::in_use(cob_id).map(CanId::standard)
    }

    /// Checks a write of a COB-ID. Returns its stored form.
    ///
    /// The identifier of a TPDO changes while the TPDO is disabled before or after the write. A fixed identifier does not change, only
    /// bits 31 and 30.
    pub(super) fn take_cob_id(
        &self,
        index: u16,
        id: ParameterId,
        stored: u32,
        value: u32,
    ) -> Result<u32, Abort> {
        if !Self::FREE {
            if index == EMCY {
                return Err(Abort::ReadOnly);
            }
            let value = value.wrapping_sub(self.node_id.into());
            let fixed = (value ^ stored) & !(cob_id::DISABLED | cob_id::BIT_30) != 0;
            return if fixed { Err(Abort::Value) } else { Ok(value) };
        }
        let before = self.on_bus(stored);
        let disabled = (value | before) & cob_id::DISABLED != 0;
        let fits = if index == EMCY {
            // A tool writes it once.
            cob_id::fits_emergency(value)
        } else {
            cob_id::fits_tpdo(value) && (disabled || cob_id::is_same(value, before))
        };
        if !fits {
            return Err(Abort::Value);
        }
        let base = ParametersOf::<P>::factory_value(id);
        Ok(cob_id::stored(value, base, self.node_id))
    }

    /// Checks a write of the COB-ID of the SYNC: with fixed identifiers it is refused if the node sends with this identifier now, and also
    /// after the next reset. Free identifiers can change in any order.
    pub(super) fn check_sync(
        &self,
        cx: &ContextOf<P>,
        index: u16,
        value: u32,
    ) -> Result<(), Abort> {
        if index != 0x1005 || Self::FREE {
            return Ok(());
        }
        let coming = cx.parameters.get(P::NODE_ID) as u16;
        let present = u16::from(self.node_id);
        // The identifiers follow the node-ID.
        let after_reset = (value as u16).wrapping_sub(coming).wrapping_add(present);
        let is_own = |id| self.is_own(cx, id, |_| true);
        if is_own(value as u16) && is_own(after_reset) {
            return Err(Abort::Value);
        }
        Ok(())
    }

    /// Applies the COB-ID of the SYNC. An identifier that the node sends itself is not received. Returns true if it has changed.
    pub(super) fn take_sync(&mut self, cx: &ContextOf<P>) -> bool {
        let id = Self::SYNC_COB_ID.get(&cx.parameters) as u16 & 0x7FF;
        let sync = (!self.is_own(cx, id, Tpdo::is_valid)).then_some(CanId::standard(id));
        core::mem::replace(&mut self.sync, sync) != sync
    }

    /// Whether the node sends emergency messages or one of these TPDOs with an identifier.
    fn is_own(&self, cx: &ContextOf<P>, id: u16, considered: impl Fn(&Tpdo) -> bool) -> bool {
        let emergency = self.emergency_id(self.on_bus(Self::EMCY_COB_ID.get(&cx.parameters)));
        let mut tpdos = self.tpdos.all().iter().filter(|tpdo| considered(tpdo));
        emergency == Some(CanId::standard(id)) || tpdos.any(|tpdo| tpdo.id() == id)
    }

    /// Checks that the NMT state permits a write of an object of the communication profile.
    pub(super) fn check_state(&self, index: u16) -> Result<(), Abort> {
        if P::is_writable(index, self.state) {
            Ok(())
        } else {
            Err(Abort::DeviceState)
        }
    }
}
