//! SysTick (ARM ARM B3.3): a counter of 24 bits whose value is derived from the cycle counter.

/// CTRL: the counter runs.
const ENABLE: u32 = 1 << 0;
/// CTRL: reaching 0 pends the exception.
const TICKINT: u32 = 1 << 1;
/// CTRL: counts the processor clock rather than an eighth of it (RM0008 8.2).
const CLKSOURCE: u32 = 1 << 2;
/// CTRL: it has reached 0 since the last read.
const COUNTFLAG: u32 = 1 << 16;
/// The width of the counter.
const MASK: u32 = 0x00FF_FFFF;

/// The system timer: control, reload value and counter.
#[derive(Clone, Debug, Default)]
pub struct SysTick {
    control: u32,
    reload: u32,
    /// The value of the counter at cycle `since`.
    value: u32,
    since: u64,
    /// When the counter next reaches 0: stored, because it is needed often.
    zero_at: Option<u64>,
    count_flag: bool,
}

impl SysTick {
    /// The timer after a reset: off.
    pub fn new() -> Self {
        Self::default()
    }

    /// The cycles of a tick.
    fn tick(&self) -> u64 {
        if self.control & CLKSOURCE != 0 { 1 } else { 8 }
    }

    /// The value of the counter at this cycle.
    pub fn current(&self, cycle: u64) -> u32 {
        if self.control & ENABLE == 0 {
            return self.value;
        }
        let ticks = (cycle - self.since) / self.tick();
        match ticks.checked_sub(self.value.into()) {
            None => self.value - ticks as u32,
            // From 0 the counter is set to the reload value; it stays at 0 when that is 0.
            Some(after) => {
                let period = u64::from(self.reload) + 1;
                ((period - after % period) % period) as u32
            }
        }
    }

    /// When the counter next changes from 1 to 0 after this cycle.
    fn next_zero(&self, after: u64) -> Option<u64> {
        if self.control & ENABLE == 0 {
            return None;
        }
        let period = u64::from(self.reload) + 1;
        let first = if self.value == 0 {
            period
        } else {
            self.value.into()
        };
        let first_at = self.since + first * self.tick();
        if first_at > after {
            return (self.value != 0 || self.reload != 0).then_some(first_at);
        }
        let length = period * self.tick();
        let periods = (after - first_at) / length + 1;
        (self.reload != 0).then_some(first_at + periods * length)
    }

    /// The cycle of the next exception.
    pub fn next_exception(&self) -> Option<u64> {
        if self.control & TICKINT == 0 {
            return None;
        }
        self.zero_at
    }

    /// The cycle up to which CTRL keeps the value with which it was read; 0 if it has changed since then.
    pub fn constant_until(&self) -> u64 {
        if self.count_flag {
            return 0;
        }
        self.zero_at.unwrap_or(u64::MAX)
    }

    /// Processes the cycles up to this one; true when the exception becomes pending.
    pub fn advance(&mut self, cycle: u64) -> bool {
        if self.zero_at.is_none_or(|zero| zero > cycle) {
            return false;
        }
        self.zero_at = self.next_zero(cycle);
        self.count_flag = true;
        self.control & TICKINT != 0
    }

    /// Restarts counting from the current value.
    fn hold(&mut self, cycle: u64) {
        self.value = self.current(cycle);
        self.since = cycle;
    }

    /// Reads the register at this offset of 0xE000_E010. Reading CTRL clears COUNTFLAG. [`advance`](Self::advance) comes first.
    pub fn read(&mut self, cycle: u64, offset: u32) -> u32 {
        match offset {
            0x0 => {
                let flag = if std::mem::take(&mut self.count_flag) {
                    COUNTFLAG
                } else {
                    0
                };
                self.control | flag
            }
            0x4 => self.reload,
            0x8 => self.current(cycle),
            // CALIB: 1 ms at 9 MHz, an eighth of 72 MHz (RM0008 10.1.1).
            _ => 9000,
        }
    }

    /// Writes a register. [`advance`](Self::advance) comes first.
    pub fn write(&mut self, cycle: u64, offset: u32, value: u32) {
        self.hold(cycle);
        match offset {
            0x0 => self.control = value & (ENABLE | TICKINT | CLKSOURCE),
            0x4 => self.reload = value & MASK,
            // Any write clears the counter and COUNTFLAG, and pends nothing.
            0x8 => {
                self.value = 0;
                self.count_flag = false;
            }
            _ => {}
        }
        self.zero_at = self.next_zero(cycle);
    }
}
