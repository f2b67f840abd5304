//! The filter banks (RM0008, 24.7.4 and 24.9.4; RM0390, 30.7.4 and 30.9.4). The STM32F103 has 14 banks. The STM32F446 has 28, which CAN1
//! shares with CAN2: CAN_FMR.CAN2SB is the first bank of CAN2. CAN2 is not modelled.
//!
//! A bank is two words, CAN_FiR1 and CAN_FiR2, and makes one to four filters:
//!
//! | FS1R, FM1R | Filters | First word | Second word |
//! |---|---|---|---|
//! | 32 bit, mask | 1 | identifier | mask |
//! | 32 bit, list | 2 | identifier | identifier |
//! | 16 bit, mask | 2 | identifier in the low, mask in the high half-word | the same |
//! | 16 bit, list | 4 | identifiers in the low and high half-word | the same |
//!
//! 32 bits have the format of the identifier word of a mailbox. 16 bits are: 15..5 standard identifier, 4 RTR, 3 IDE, 2..0 the
//! three highest bits of the identifier extension.

use super::mailbox;
use super::registers::Register;
use super::silicon::GENUINE_FILTER_MASTER;
use super::violations::Violations;
use plumbline::can::Frame;

/// Filter banks of the STM32F103.
pub(super) const BANKS: usize = 14;
/// Filter banks of the STM32F446.
const SHARED_BANKS: usize = 28;
/// CAN_FMR.CAN2SB, which exists only on a chip with CAN2. On other chips these bits are reserved and keep their reset value.
const SECOND_START: u32 = 0x3F << 8;

/// CAN_FMR.FINIT.
const INITIALIZATION: u32 = 1;

/// Bit 0 of a 32-bit filter is not compared: it has no counterpart in a frame.
const COMPARED: u32 = !1;

/// The filter that accepted a frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Match {
    /// The FIFO that the bank belongs to.
    pub(super) fifo: usize,
    /// The filter match index: the number of the filter among the filters of this FIFO.
    pub(super) index: u8,
}

/// One comparison of an identifier with a filter register.
#[derive(Clone, Copy)]
struct Filter {
    identifier: u32,
    mask: u32,
}

impl Filter {
    fn accepts(&self, identifier: u32) -> bool {
        (self.identifier ^ identifier) & self.mask == 0
    }
}

#[derive(Debug)]
pub(super) struct Filters {
    /// The banks are shared with CAN2.
    shared: bool,
    /// CAN_FMR.CAN2SB.
    second_start: u32,
    initialization: bool,
    list: u32,
    wide: u32,
    fifo: u32,
    active: u32,
    banks: Vec<[u32; 2]>,
}

impl Default for Filters {
    /// The filter banks of the STM32F103 after a reset.
    fn default() -> Self {
        Self::new(false, GENUINE_FILTER_MASTER)
    }
}

impl Filters {
    /// After a reset; with the banks of the STM32F446 if they are shared with CAN2. `master`: the content of CAN_FMR.
    pub(super) fn new(shared: bool, master: u32) -> Self {
        let count = if shared { SHARED_BANKS } else { BANKS };
        Self {
            shared,
            second_start: master & SECOND_START,
            initialization: true,
            list: 0,
            wide: 0,
            fifo: 0,
            active: 0,
            banks: vec![[0; 2]; count],
        }
    }

    /// True when the banks are shared with CAN2.
    pub(super) fn are_shared(&self) -> bool {
        self.shared
    }

    pub(super) fn is_initializing(&self) -> bool {
        self.initialization
    }

    /// The number of banks, also those of another controller.
    pub(super) fn total(&self) -> usize {
        self.banks.len()
    }

    /// A bit for each bank.
    fn all_banks(&self) -> u32 {
        (1 << self.total()) - 1
    }

    /// The reserved bits of a filter register, and the value that they must keep. `master`: the content of CAN_FMR after a reset.
    pub(super) fn reserved(&self, register: Register, master: u32) -> (u32, u32) {
        let writable = if self.shared { SECOND_START } else { 0 };
        match register {
            Register::FilterMaster => {
                let mask = !(INITIALIZATION | writable);
                (mask, master & mask)
            }
            Register::FilterMode
            | Register::FilterScale
            | Register::FilterFifo
            | Register::FilterActivation => (!self.all_banks(), 0),
            _ => (0, 0),
        }
    }

    fn write_master(&mut self, value: u32) {
        self.initialization = value & INITIALIZATION != 0;
        if self.shared {
            self.second_start = value & SECOND_START;
        }
    }

    /// The number of banks of this controller.
    pub(super) fn own(&self) -> usize {
        let banks = self.banks.len();
        if self.shared {
            banks.min((self.second_start >> 8) as usize)
        } else {
            banks
        }
    }

    /// CAN_FMR.CAN2SB; 0 on a chip without CAN2.
    fn second_start(&self) -> u32 {
        if self.shared { self.second_start } else { 0 }
    }

    /// Reads one of the filter registers, of CAN_FMR without its reserved bits; any other reads as 0.
    pub(super) fn read(&self, register: Register) -> u32 {
        match register {
            Register::FilterMaster => self.second_start() | u32::from(self.initialization),
            Register::FilterMode => self.list,
            Register::FilterScale => self.wide,
            Register::FilterFifo => self.fifo,
            Register::FilterActivation => self.active,
            Register::FilterBank { bank, half } => self.banks.get(bank).map_or(0, |b| b[half]),
            _ => 0,
        }
    }

    /// Writes one of the filter registers.
    pub(super) fn write(&mut self, register: Register, value: u32, violations: &mut Violations) {
        let all_banks = self.all_banks();
        let configuration = match register {
            Register::FilterMaster => return self.write_master(value),
            Register::FilterActivation => return self.active = value & self.all_banks(),
            Register::FilterBank { bank, half } => {
                return self.write_bank(bank, half, value, violations);
            }
            Register::FilterMode => &mut self.list,
            Register::FilterScale => &mut self.wide,
            Register::FilterFifo => &mut self.fifo,
            _ => return,
        };
        if self.initialization {
            *configuration = value & all_banks;
        } else {
            violations.record(register.name(), "written without CAN_FMR.FINIT");
        }
    }

    fn write_bank(&mut self, bank: usize, half: usize, value: u32, violations: &mut Violations) {
        let register = Register::FilterBank { bank, half }.name();
        let locked = !self.initialization && is_set(self.active, bank);
        match self.banks.get_mut(bank) {
            None => violations.record(register, format!("there is no filter bank {bank}")),
            Some(_) if locked => {
                violations.record(register, format!("filter bank {bank} is active"));
            }
            Some(content) => content[half] = value,
        }
    }

    /// Inverts bits of a register, also if the manual does not permit it.
    pub(super) fn disturb(&mut self, register: Register, bits: u32) {
        match register {
            Register::FilterMaster => self.write_master(self.read(register) ^ bits),
            Register::FilterMode => self.list ^= bits & self.all_banks(),
            Register::FilterScale => self.wide ^= bits & self.all_banks(),
            Register::FilterFifo => self.fifo ^= bits & self.all_banks(),
            Register::FilterActivation => self.active ^= bits & self.all_banks(),
            Register::FilterBank { bank, half } => self.banks[bank][half] ^= bits,
            _ => {}
        }
    }

    /// The filter that accepts a frame. If several do: a 32-bit one before a 16-bit one, a list before a mask, the lower number
    /// before the higher. During initialization no frame is received.
    pub(super) fn accept(&self, frame: &Frame) -> Option<Match> {
        if self.initialization {
            return None;
        }
        let wide = mailbox::identifier(frame);
        let narrow = narrow(wide);
        // Inactive banks are counted as well.
        let mut count = [0; 2];
        let mut best: Option<((bool, bool), Match)> = None;
        for bank in 0..self.own() {
            let fifo = usize::from(is_set(self.fifo, bank));
            let filters = self.filters(bank);
            let first = count[fifo];
            count[fifo] += filters.len();
            if !is_set(self.active, bank) {
                continue;
            }
            let identifier = if is_set(self.wide, bank) {
                wide
            } else {
                narrow
            };
            let Some(position) = filters.iter().position(|f| f.accepts(identifier)) else {
                continue;
            };
            let rank = (is_set(self.wide, bank), is_set(self.list, bank));
            if best.is_none_or(|(other, _)| rank > other) {
                let index = (first + position) as u8;
                best = Some((rank, Match { fifo, index }));
            }
        }
        best.map(|(_, found)| found)
    }

    fn filters(&self, bank: usize) -> Vec<Filter> {
        let [first, second] = self.banks[bank];
        let (low, high) = (|word: u32| word & 0xFFFF, |word: u32| word >> 16);
        let exactly = |identifier, mask| Filter { identifier, mask };
        match (is_set(self.wide, bank), is_set(self.list, bank)) {
            (true, false) => vec![exactly(first, second & COMPARED)],
            (true, true) => [first, second].map(|word| exactly(word, COMPARED)).into(),
            (false, false) => [first, second]
                .map(|word| exactly(low(word), high(word)))
                .into(),
            (false, true) => [low(first), high(first), low(second), high(second)]
                .map(|half| exactly(half, 0xFFFF))
                .into(),
        }
    }
}

fn is_set(bits: u32, bank: usize) -> bool {
    bits & 1_u32.unbounded_shl(bank as u32) != 0
}

/// The bits of an identifier word that a 16-bit filter compares.
fn narrow(identifier: u32) -> u32 {
    let standard = identifier >> 21;
    let extension = identifier >> 18 & 7;
    let is_extended = identifier >> 2 & 1;
    let is_remote = identifier >> 1 & 1;
    standard << 5 | is_remote << 4 | is_extended << 3 | extension
}

#[cfg(test)]
mod tests;
