//! The changes of mode of the controller, in steps: reset, initialization mode, the way back to the bus.

use super::inspection::{INTERRUPTS, Mode};
use super::{Bus, transmit};
use crate::board;
use crate::clock;
use plumbline::node::driver;
use plumbline::time::{Duration, Instant, after, millis, reached};

/// The longest time that the controller needs to leave the bus: longer than the longest frame with its error frame at 10 kbit/s.
const LEAVE_LIMIT: Duration = millis(25);

/// The longest time that the controller may need for MCR.RESET. Then it is reset by RCC.
const RESET_LIMIT: Duration = millis(2);

/// The number of times that the controller may not acknowledge initialization mode. Once can be right: a dominant bus, on which it finishes a
/// frame. Then it is reset, and acknowledges independently of the bus.
const TRIES: u8 = 8;

/// The longest time without a dominant bit in which the controller does not join the bus. At 10 kbit/s, the recovery from bus-off takes 0.14 s.
const JOIN_LIMIT: Duration = millis(1000);

/// The time of a dominant level after which it is reported. A frame has at most 5 equal bits.
const DOMINANT_LIMIT: Duration = millis(100);

/// The number of times that a step polls a change of mode. Most changes take a few clock cycles and end in one step.
const POLLS: u32 = 16;

/// The state of a change of mode.
#[derive(Clone, Copy)]
pub(super) enum Change {
    Done,
    /// MCR.RESET is set. Sleep mode follows.
    Resetting {
        /// The end of the wait.
        limit: Instant,
        /// The error counters must be reset too.
        counters: bool,
    },
    /// Initialization mode is requested. The controller finishes a frame first.
    Leaving {
        /// The end of the wait.
        limit: Instant,
    },
    /// The controller waits for 11 recessive bits before it takes part in the bus.
    Joining {
        /// The number of frames that have ended since the join was requested.
        frames: u8,
        /// The level of the bus at the last polls is dominant.
        dominant: bool,
        /// The time of the first poll with this level.
        since: Instant,
    },
}

impl Change {
    fn joining() -> Self {
        Self::Joining {
            frames: 0,
            dominant: false,
            since: clock::now(),
        }
    }

    /// Whether a dominant bus prevents the join.
    pub(super) fn is_prevented(&self) -> bool {
        match *self {
            Self::Joining {
                dominant: true,
                since,
                ..
            } => reached(clock::now(), after(since, DOMINANT_LIMIT)),
            _ => false,
        }
    }
}

impl Bus {
    /// Begins to reset the controller by MCR.RESET. The transmit pin is recessive from now on.
    pub(super) fn reset(&mut self, counters: bool) {
        board::connect_transmitter(false);
        self.registers().mcr().write(|w| w.reset().set_bit());
        let limit = after(clock::now(), RESET_LIMIT);
        self.change = Change::Resetting { limit, counters };
    }

    /// Begins to enter initialization mode.
    pub(super) fn leave(&mut self) {
        // The other bits get their reset values, until `join`: bus-off recovery is not automatic.
        self.registers()
            .mcr()
            .write(|w| w.sleep().clear_bit().inrq().set_bit());
        let limit = after(clock::now(), LEAVE_LIMIT);
        self.change = Change::Leaving { limit };
    }

    /// Performs a step of a change of mode. Call it at least every millisecond.
    pub fn step(&mut self) -> driver::Change {
        self.proceed();
        match self.change {
            Change::Done => driver::Change::Done,
            Change::Joining { .. } => driver::Change::Joining,
            Change::Resetting { .. } | Change::Leaving { .. } => driver::Change::Leaving,
        }
    }

    /// Performs a step of a running change of mode.
    fn proceed(&mut self) {
        for _ in 0..POLLS {
            let registers = self.registers();
            let status = registers.msr().read();
            let resets = registers.mcr().read().reset().bit_is_set();
            match self.change {
                Change::Done => return,
                Change::Resetting { limit, counters } => {
                    let ended = !resets && status.slak().bit_is_set();
                    let late = reached(clock::now(), limit);
                    if late || ended && counters {
                        // The controller is off the bus, without its pin, and has no cause of an interrupt.
                        board::reset_can();
                    }
                    if late || ended {
                        self.leave();
                    }
                }
                Change::Leaving { limit } => {
                    if status.inak().bit_is_set() {
                        return self.join();
                    }
                    if reached(clock::now(), limit) {
                        self.tries = self.tries.saturating_add(1);
                        if self.tries > TRIES {
                            error!("restart: the CAN controller acknowledges no mode");
                            board::restart();
                        }
                        self.reset(false);
                    }
                }
                Change::Joining { .. } => {
                    if status.inak().bit_is_clear() && status.slak().bit_is_clear() {
                        self.change = Change::Done;
                        // The guard notes the address of the node with its filters.
                        self.inspection = clock::now();
                    } else {
                        self.wait();
                    }
                    return;
                }
            }
        }
    }

    /// Waits for the bus. A bus with dominant bits has no limit: the controller drives nothing, and the node can change the mode again.
    fn wait(&mut self) {
        let Change::Joining {
            dominant, since, ..
        } = &mut self.change
        else {
            return;
        };
        // From the pin, because the controller can be defective.
        let (level, now) = (board::receives_dominant(), clock::now());
        if level != *dominant {
            (*dominant, *since) = (level, now);
        } else if !level && reached(now, after(*since, JOIN_LIMIT)) {
            error!("restart: the CAN controller does not join the bus");
            board::restart();
        }
    }

    /// Handles the end of a frame. Returns true if the controller has not joined the bus at the ends of two frames that started after the
    /// join was requested: at this bit rate, the recessive end of a frame is too short. The end of the first one can be seen just before
    /// the controller joins.
    pub fn misses_frame(&mut self) -> bool {
        let Change::Joining { frames, .. } = &mut self.change else {
            return false;
        };
        *frames = frames.saturating_add(1);
        *frames > 2
    }

    /// In initialization mode: sets bit timing, mode, filters and interrupts, and joins the bus. Errors of the previous bit rate
    /// are discarded, so that they are not attributed to the new one.
    fn join(&mut self) {
        self.tries = 0;
        self.forget_error();
        self.setup.verify();
        let mut difference = self.set();
        if difference != self.untaken {
            // Twice, because a disturbance between write and read is no property of the controller.
            difference = self.set();
        }
        self.untaken = difference;
        // In initialization mode the output of the controller is recessive (RM0008, 24.4.1).
        board::connect_transmitter(!self.setup.is_listening());
        self.registers()
            .mcr()
            .modify(|_, w| w.sleep().clear_bit().inrq().clear_bit());
        self.change = Change::joining();
    }

    /// In initialization mode: sets all registers. Returns the [difference](Self::difference).
    fn set(&mut self) -> u32 {
        let registers = &self.can.instance().0;
        self.setup.set(registers);
        // SAFETY: the interrupts have their handlers.
        registers.ier().write(|w| unsafe { w.bits(INTERRUPTS) });
        // Written whole, as IER: a disturbance can have set others.
        registers.mcr().write(|w| {
            w.txfp().set_bit();
            w.nart().bit(transmit::is_single_attempt());
            w.sleep().clear_bit().inrq().set_bit()
        });
        self.difference(Mode::Initialization)
    }
}
