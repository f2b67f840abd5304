//! The phases of a message against a save, and against a save that has no erased page.

mod erases;

use super::super::{SAVES, Scenario, picoseconds};
use super::{ANSWER, STEP, TRAIN, us};
use crate::CostError;
use can_wire::frame_length::frame_bits;
use erases::Erases;

/// The time after which the usage of the device is kept, in us. From then on each page has it.
const KEPT: u64 = 11_000_000;

/// The maximum time of a save that erases a page, in us.
const ERASING: u64 = 60_000;

impl Scenario {
    /// Asks while saves program, and while a save has no erased page.
    pub(in super::super) fn answers_while_saving(&mut self) -> Result<(), CostError> {
        let protocol = self.protocol;
        let sync = self.asked(protocol.sync, protocol.sync_code)?;
        let read = self.asked(protocol.read, protocol.read_code)?;
        self.rig.run(us(KEPT));
        self.save_until_erase()?;
        let between = self.save_until_erase()? - 1;
        self.figures.insert("saves_between", between);
        let begin = self.rig.bus().now();
        self.rig.request(protocol.saves[0])?;
        let duration = (picoseconds(self.rig.bus().now()) - picoseconds(begin)) / 1_000_000;
        let shifts = || (0..TRAIN).step_by(STEP as usize);
        let mut programs = shifts()
            .map(|shift| (&sync, shift))
            .chain(shifts().map(|shift| (&read, shift)))
            .peekable();
        let (mut of_sync, mut of_read, mut erasing) = (Vec::new(), Vec::new(), Vec::new());
        let mut later = between - 1;
        let mut erases = Erases::default();
        loop {
            for _ in 0..later {
                let Some((asked, shift)) = programs.next() else {
                    self.rig.request(protocol.saves[0])?;
                    continue;
                };
                let trials = if std::ptr::eq(asked, &sync) {
                    &mut of_sync
                } else {
                    &mut of_read
                };
                self.begin_save(shift);
                self.ask(asked, duration / TRAIN + 1, TRAIN, false, trials)?;
                self.rig.run(us(20 * ANSWER));
            }
            later = between;
            let before = self.rig.erased();
            let Some(phase) = erases.next() else {
                if programs.peek().is_none() {
                    break;
                }
                // The longer the image, the fewer saves are between two erases.
                self.rig.request(protocol.saves[0])?;
                continue;
            };
            self.begin_save(phase);
            let mut one = Vec::new();
            self.ask(&sync, 1, ERASING + ANSWER, false, &mut one)?;
            if self.rig.erased() == before {
                return Err(CostError::NeverHappened("the erase of a page"));
            }
            erases.note(one.first().map_or(0, |trial| trial.time));
            erasing.extend(one);
        }
        self.record(None, "save_worst", &of_sync);
        self.record(None, "save_read_worst", &of_read);
        self.record(None, "erase_worst", &erasing);
        Ok(())
    }

    /// The number of saves until one has erased a page, that one included.
    fn save_until_erase(&mut self) -> Result<u64, CostError> {
        let before = self.rig.erased();
        for count in 1..=SAVES as u64 {
            self.rig.request(self.protocol.saves[0])?;
            if self.rig.erased() != before {
                return Ok(count);
            }
        }
        Err(CostError::NeverHappened("the erase of a page"))
    }

    /// Requests a save, and runs until `later` us after the end of the request.
    fn begin_save(&mut self, later: u64) {
        let save = self.protocol.saves[0];
        self.rig.run(us(10 * ANSWER));
        self.rig.send(save);
        self.rig
            .run(us(u64::from(frame_bits(&save.frame())) + 3 + later));
    }
}
