//! The part of the scenario in J1939: claim, requests, parameters and process data.

use super::Scenario;
use crate::CostError;
use crate::products::J1939;
use plumbline::time::millis;

/// From the restart to the end of the silence after the claim, with the start of the image.
const CLAIMING: u32 = 600;

/// The time in which SSI2 is sent.
const CYCLIC: u32 = 300;

impl Scenario {
    /// Changes the protocol and measures it. Then the factory values lead back, and CANopen boots up.
    pub(super) fn j1939(&mut self, messages: &J1939) -> Result<(), CostError> {
        for message in messages.change {
            self.rig.request(*message)?;
        }
        self.rig.run(millis(CLAIMING));
        // Process data comes before the answer: `request` waits for one frame.
        self.rig.send(messages.off);
        self.rig.run(millis(50));
        let claim = ("j1939_claim", messages.contention);
        for (row, message) in [claim].iter().chain(messages.requests) {
            self.replies(row, *message)?;
        }
        self.rig.request(messages.on)?;
        self.rig.run(millis(CYCLIC));
        Ok(())
    }
}
