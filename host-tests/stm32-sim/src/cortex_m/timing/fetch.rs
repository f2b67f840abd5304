//! Instruction fetches. The flash is read by lines of 64 bits, each with the wait states of FLASH_ACR; its prefetch buffer reads the
//! next line while one is executed (PM0075, section 2.2). Code in RAM is fetched by words over the system bus, which adds a cycle to
//! each, because that bus registers the fetch.

use super::Cycles;

/// The start of no line: no instruction is behind it within the size of a line.
const NONE: u32 = 0xFFFF_FFF1;

/// The bytes of a line of 64 bits, and of a word.
const LINE: u32 = 8;
const WORD: u32 = 4;

/// The timing of the flash as FLASH_ACR selects it.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct FlashTiming {
    /// LATENCY: wait states of a read.
    pub wait_states: u8,
    /// The prefetch buffer is on (PRFTBE).
    pub prefetch: bool,
}

/// The fetch unit with the prefetch buffer of the flash.
#[derive(Clone, Debug)]
pub struct Fetch {
    flash: FlashTiming,
    /// The first address of the line or word that is executed.
    line: u32,
    /// The number of bytes in it.
    size: u32,
    /// When the next two lines have been read. The second is used only if the buffer is that far ahead.
    ready: [u64; 2],
    /// The flash is being programmed or erased until then.
    busy_until: u64,
}

impl Default for Fetch {
    /// With zero wait states and the prefetch buffer, as after a reset (PM0075, FLASH_ACR).
    fn default() -> Self {
        Self {
            flash: FlashTiming {
                wait_states: 0,
                prefetch: true,
            },
            line: NONE,
            size: LINE,
            ready: [0; 2],
            busy_until: 0,
        }
    }
}

impl Fetch {
    /// Sets wait states and prefetch buffer.
    pub fn set_flash(&mut self, flash: FlashTiming) {
        if flash != self.flash {
            self.flash = flash;
            self.line = NONE;
        }
    }

    /// The flash is busy until this cycle.
    pub fn set_busy(&mut self, until: u64) {
        self.busy_until = until;
        self.line = NONE;
    }

    /// True if an instruction of 2 or 4 bytes is completely in the line that is executed.
    #[inline(always)]
    pub fn has(&self, pc: u32, length: u32) -> bool {
        pc.wrapping_sub(self.line) <= self.size.wrapping_sub(length)
    }

    /// Notes that a branch was taken: the next instruction is fetched.
    #[inline(always)]
    pub fn branch(&mut self, cycles: &Cycles) {
        if cycles.branch_discards_lines != 0 {
            self.line = NONE;
        }
    }

    /// Forgets what was fetched before.
    pub fn forget(&mut self) {
        self.line = NONE;
    }

    /// All instructions are there without a fetch.
    pub fn have_everything(&mut self) {
        (self.line, self.size) = (0, u32::MAX);
    }

    /// Fetches the bytes from `pc` to `end` at cycle `now`, when the instruction before has ended. Returns the cycle at which they
    /// are there, or the error that the flash is busy until a cycle.
    #[inline(always)]
    pub fn fetch(&mut self, pc: u32, end: u32, now: u64, cycles: &Cycles) -> Result<u64, u64> {
        let is_next = end & !(LINE - 1) == self.line.wrapping_add(LINE);
        if is_next && self.size == LINE && self.flash.prefetch {
            // By far the most frequent case. The flash is not busy while there is a line of it.
            self.line += LINE;
            let at = now.max(self.ready[0]);
            self.read_ahead(at, self.flash.wait_states.into(), cycles);
            return Ok(at);
        }
        self.fetch_elsewhere(pc, end, now, cycles)
    }

    /// Fetches what is not completely in the next line of flash.
    #[inline(never)]
    fn fetch_elsewhere(
        &mut self,
        pc: u32,
        end: u32,
        now: u64,
        cycles: &Cycles,
    ) -> Result<u64, u64> {
        let (size, wait, ahead) = if is_code(pc) {
            if self.busy_until > now {
                return Err(self.busy_until);
            }
            let wait = u64::from(self.flash.wait_states);
            match self.flash.prefetch {
                true => (LINE, wait, true),
                false if cycles.words_without_prefetch != 0 => (WORD, wait, false),
                false => (LINE, wait, false),
            }
        } else {
            (WORD, 1, true)
        };
        let (first, last) = (pc & !(size - 1), end & !(size - 1));
        let mut at = now;
        let follows = size == self.size && self.line != NONE;
        if follows && (first == self.line || first == self.line + size) {
            while self.line != last {
                self.line += size;
                if ahead {
                    at = at.max(self.ready[0]);
                    self.read_ahead(at, wait, cycles);
                } else {
                    at += wait;
                }
            }
        } else {
            // The first of these reads began when the branch did: the refill contains one cycle of it.
            let lines = 1 + u64::from(last != first);
            let began = now.saturating_sub(cycles.refill.into());
            at += lines * wait;
            self.ready[0] = began + (lines + 1) * (wait + 1);
            self.ready[1] = self.ready[0] + wait + 1;
            (self.line, self.size) = (last, size);
        }
        Ok(at)
    }

    /// What passes of a loop with a length of `time` do with the lines that are read, if one pass has begun in state `start` at cycle
    /// `began`: true for a line whose time moves with the pass. None if the next pass differs from this one.
    pub fn moves(&self, start: &Self, began: u64, time: u64) -> Option<[bool; 2]> {
        let state = |fetch: &Self| (fetch.flash, fetch.line, fetch.size, fetch.busy_until);
        if state(self) != state(start) {
            return None;
        }
        let mut moves = [false; 2];
        for (moves, (after, before)) in moves.iter_mut().zip(self.ready.iter().zip(start.ready)) {
            *moves = *after == before + time;
            // A line that was there before the pass stays.
            if !*moves && (*after != before || before > began) {
                return None;
            }
        }
        Some(moves)
    }

    /// Further passes take this time, and move these lines.
    pub fn go_on(&mut self, moves: [bool; 2], time: u64) {
        for (ready, moves) in self.ready.iter_mut().zip(moves) {
            *ready += if moves { time } else { 0 };
        }
    }

    /// A new line is executed from `now` on: the buffer has room for another one.
    fn read_ahead(&mut self, now: u64, wait: u64, cycles: &Cycles) {
        if cycles.lines_ahead > 1 {
            self.ready[0] = self.ready[1];
            self.ready[1] = now.max(self.ready[0]) + wait + 1;
        } else {
            self.ready[0] = now + wait + 1;
        }
    }

    /// The cycle at which the data of a read of the flash at cycle `now` are there, at zero wait states `now`.
    pub fn read_data(&mut self, now: u64, cycles: &Cycles) -> u64 {
        let start = now.max(self.busy_until);
        let wait = u64::from(self.flash.wait_states);
        if wait == 0 {
            return start;
        }
        if self.size == LINE && self.line != NONE && self.ready[0] > start {
            if cycles.data_waits_for_line != 0 {
                // At most one line is being read.
                return self.ready[0].min(start + wait + 1) + wait;
            }
            self.ready = self.ready.map(|ready| ready + wait + 1);
        }
        start + wait
    }

    /// A data access on the system bus delays the fetch of code in RAM.
    #[inline(always)]
    pub fn contend(&mut self, cycles: &Cycles) {
        self.ready[0] += u64::from(cycles.ram_contention);
    }

    /// True while code in RAM executes.
    #[inline(always)]
    pub fn is_in_ram(&self) -> bool {
        self.size == WORD && !is_code(self.line)
    }

    /// Wait states and end of the present work of the flash, for the vectors.
    pub fn wait_states(&self) -> u64 {
        self.flash.wait_states.into()
    }

    /// The cycle until which the flash is busy.
    pub fn busy_until(&self) -> u64 {
        self.busy_until
    }
}

/// True for addresses of the code region, where flash is.
#[inline(always)]
pub fn is_code(address: u32) -> bool {
    address >> 29 == 0
}
