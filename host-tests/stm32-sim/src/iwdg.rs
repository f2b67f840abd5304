//! The independent watchdog (RM0008, chapter 19). It has its own clock, LSI, and only a reset stops it.
//!
//! | offset | register | |
//! |---|---|---|
//! | 00h | IWDG_KR | 5555h: PR and RLR can be written; AAAAh: reload; CCCCh: start |
//! | 04h | IWDG_PR | prescaler: 4 << PR, at most 256 |
//! | 08h | IWDG_RLR | reload value |
//! | 0Ch | IWDG_SR | PVU, RVU: an update of PR or RLR is pending |
//!
//! An update of PR or RLR takes five cycles of LSI, and LSI runs only after the start of the watchdog.

use super::io::AccessError;
use super::timebase::{Picoseconds, SECOND};
use super::violation::Violations;

/// LSI in Hz, typical (DS5319: 30 to 60 kHz).
pub const LSI: u32 = 40_000;

/// Cycles of LSI for an update of PR or RLR, at most.
const UPDATE_CYCLES: u64 = 5;

/// A register with a pending update.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Slow {
    value: u16,
    new: Option<(u16, Picoseconds)>,
}

impl Slow {
    const fn new(value: u16) -> Self {
        Self { value, new: None }
    }

    fn settle(&mut self, now: Picoseconds) {
        if let Some((value, _)) = self.new.take_if(|(_, due)| *due <= now) {
            self.value = value;
        }
    }
}

/// The watchdog: it resets the chip if the program does not feed it in time.
#[derive(Clone, Debug)]
pub struct Iwdg {
    lsi: u32,
    writable: bool,
    prescaler: Slow,
    reload: Slow,
    /// If running: the value of the counter at this time.
    counter: Option<(u16, Picoseconds)>,
    /// The resulting time of the reset: stored, because each access to any register needs it.
    expires_at: Option<Picoseconds>,
}

impl Default for Iwdg {
    /// The watchdog after a reset: it does not count.
    fn default() -> Self {
        Self {
            lsi: LSI,
            writable: false,
            prescaler: Slow::new(0),
            reload: Slow::new(0xFFF),
            counter: None,
            expires_at: None,
        }
    }
}

impl Iwdg {
    /// A reset, which stops it.
    pub fn reset(&mut self) {
        *self = Self {
            lsi: self.lsi,
            ..Self::default()
        };
    }

    /// Sets the frequency of this chip's LSI in Hz; only while the watchdog is stopped.
    pub fn set_lsi(&mut self, frequency: u32) {
        self.lsi = frequency;
    }

    /// True from the start to the next reset.
    pub fn is_running(&self) -> bool {
        self.counter.is_some()
    }

    /// When the next update of a register ends.
    pub fn next_update(&self) -> Option<Picoseconds> {
        let updates = [self.prescaler.new, self.reload.new];
        let due = updates.into_iter().flatten().map(|(_, due)| due);
        due.filter(|due| *due != Picoseconds::MAX).min()
    }

    /// When it resets the microcontroller unless it is reloaded before; None while it is stopped.
    pub fn expires_at(&self) -> Option<Picoseconds> {
        self.expires_at
    }

    /// Extends the period by this time, for which a debugger has stopped the watchdog.
    pub fn delay(&mut self, length: Picoseconds) {
        if let Some((_, since)) = &mut self.counter {
            *since += length;
        }
        for register in [&mut self.prescaler, &mut self.reload] {
            register.new = register
                .new
                .map(|(value, due)| (value, due.saturating_add(length)));
        }
        self.expires_at = self.next_expiry();
    }

    fn next_expiry(&self) -> Option<Picoseconds> {
        let mut after = self.clone();
        after.settle(Picoseconds::MAX);
        let (counter, since) = after.counter?;
        Some(since + after.ticks(u64::from(counter) + 1))
    }

    /// Reads the register at `offset`.
    pub fn read(&mut self, now: Picoseconds, offset: u32) -> Result<u32, AccessError> {
        self.settle(now);
        let shown = |register: Slow| register.new.map_or(register.value, |(value, _)| value);
        Ok(match offset {
            0x00 => 0,
            0x04 => shown(self.prescaler).into(),
            0x08 => shown(self.reload).into(),
            0x0C => {
                u32::from(self.prescaler.new.is_some()) | u32::from(self.reload.new.is_some()) << 1
            }
            _ => return Err(AccessError::Unmapped),
        })
    }

    /// Writes the register at `offset`.
    pub fn write(
        &mut self,
        now: Picoseconds,
        offset: u32,
        value: u32,
        violations: &mut Violations,
    ) -> Result<(), AccessError> {
        self.settle(now);
        let due = match self.counter {
            Some(_) => now + self.cycles(UPDATE_CYCLES),
            None => Picoseconds::MAX,
        };
        let (register, name, mask) = match offset {
            0x00 => {
                self.write_key(now, value, violations);
                self.expires_at = self.next_expiry();
                return Ok(());
            }
            0x04 => (&mut self.prescaler, "IWDG_PR", 0b111),
            0x08 => (&mut self.reload, "IWDG_RLR", 0xFFF),
            0x0C => return Err(AccessError::Refused("IWDG_SR is read-only")),
            _ => return Err(AccessError::Unmapped),
        };
        if !self.writable {
            violations.add(name, "written without the key 5555h");
        } else if register.new.is_some() {
            violations.add(name, "written while the last update is pending");
        } else {
            register.new = Some((value as u16 & mask, due));
            self.expires_at = self.next_expiry();
        }
        Ok(())
    }

    /// A disturbance inverts bits of the register at `offset`. False unless all of them are in PR or RLR.
    pub fn disturb(&mut self, now: Picoseconds, offset: u32, bits: u32) -> bool {
        self.settle(now);
        let (register, mask) = match offset {
            0x04 => (&mut self.prescaler, 0b111),
            0x08 => (&mut self.reload, 0xFFF),
            _ => return false,
        };
        if bits & !mask != 0 {
            return false;
        }
        register.new = Some((register.value ^ bits as u16, now));
        self.settle(now);
        self.expires_at = self.next_expiry();
        true
    }

    fn write_key(&mut self, now: Picoseconds, value: u32, violations: &mut Violations) {
        // Any other key write-protects PR and RLR again.
        self.writable = value & 0xFFFF == 0x5555;
        match value & 0xFFFF {
            0x5555 => {}
            0xAAAA => {
                if let Some(counter) = &mut self.counter {
                    *counter = (self.reload.value, now);
                }
            }
            0xCCCC => self.start(now),
            _ => violations.add("IWDG_KR", "not a key"),
        }
    }

    /// Counts down from FFFh; LSI starts, and earlier writes are updated from now on.
    fn start(&mut self, now: Picoseconds) {
        if self.counter.is_some() {
            return;
        }
        self.counter = Some((0xFFF, now));
        let due = now + self.cycles(UPDATE_CYCLES);
        for register in [&mut self.prescaler, &mut self.reload] {
            register.new = register.new.map(|(value, _)| (value, due));
        }
    }

    /// Completes updates that are due. The counter continues with the new prescaler.
    fn settle(&mut self, now: Picoseconds) {
        let arrival = self.prescaler.new.filter(|(_, due)| *due <= now);
        if let (Some((_, due)), Some((counter, since))) = (arrival, self.counter) {
            let ticks = (due - since) / self.ticks(1);
            self.counter = Some((counter.saturating_sub(ticks as u16), due));
        }
        self.prescaler.settle(now);
        self.reload.settle(now);
    }

    /// The duration of this many counts.
    fn ticks(&self, count: u64) -> Picoseconds {
        self.cycles(count << (2 + self.prescaler.value.min(6)))
    }

    /// The duration of this many cycles of LSI.
    fn cycles(&self, count: u64) -> Picoseconds {
        (u128::from(count) * u128::from(SECOND) / u128::from(self.lsi)) as Picoseconds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MILLISECOND: Picoseconds = SECOND / 1000;

    fn write(iwdg: &mut Iwdg, now: Picoseconds, offset: u32, value: u32) {
        let mut violations = Violations::default();
        iwdg.write(now, offset, value, &mut violations).unwrap();
        assert!(violations.list().is_empty());
    }

    /// A watchdog with these settings, started at 0, and the time of its first reload, at which they are in effect.
    fn started(prescaler: u32, reload: u32) -> (Iwdg, Picoseconds) {
        let mut iwdg = Iwdg::default();
        for (offset, value) in [(0, 0x5555), (4, prescaler), (8, reload), (0, 0xCCCC)] {
            write(&mut iwdg, 0, offset, value);
        }
        let now = 5 * SECOND / 40_000;
        write(&mut iwdg, now, 0, 0xAAAA);
        (iwdg, now)
    }

    #[test]
    fn timeouts_match_manual() {
        // RM0008, table 96: shortest and longest time-out in units of 0.1 ms
        for (prescaler, shortest, longest) in [
            (0, 1, 4096),
            (1, 2, 8192),
            (2, 4, 16_384),
            (3, 8, 32_768),
            (4, 16, 65_536),
            (5, 32, 131_072),
            (6, 64, 262_144),
            (7, 64, 262_144),
        ] {
            for (reload, timeout) in [(0, shortest), (0xFFF, longest)] {
                let (iwdg, started) = started(prescaler, reload);
                assert_eq!(
                    iwdg.expires_at(),
                    Some(started + timeout * MILLISECOND / 10),
                    "PR {prescaler}, RLR {reload}"
                );
            }
        }
    }

    #[test]
    fn start_counts_from_fff_for_any_reload_value() {
        let mut iwdg = Iwdg::default();
        assert_eq!(iwdg.expires_at(), None);
        write(&mut iwdg, 0, 0, 0xCCCC);
        assert_eq!(iwdg.expires_at(), Some(4096 * MILLISECOND / 10));
    }

    #[test]
    fn reload_delays_and_only_reset_stops_watchdog() {
        let (mut iwdg, _) = started(4, 624);
        for at in [900, 1800, 2700] {
            write(&mut iwdg, at * MILLISECOND, 0, 0xAAAA);
            assert_eq!(iwdg.expires_at(), Some((at + 1000) * MILLISECOND));
        }
        iwdg.reset();
        assert_eq!(iwdg.expires_at(), None);
    }

    #[test]
    fn update_takes_five_cycles_of_lsi() {
        let mut iwdg = Iwdg::default();
        write(&mut iwdg, 0, 0, 0xCCCC);
        write(&mut iwdg, 0, 0, 0x5555);
        write(&mut iwdg, 0, 4, 3);
        write(&mut iwdg, 0, 8, 99);
        assert_eq!(iwdg.read(0, 0x0C), Ok(0b11));
        let mut violations = Violations::default();
        iwdg.write(0, 4, 1, &mut violations).unwrap();
        assert_eq!(violations.list().len(), 1);
        // 5 / 40 kHz = 125 us
        assert_eq!(iwdg.read(124 * MILLISECOND / 1000, 0x0C), Ok(0b11));
        assert_eq!(iwdg.read(125 * MILLISECOND / 1000, 0x0C), Ok(0));
        assert_eq!(
            (iwdg.read(SECOND, 4), iwdg.read(SECOND, 8)),
            (Ok(3), Ok(99))
        );
    }

    #[test]
    fn write_without_key_is_violation() {
        let mut iwdg = Iwdg::default();
        let mut violations = Violations::default();
        iwdg.write(0, 4, 5, &mut violations).unwrap();
        assert_eq!(iwdg.read(0, 4), Ok(0));
        write(&mut iwdg, 0, 0, 0x5555);
        write(&mut iwdg, 0, 0, 0xAAAA);
        iwdg.write(0, 8, 5, &mut violations).unwrap();
        assert_eq!(iwdg.read(0, 8), Ok(0xFFF));
        iwdg.write(0, 0, 0x1234, &mut violations).unwrap();
        assert_eq!(violations.list().len(), 3);
    }

    #[test]
    fn slow_lsi_extends_timeout() {
        let mut iwdg = Iwdg::default();
        iwdg.set_lsi(30_000);
        write(&mut iwdg, 0, 0, 0xCCCC);
        assert_eq!(iwdg.expires_at(), Some(4096 * 4 * SECOND / 30_000));
    }
}
