//! The DSP extension of the Cortex-M4 (ARM ARM A4.4.3 to A4.4.6, A7.7).

use super::super::CortexM3;
use super::super::decode::dsp::{Dsp, ParallelKind, ParallelOp};
use super::super::decode::instruction::{Extend, Register};

/// The lower or the upper half-word, signed.
fn half(value: u32, top: bool) -> i64 {
    let half = if top { value >> 16 } else { value };
    i64::from(half as i16)
}

fn pair(low: u32, high: u32) -> u32 {
    high << 16 | low & 0xFFFF
}

/// The value limited to the range of a signed 32-bit number, and true if the value was outside of this range.
fn saturated(value: i64) -> (u32, bool) {
    let limited = value.clamp(i32::MIN.into(), i32::MAX.into());
    (limited as u32, limited != value)
}

impl CortexM3 {
    /// Not inlined: these instructions are rare, and the instruction loop stays small.
    #[inline(never)]
    pub(super) fn execute_dsp(&mut self, dsp: Dsp) {
        let get = |register: Register| self.registers.get(register);
        let accumulated = |a: Option<Register>| a.map_or(0, |a| i64::from(get(a) as i32));
        let (d, value) = match dsp {
            Dsp::Parallel { kind, op, d, n, m } => (d, self.parallel(kind, op, get(n), get(m))),
            Dsp::Saturating {
                doubles,
                subtracts,
                d,
                n,
                m,
            } => {
                let [m, n] = [m, n].map(|register| i64::from(get(register) as i32));
                let (doubled, first) = saturated(if doubles { 2 * n } else { n });
                let doubled = i64::from(doubled as i32);
                let (value, second) = saturated(if subtracts { m - doubled } else { m + doubled });
                self.registers.flags.saturated |= first || second;
                (d, value)
            }
            Dsp::Select { d, n, m } => {
                let (n, m) = (get(n).to_le_bytes(), get(m).to_le_bytes());
                let flags = self.registers.flags.greater_equal;
                let byte = |at: usize| if flags >> at & 1 != 0 { n[at] } else { m[at] };
                (d, u32::from_le_bytes(std::array::from_fn(byte)))
            }
            Dsp::ExtendAdd {
                kind,
                d,
                n,
                m,
                rotation,
            } => {
                let value = get(m).rotate_right(rotation.into());
                let extended = match kind {
                    Extend::SignedByte => i32::from(value as i8) as u32,
                    Extend::SignedHalfWord => i32::from(value as i16) as u32,
                    Extend::Byte => value & 0xFF,
                    Extend::HalfWord => value & 0xFFFF,
                };
                (d, get(n).wrapping_add(extended))
            }
            Dsp::ExtendPair {
                signed,
                d,
                n,
                m,
                rotation,
            } => {
                let value = get(m).rotate_right(rotation.into());
                let extended = |byte: u32| match signed {
                    true => i32::from(byte as i8) as u32,
                    false => byte & 0xFF,
                };
                let n = n.map_or(0, get);
                let low = n.wrapping_add(extended(value));
                (d, pair(low, (n >> 16).wrapping_add(extended(value >> 16))))
            }
            Dsp::Pack {
                top,
                d,
                n,
                m,
                amount,
            } => {
                let (shifted, _) = self.shifted(m, Dsp::pack_shift(top), amount);
                let value = match top {
                    true => pair(shifted, get(n) >> 16),
                    false => pair(get(n), shifted >> 16),
                };
                (d, value)
            }
            Dsp::SaturatePair { signed, d, n, bits } => {
                let (low, high) = match signed {
                    true => (-(1_i64 << (bits - 1)), (1 << (bits - 1)) - 1),
                    false => (0, (1_i64 << bits) - 1),
                };
                let halves = [false, true].map(|top| half(get(n), top));
                let limited = halves.map(|half| half.clamp(low, high));
                self.registers.flags.saturated |= limited != halves;
                (d, pair(limited[0] as u32, limited[1] as u32))
            }
            Dsp::Halves {
                n_top,
                m_top,
                d,
                n,
                m,
                a,
            } => {
                let product = half(get(n), n_top) * half(get(m), m_top);
                (d, self.noted(product + accumulated(a)))
            }
            Dsp::WordByHalf { top, d, n, m, a } => {
                let product = i64::from(get(n) as i32) * half(get(m), top);
                (d, self.noted((product >> 16) + accumulated(a)))
            }
            Dsp::Dual {
                subtracts,
                exchanges,
                d,
                n,
                m,
                a,
            } => {
                let sum = dual(get(n), get(m), subtracts, exchanges) + accumulated(a);
                (d, self.noted(sum))
            }
            Dsp::Top {
                subtracts,
                rounds,
                d,
                n,
                m,
                a,
            } => {
                let product = i64::from(get(n) as i32) * i64::from(get(m) as i32);
                let a = accumulated(a) << 32;
                let sum = match subtracts {
                    true => a.wrapping_sub(product),
                    false => a.wrapping_add(product),
                };
                let rounding = i64::from(rounds) << 31;
                (d, (sum.wrapping_add(rounding) >> 32) as u32)
            }
            Dsp::Differences { d, n, m, a } => {
                let bytes = get(n).to_le_bytes().into_iter().zip(get(m).to_le_bytes());
                let sum: u32 = bytes.map(|(n, m)| u32::from(n.abs_diff(m))).sum();
                (d, sum.wrapping_add(a.map_or(0, get)))
            }
            Dsp::HalvesLong {
                n_top,
                m_top,
                low,
                high,
                n,
                m,
            } => {
                let product = half(get(n), n_top) * half(get(m), m_top);
                return self.accumulate_long(low, high, product);
            }
            Dsp::DualLong {
                subtracts,
                exchanges,
                low,
                high,
                n,
                m,
            } => {
                let sum = dual(get(n), get(m), subtracts, exchanges);
                return self.accumulate_long(low, high, sum);
            }
            Dsp::AccumulateTwice { low, high, n, m } => {
                let [n, m, first, second] = [n, m, low, high].map(|one| u64::from(get(one)));
                let sum = n * m + first + second;
                self.registers.set(high, (sum >> 32) as u32);
                (low, sum as u32)
            }
        };
        self.registers.set(d, value);
    }

    /// The lower 32 bits of a sum. Sets Q if the sum is not a signed 32-bit number.
    fn noted(&mut self, sum: i64) -> u32 {
        self.registers.flags.saturated |= i64::from(sum as i32) != sum;
        sum as u32
    }

    fn accumulate_long(&mut self, low: Register, high: Register, value: i64) {
        let before = u64::from(self.registers.get(high)) << 32 | u64::from(self.registers.get(low));
        let sum = before.wrapping_add(value as u64);
        self.registers.set(low, sum as u32);
        self.registers.set(high, (sum >> 32) as u32);
    }

    /// The sums and differences of bytes or half-words; sets the GE bits.
    fn parallel(&mut self, kind: ParallelKind, op: ParallelOp, n: u32, m: u32) -> u32 {
        use ParallelKind as K;
        use ParallelOp as O;
        let signed = matches!(kind, K::Signed | K::SignedSaturated | K::SignedHalved);
        let width = match op {
            O::Add8 | O::Sub8 => 8,
            _ => 16,
        };
        let exchanges = matches!(op, O::Asx | O::Sax);
        let m = if exchanges { m.rotate_left(16) } else { m };
        let lane = |value: u32, at: u32| {
            let top = value << (32 - width - at);
            match signed {
                true => i64::from(top as i32 >> (32 - width)),
                false => i64::from(top >> (32 - width)),
            }
        };
        let mut result = 0;
        let mut flags = 0;
        for at in (0..32).step_by(width as usize) {
            let subtracts = match op {
                O::Add16 | O::Add8 => false,
                O::Sub16 | O::Sub8 => true,
                O::Asx => at == 0,
                O::Sax => at == 16,
            };
            let (a, b) = (lane(n, at), lane(m, at));
            let exact = if subtracts { a - b } else { a + b };
            let (low, high) = match signed {
                true => (-(1 << (width - 1)), (1 << (width - 1)) - 1),
                false => (0, (1_i64 << width) - 1),
            };
            let value = match kind {
                K::Signed | K::Unsigned => exact,
                K::SignedSaturated | K::UnsignedSaturated => exact.clamp(low, high),
                K::SignedHalved | K::UnsignedHalved => exact >> 1,
            };
            let mask = u32::MAX >> (32 - width);
            result |= (value as u32 & mask) << at;
            let greater_equal = match kind {
                K::Unsigned if !subtracts => exact > high,
                _ => exact >= 0,
            };
            let flag = if width == 8 { 0b1 } else { 0b11 };
            flags |= (u8::from(greater_equal) * flag) << (at / 8);
        }
        if matches!(kind, K::Signed | K::Unsigned) {
            self.registers.flags.greater_equal = flags;
        }
        result
    }
}

/// The sum or difference of the products of the half-words.
fn dual(n: u32, m: u32, subtracts: bool, exchanges: bool) -> i64 {
    let m = if exchanges { m.rotate_left(16) } else { m };
    let [low, high] = [false, true].map(|top| half(n, top) * half(m, top));
    if subtracts { low - high } else { low + high }
}
