//! Behaviour of the silicon that RM0008 does not specify, or in which chips differ. A test selects it.
//!
//! - CAN_MCR.RESET stays set for a time. It sets CAN_MCR and the number of pending messages to their reset values and leads to
//!   sleep mode; the other registers and the error counters stay (RM0091, 29.9.2; driver of candleLight_fw, which polls RESET,
//!   then SLAK, and resets the counters by RCC).
//! - Entering initialization and sleep mode and releasing a mailbox take a time.
//! - In silent mode the transmit output can become dominant and stay so until a reset by RCC (libcyphal, pull request 69: after repeated
//!   resets, when the controller receives a frame).
//! - CAN_FMR has a field CAN2SB on some chips (stm32-rs: 2A1C0E01h after a reset on the STM32F103; 0 on others).
//! - CAN_TSR.CODE is always 0 in some clones, in which the TME bits work (katapult, issue 11: GD32F103; STM32_CAN, issue 54:
//!   CS32F103).
//! - Reserved bits can read as 1 in a clone. A write then has the value that was read, or that of the manual.

use can_wire::protocol::Picoseconds;

const PICOSECONDS_PER_SECOND: u64 = 1_000_000_000_000;

/// CAN_FMR of a genuine STM32F103 after a reset, without FINIT.
pub(super) const GENUINE_FILTER_MASTER: u32 = 0x2A1C_0E00;

/// The time for which CAN_MCR.RESET stays set.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ResetTime {
    /// A number of cycles of PCLK1.
    Cycles(u32),
    /// Until CAN_MCR was read as set this number of times.
    Reads(u32),
    /// RESET stays set until a reset by RCC.
    Endless,
}

/// The behaviour of a chip.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Silicon {
    /// The time of a reset by CAN_MCR.RESET.
    pub reset: ResetTime,
    /// The time until initialization or sleep mode is acknowledged, in cycles of PCLK1. The end of a frame comes first. With `u32::MAX`
    /// none is acknowledged: the time is longer than two minutes.
    pub mode: u32,
    /// The controller joins the bus after 11 recessive bits. Otherwise it waits for them without end.
    pub joins: bool,
    /// The time until a mailbox is released, in cycles of PCLK1.
    pub release: u32,
    /// In silent mode a frame locks the transmit output after this number of earlier uses of silent mode, each ended by a reset by
    /// RCC or of the microcontroller, since power-up. None: never.
    pub lock_after: Option<u32>,
    /// CAN_FMR after a reset, without FINIT. CAN2SB is writable if the banks are shared with CAN2.
    pub filter_master: u32,
    /// CAN_TSR.CODE always has this value; None: the number of a mailbox.
    pub mailbox_code: Option<u32>,
    /// Those of these bits that are reserved in a register of control, status or configuration read as 1.
    pub reserved: u32,
    /// The other bits of CAN_BTR read as 0. They have their effect.
    pub timing_reads: u32,
    /// The data length code of a received frame of 8 bytes: its sender can use 8 to 15, and a [`Frame`] stores 8.
    ///
    /// [`Frame`]: plumbline::can::Frame
    pub long_length: u32,
}

impl Default for Silicon {
    fn default() -> Self {
        Self {
            reset: ResetTime::Cycles(64),
            mode: 8,
            joins: true,
            release: 2,
            lock_after: Some(1),
            filter_master: GENUINE_FILTER_MASTER,
            mailbox_code: None,
            reserved: 0,
            timing_reads: !0,
            long_length: 8,
        }
    }
}

impl Silicon {
    /// The worst behaviour that RM0008 permits or that clones have.
    pub fn worst() -> Self {
        Self {
            lock_after: Some(0),
            filter_master: 0,
            mailbox_code: Some(0),
            reserved: 0xA5A5_A5A5,
            ..Self::default()
        }
    }
}

/// The time of a number of cycles of a clock.
pub(super) fn time(cycles: u32, clock: u32) -> Picoseconds {
    let product = u128::from(cycles) * u128::from(PICOSECONDS_PER_SECOND);
    (product / u128::from(clock)) as u64
}

/// A reset by CAN_MCR.RESET that has not ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Resetting {
    Until(Picoseconds),
    Reads(u32),
    Endless,
}

impl Resetting {
    pub(super) fn begin(reset: ResetTime, now: Picoseconds, clock: u32) -> Self {
        match reset {
            ResetTime::Cycles(cycles) => Self::Until(now + time(cycles, clock)),
            ResetTime::Reads(reads) => Self::Reads(reads),
            ResetTime::Endless => Self::Endless,
        }
    }

    pub(super) fn has_ended(self, now: Picoseconds) -> bool {
        match self {
            Self::Until(end) => end <= now,
            Self::Reads(left) => left == 0,
            Self::Endless => false,
        }
    }

    /// Notes that the program has read CAN_MCR.
    pub(super) fn read(&mut self) {
        if let Self::Reads(left) = self {
            *left = left.saturating_sub(1);
        }
    }
}

/// The fault that locks the transmit output.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Lock {
    /// Uses of silent mode that a reset has ended.
    uses: u32,
    /// Silent mode was used since the last reset.
    silent: bool,
    locked: bool,
}

impl Lock {
    /// Handles a reset of the controller by RCC.
    pub(super) fn reset(&mut self) {
        self.uses += u32::from(self.silent);
        self.silent = false;
        self.locked = false;
    }

    /// The controller joins the bus in silent mode.
    pub(super) fn silence(&mut self) {
        self.silent = true;
    }

    /// A frame is seen in silent mode.
    pub(super) fn see_frame(&mut self, after: Option<u32>) {
        self.locked |= after.is_some_and(|uses| self.uses >= uses);
    }

    pub(super) fn is_locked(self) -> bool {
        self.locked
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn output_is_locked_by_frame_after_uses_of_silent_mode() {
        for uses in 0..3 {
            let mut lock = Lock::default();
            for _ in 0..uses {
                lock.silence();
                lock.see_frame(Some(uses));
                assert!(!lock.is_locked());
                lock.reset();
                // Without silent mode, resets do not count.
                lock.reset();
            }
            lock.silence();
            lock.see_frame(None);
            assert!(!lock.is_locked());
            lock.see_frame(Some(uses));
            assert!(lock.is_locked());
            lock.reset();
            assert!(!lock.is_locked());
        }
    }

    #[test]
    fn reset_ends_after_its_time_or_reads() {
        let cycles = Resetting::begin(ResetTime::Cycles(32), 5, 32_000_000);
        assert!(!cycles.has_ended(1_000_004));
        assert!(cycles.has_ended(1_000_005));
        let mut reads = Resetting::begin(ResetTime::Reads(1), 5, 32_000_000);
        assert!(!reads.has_ended(u64::MAX));
        reads.read();
        assert!(reads.has_ended(5));
        let mut endless = Resetting::begin(ResetTime::Endless, 5, 32_000_000);
        endless.read();
        assert!(!endless.has_ended(u64::MAX));
    }
}
