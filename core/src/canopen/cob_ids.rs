//! COB-IDs of a node: their numbers on the bus, and writes.
//!
//! The parameter of a COB-ID has the stored form, which contains the node-ID only if the identifier is not the default. So the
//! default follows the node-ID.

use super::Abort;
use super::cob_id;
use super::dictionary::has_free_cob_ids;
use super::nmt::State;
use super::product::{ParametersOf, Product};
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
    /// An identifier changes while the service is disabled before or after the write. A fixed identifier does not change, only
    /// bits 31 and 30.
    pub(super) fn take_cob_id(
        &self,
        index: u16,
        id: ParameterId,
        stored: u32,
        value: u32,
    ) -> Result<u32, Abort> {
        if !Self::FREE {
            let value = value.wrapping_sub(self.node_id.into());
            let fixed = (value ^ stored) & !(cob_id::DISABLED | cob_id::BIT_30) != 0;
            return if fixed { Err(Abort::Value) } else { Ok(value) };
        }
        let before = self.on_bus(stored);
        let fits = if index == EMCY {
            cob_id::fits_emergency(value)
        } else {
            cob_id::fits_tpdo(value)
        };
        let disabled = (value | before) & cob_id::DISABLED != 0;
        if !fits || !(disabled || cob_id::is_same(value, before)) {
            return Err(Abort::Value);
        }
        let base = ParametersOf::<P>::factory_value(id);
        Ok(cob_id::stored(value, base, self.node_id))
    }

    /// Checks that the NMT state permits a write of an object of the communication profile.
    pub(super) fn check_state(&self, index: u16) -> Result<(), Abort> {
        let bound = P::BINDS_COB_IDS && matches!(index, 0x1005 | EMCY);
        if bound && self.state != State::PreOperational {
            return Err(Abort::DeviceState);
        }
        Ok(())
    }
}
