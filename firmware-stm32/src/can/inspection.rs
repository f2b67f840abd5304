//! A disturbance can change a configuration register. Then the sensor could stop sending although its program runs. So the firmware
//! compares the configuration ten times a second with the values of the boot, and restores it or restarts.

use super::{Bus, Change, transmit, unmask_interrupts};
use crate::board;
use plumbline::node::BusMode;
use plumbline::time::{Duration, Instant, after, millis, reached};

/// The time between comparisons. If the disturbance has selected the internal oscillator, this time is up to eight times as long.
const PERIOD: Duration = millis(100);

/// CAN_MCR: NART, and the other bits that select a mode or function: INRQ, SLEEP, TXFP, RFLM, AWUM, ABOM, TTCM, RESET.
const NART: u32 = 1 << 4;
const OTHERS: u32 = 0x80EF;
/// CAN_MCR: TXFP, transmit mailboxes in the order of the requests.
const TXFP: u32 = 1 << 2;
/// CAN_MSR: INAK and SLAK.
const OFF_THE_BUS: u32 = 0b11;
/// CAN_IER: TMEIE and FMPIE0.
const INTERRUPTS: u32 = 0b11;

impl Bus {
    /// Compares the configuration of board and controller with the values that were set, and restores it if it has changed. Call it often,
    /// while the SPI is idle.
    pub fn inspect(&mut self, now: Instant) {
        if !reached(now, self.inspection) {
            return;
        }
        self.inspection = after(now, PERIOD);
        let restored = self.configuration.restore();
        unmask_interrupts();
        board::set_up_debugging();
        let Some(settings) = self.settings else {
            return;
        };
        if !matches!(self.change, Change::Done) {
            return;
        }
        board::connect_transmitter(settings.mode == BusMode::Normal);
        self.pulses.restore();
        if self.is_as_set(settings.timing()) {
            if restored {
                warn!("a disturbed register is restored");
            }
            return;
        }
        if self.registers().esr().read().boff().bit_is_set() {
            // The disturbance can be its cause, for example a wrong bit rate, and the node does not end it without a recovery.
            error!("restart: bus-off with a disturbed CAN controller");
            board::restart();
        }
        warn!("the disturbed CAN controller is restored");
        transmit::abort_all();
        // RCC resets the controller: a disturbance can have set silent mode, in which the transmit output can stay dominant until such a
        // reset.
        self.reset(true);
    }

    /// Whether the controller has the configuration that was set.
    fn is_as_set(&mut self, timing: u32) -> bool {
        let banks = &self.banks;
        let registers = &self.can.instance().0;
        // An interrupt can change NART.
        let (single, control) = critical_section::with(|_| {
            let control = registers.mcr().read().bits() & (OTHERS | NART);
            (transmit::is_single_attempt(), control)
        });
        let nart = if single { NART } else { 0 };
        let status = registers.msr().read().bits();
        control == TXFP | nart
            && status & OFF_THE_BUS == 0
            && registers.btr().read().bits() == timing
            && registers.ier().read().bits() == INTERRUPTS
            && banks.are_set(registers)
    }
}
