//! The registers of an MCP2515 in memory, which is alone on its bus.

use super::{
    BIT_MODIFY, CANCTRL, CANINTF, CANSTAT, CNF3, CONFIGURATION, LOAD_TXB0, MODE, NORMAL, READ,
    READ_RXB0, READ_STATUS, RTS_TXB0, RX0IF, TXB0CTRL, TXREQ, WRITE, buffer, frame,
};
use core::convert::Infallible;
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use plumbline::can::Frame;

/// The chip.
pub struct Chip {
    pub registers: [u8; 128],
    /// The number of requests for configuration mode.
    pub configurations: u32,
}

impl Default for Chip {
    fn default() -> Self {
        let mut registers = [0; 128];
        registers[usize::from(CANSTAT)] = CONFIGURATION;
        Self {
            registers,
            configurations: 0,
        }
    }
}

impl Chip {
    /// A frame comes from the bus, if the chip takes part in it.
    pub fn receive(&mut self, frame: &Frame) {
        if self.registers[usize::from(CANSTAT)] != CONFIGURATION {
            self.registers[0x61..0x6E].copy_from_slice(&buffer(frame)[1..]);
            self.registers[usize::from(CANINTF)] |= RX0IF;
        }
    }

    /// The frame that waits is sent.
    pub fn send(&mut self) -> Option<Frame> {
        let waits = self.registers[usize::from(TXB0CTRL)] & TXREQ != 0;
        if !waits || self.registers[usize::from(CANSTAT)] != NORMAL {
            return None;
        }
        self.registers[usize::from(TXB0CTRL)] = 0;
        self.follow();
        frame(*self.registers[0x31..].first_chunk()?)
    }

    fn store(&mut self, first: u8, bytes: &[u8]) {
        let is_configured = self.registers[usize::from(CANSTAT)] != CONFIGURATION;
        assert!(
            first != CNF3 || !is_configured,
            "only in configuration mode"
        );
        self.registers[usize::from(first)..][..bytes.len()].copy_from_slice(bytes);
        let mode = self.registers[usize::from(CANCTRL)] & MODE;
        self.configurations += u32::from(first == CANCTRL && mode == CONFIGURATION);
        self.follow();
    }

    /// The mode changes when no frame waits.
    fn follow(&mut self) {
        if self.registers[usize::from(TXB0CTRL)] & TXREQ == 0 {
            self.registers[usize::from(CANSTAT)] = self.registers[usize::from(CANCTRL)] & MODE;
        }
    }

    fn execute(&mut self, instruction: &[u8]) {
        match *instruction {
            [WRITE, first, ref bytes @ ..] => self.store(first, bytes),
            [BIT_MODIFY, register, mask, bits] => {
                let old = self.registers[usize::from(register)];
                self.store(register, &[old & !mask | bits & mask]);
            }
            [LOAD_TXB0, ref bytes @ ..] => self.store(0x31, bytes),
            [RTS_TXB0] => self.registers[usize::from(TXB0CTRL)] |= TXREQ,
            _ => panic!("no instruction: {instruction:02X?}"),
        }
    }

    fn answer(&mut self, instruction: &[u8], bytes: &mut [u8]) {
        let first = match *instruction {
            [READ, first] => first,
            [READ_STATUS] => {
                let sends = self.registers[usize::from(TXB0CTRL)] & TXREQ != 0;
                bytes[0] = self.registers[usize::from(CANINTF)] & RX0IF | u8::from(sends) << 2;
                return;
            }
            [READ_RXB0] => {
                self.registers[usize::from(CANINTF)] &= !RX0IF;
                0x61
            }
            _ => panic!("no read: {instruction:02X?}"),
        };
        bytes.copy_from_slice(&self.registers[usize::from(first)..][..bytes.len()]);
    }
}

impl ErrorType for Chip {
    type Error = Infallible;
}

impl SpiDevice for Chip {
    fn transaction(&mut self, parts: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        match parts {
            [Operation::Write(instruction)] => self.execute(instruction),
            [Operation::Write(instruction), Operation::Read(bytes)] => {
                self.answer(instruction, bytes);
            }
            _ => panic!("the driver has no other transfer"),
        }
        Ok(())
    }
}
