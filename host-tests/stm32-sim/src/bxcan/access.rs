//! The software interface: reading and writing the registers.

use super::registers::Register;
use super::timing::Timing;
use super::{BTR_HISTORY, BxCan, mode, silicon, transmit};
use crate::io::AccessError;
use can_wire::protocol::Picoseconds;

/// CAN_MSR.RX and SAMP: the level on the receive pin, now and at the last sample point.
const RECESSIVE: u32 = 1 << 11;
const SAMPLED_RECESSIVE: u32 = 1 << 10;
/// CAN_MSR.RXM and TXM: receiver or transmitter of the current frame.
const RECEIVING: u32 = 1 << 9;
const TRANSMITTING: u32 = 1 << 8;

impl BxCan {
    /// Reads the register at an offset from the peripheral's base.
    ///
    /// # Errors
    /// The register does not exist.
    pub fn read(&mut self, now: Picoseconds, offset: u32) -> Result<u32, AccessError> {
        let register = Register::at(offset).ok_or(AccessError::Unmapped)?;
        self.settle(now);
        let reserved = self.undefined(register);
        let state = &self.state;
        let value = match register {
            Register::MasterControl => self.read_control(),
            Register::MasterStatus => self.master_status(),
            Register::TransmitStatus => {
                let status = state.transmitter.status(state.control.order());
                match self.silicon.mailbox_code {
                    None => status,
                    Some(code) => {
                        status & !transmit::CODE | code << transmit::CODE.trailing_zeros()
                    }
                }
            }
            Register::ReceiveFifo(fifo) => state.fifos[fifo].status(),
            Register::InterruptEnable => state.status.enabled(),
            Register::ErrorStatus => state.status.error_status(),
            Register::BitTiming => state.timing.value() & self.silicon.timing_reads,
            Register::Transmit { mailbox, word } => state.transmitter.read(mailbox, word),
            Register::Receive { fifo, word } => {
                state.fifos[fifo].read(word, register.name(), &mut self.violations)
            }
            Register::FilterMaster => {
                let (_, kept) = state.filters.reserved(register, self.silicon.filter_master);
                kept | state.filters.read(register)
            }
            Register::FilterMode
            | Register::FilterScale
            | Register::FilterFifo
            | Register::FilterActivation
            | Register::FilterBank { .. } => state.filters.read(register),
        };
        Ok(value | reserved)
    }

    /// True when the register keeps its value without an access or an event. Only known of CAN_RFxR.
    pub fn is_constant(&self, offset: u32) -> bool {
        match Register::at(offset) {
            Some(Register::ReceiveFifo(fifo)) => self.state.fifos[fifo].next_event().is_none(),
            _ => false,
        }
    }

    /// Writes the register at an offset from the peripheral's base.
    ///
    /// # Errors
    /// The register does not exist, or the write selects a function that is not modelled.
    pub fn write(&mut self, now: Picoseconds, offset: u32, value: u32) -> Result<(), AccessError> {
        let register = Register::at(offset).ok_or(AccessError::Unmapped)?;
        self.settle(now);
        let (mask, kept) = self.reserved(register);
        let value = value & !self.undefined(register);
        if value & mask != kept {
            let reason = format!("{value:08X}h changes reserved bits");
            self.violations.record(register.name(), reason);
        }
        match register {
            Register::MasterControl => self.write_control(now, value)?,
            Register::MasterStatus => self.state.status.clear_interrupts(value),
            Register::TransmitStatus => self.state.transmitter.write_status(value),
            Register::ReceiveFifo(fifo) => {
                let released = now + silicon::time(self.silicon.release, self.clock);
                self.state.fifos[fifo].write_status(
                    value,
                    released,
                    register.name(),
                    &mut self.violations,
                );
            }
            Register::InterruptEnable => self.state.status.enable(value),
            Register::ErrorStatus => self.write_error_status(value),
            Register::BitTiming => self.write_timing(now, value)?,
            Register::Transmit { mailbox, word } => self.write_mailbox(mailbox, word, value),
            Register::Receive { .. } => self.violations.record(register.name(), "is read-only"),
            Register::FilterMaster
            | Register::FilterMode
            | Register::FilterScale
            | Register::FilterFifo
            | Register::FilterActivation
            | Register::FilterBank { .. } => {
                let received = !self.state.filters.is_initializing();
                self.state
                    .filters
                    .write(register, value, &mut self.violations);
                let stopped = received && self.state.filters.is_initializing();
                if stopped && self.state.control.may_start() {
                    self.reception_stops += 1;
                }
            }
        }
        self.changed = true;
        self.settle(now);
        Ok(())
    }

    /// The bits that must keep their value, and this value.
    fn reserved(&self, register: Register) -> (u32, u32) {
        match register {
            Register::FilterMaster
            | Register::FilterMode
            | Register::FilterScale
            | Register::FilterFifo
            | Register::FilterActivation => {
                let master = self.silicon.filter_master;
                self.state.filters.reserved(register, master)
            }
            _ => register.reserved(),
        }
    }

    /// The reserved bits that read as 1, although their value after a reset is 0. They can be written with both.
    fn undefined(&self, register: Register) -> u32 {
        let (mask, kept) = self.reserved(register);
        mask & !kept & self.silicon.reserved
    }

    /// True for the registers that [`disturb`](Self::disturb) changes, without the filters that the chip does not have.
    pub fn is_configuration(&self, offset: u32) -> bool {
        match Register::at(offset) {
            Some(
                Register::MasterControl
                | Register::InterruptEnable
                | Register::BitTiming
                | Register::FilterMaster
                | Register::FilterMode
                | Register::FilterScale
                | Register::FilterFifo
                | Register::FilterActivation,
            ) => true,
            Some(Register::FilterBank { bank, .. }) => bank < self.state.filters.total(),
            _ => false,
        }
    }

    /// A disturbance inverts bits of a configuration register: CAN_MCR, CAN_IER, CAN_BTR, and those of the filters. False if the register
    /// does not have all of them.
    pub fn disturb(&mut self, now: Picoseconds, offset: u32, bits: u32) -> bool {
        let Some(register) = Register::at(offset) else {
            return false;
        };
        let Ok(value) = self.read(now, offset) else {
            return false;
        };
        let value = (value ^ bits) & !self.undefined(register);
        match register {
            Register::MasterControl => self.change_control(now, value),
            Register::InterruptEnable => self.state.status.enable(value),
            Register::BitTiming => {
                self.state.timing = Timing::new(value);
                self.retime();
            }
            _ => self.state.filters.disturb(register, bits),
        }
        self.changed = true;
        self.settle(now);
        bits & self.reserved(register).0 == 0
    }

    fn master_status(&self) -> u32 {
        let state = &self.state;
        let receiving = self.protocol.is_busy() && !self.protocol.is_transmitting();
        let bits = [
            (!self.dominant, RECESSIVE),
            (!self.sampled_dominant, SAMPLED_RECESSIVE),
            (receiving, RECEIVING),
            (self.protocol.is_transmitting(), TRANSMITTING),
        ];
        let levels = bits
            .iter()
            .filter(|(is, _)| *is)
            .map(|(_, bit)| bit)
            .sum::<u32>();
        levels | state.status.interrupts() | state.control.acknowledged()
    }

    fn read_control(&mut self) -> u32 {
        let value = self.state.control.value();
        match &mut self.resetting {
            Some(resetting) => {
                resetting.read();
                value | mode::RESET
            }
            None => value,
        }
    }

    fn write_control(&mut self, now: Picoseconds, value: u32) -> Result<(), AccessError> {
        if value & mode::TIME_TRIGGERED != 0 {
            return Err(AccessError::Refused(
                "CAN_MCR.TTCM: time-triggered communication is not modelled",
            ));
        }
        self.change_control(now, value);
        Ok(())
    }

    /// During a reset by RESET, other changes have no effect.
    fn change_control(&mut self, now: Picoseconds, value: u32) {
        if value & mode::RESET != 0 {
            self.begin_reset(now);
        } else if self.resetting.is_none() {
            let before = self.state.control.requested();
            self.state.control.write(value);
            if self.state.control.requested() != before {
                self.requested_at = now;
            }
        }
    }

    fn write_error_status(&mut self, value: u32) {
        if !self.state.status.write_error_status(value) {
            let register = Register::ErrorStatus.name();
            self.violations
                .record(register, "LEC: software may write 7 only");
        }
    }

    fn write_timing(&mut self, now: Picoseconds, value: u32) -> Result<(), AccessError> {
        if Timing::new(value).is_looped_back() {
            self.violations.record(
                Register::BitTiming.name(),
                "LBKM: a sensor has no use for loop back",
            );
        }
        if !self.state.control.is_initializing() {
            let register = Register::BitTiming.name();
            self.violations
                .record(register, "written outside initialization mode");
            return Ok(());
        }
        self.state.timing = Timing::new(value);
        if self.btr_history.len() == BTR_HISTORY {
            self.btr_history.pop_front();
        }
        self.btr_history.push_back((now, self.state.timing.value()));
        Ok(())
    }

    fn write_mailbox(&mut self, mailbox: usize, word: usize, value: u32) {
        let state = &mut self.state;
        let requested = state
            .transmitter
            .write(mailbox, word, value, &mut self.violations);
        if requested && state.timing.is_silent() && state.control.is_on() {
            let register = Register::Transmit { mailbox, word }.name();
            self.violations
                .record(register, "transmission requested in silent mode");
        }
    }
}
