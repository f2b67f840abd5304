//! The start with a page to erase ahead.

use super::super::{Scenario, picoseconds};
use super::{STEP, us};
use crate::CostError;

/// The maximum time of a start, in us.
const START: u64 = 200_000;

impl Scenario {
    /// Measures a start that erases a page. The saves before have filled one page, and the other one is not erased.
    pub(in super::super) fn starts_with_erase(&mut self) -> Result<(), CostError> {
        let erased = self.rig.erased();
        let time = self.switch_on()?;
        if self.rig.erased() != erased + 1 {
            return Err(CostError::NeverHappened("a start that erases ahead"));
        }
        self.figures.insert("boot_erase_time", time);
        Ok(())
    }

    /// Switches the sensor off and on, and runs until the first boot-up message has been sent: the time to its start in ns.
    fn switch_on(&mut self) -> Result<u64, CostError> {
        let own = self.rig.source();
        self.rig.bus().take_log();
        self.rig.power_cycle();
        let start = self.rig.bus().now();
        while self.rig.bus().now().ticks() < start.ticks() + START {
            self.rig.run(us(STEP));
            let log = self.rig.bus().take_log();
            if let Some(first) = log.iter().find(|logged| logged.source == own) {
                let time = first.start - picoseconds(start);
                return Ok(time.div_ceil(1_000));
            }
        }
        Err(CostError::NeverHappened("a boot-up message"))
    }
}
