//! Data processing: arithmetic, logic, shifts, bit fields, extensions, saturation (ARM ARM A4.4).

use super::super::CortexM3;
use super::super::decode::instruction::{
    Carry, DataOp, Extend, Rearrange, Register, SetFlags, Shift,
};

/// A result with its flags C and V.
struct Outcome {
    value: u32,
    carry: bool,
    overflow: bool,
}

/// AddWithCarry (A2.2.1).
#[inline(always)]
fn add_with_carry(a: u32, b: u32, carry: bool) -> Outcome {
    let (value, carry) = a.carrying_add(b, carry);
    Outcome {
        value,
        carry,
        overflow: (a ^ value) & (b ^ value) & 1 << 31 != 0,
    }
}

/// Shift_C (A7.4.2) for any amount: shifts by a register can be 32 or more.
#[inline(always)]
fn shift(value: u32, shift: Shift, amount: u8, carry: bool) -> (u32, bool) {
    if amount == 0 {
        return (value, carry);
    }
    let amount = u32::from(amount);
    // The value and the bit that is shifted into the carry.
    match shift {
        Shift::Lsl => {
            let wide = u64::from(value).checked_shl(amount).unwrap_or(0);
            (wide as u32, wide >> 32 & 1 != 0)
        }
        Shift::Lsr => {
            let wide = (u64::from(value) << 32).checked_shr(amount).unwrap_or(0);
            ((wide >> 32) as u32, wide >> 31 & 1 != 0)
        }
        Shift::Asr => {
            let wide = (i64::from(value as i32) << 31) >> amount.min(32);
            ((wide >> 31) as u32, wide >> 30 & 1 != 0)
        }
        Shift::Ror => {
            let result = value.rotate_right(amount % 32);
            (result, result >> 31 != 0)
        }
        Shift::Rrx => (value >> 1 | u32::from(carry) << 31, value & 1 != 0),
    }
}

impl CortexM3 {
    /// A shifted register, and the carry of the shift.
    #[inline(always)]
    pub(super) fn shifted(&self, m: Register, kind: Shift, amount: u8) -> (u32, bool) {
        shift(
            self.registers.get(m),
            kind,
            amount,
            self.registers.flags.carry,
        )
    }

    /// The result of an operation; `carry` is that of the second operand.
    #[inline(always)]
    fn compute(&self, op: DataOp, a: u32, (b, carry): (u32, bool)) -> Outcome {
        let flags = &self.registers.flags;
        let logical = |value| Outcome {
            value,
            carry,
            overflow: flags.overflow,
        };
        match op {
            DataOp::And => logical(a & b),
            DataOp::Bic => logical(a & !b),
            DataOp::Orr => logical(a | b),
            DataOp::Orn => logical(a | !b),
            DataOp::Eor => logical(a ^ b),
            DataOp::Mov => logical(b),
            DataOp::Mvn => logical(!b),
            DataOp::Add => add_with_carry(a, b, false),
            DataOp::Adc => add_with_carry(a, b, flags.carry),
            DataOp::Sbc => add_with_carry(a, !b, flags.carry),
            DataOp::Sub => add_with_carry(a, !b, true),
            DataOp::Rsb => add_with_carry(!a, b, true),
        }
    }

    #[inline(always)]
    fn set_flags(&mut self, outcome: &Outcome) {
        let flags = &mut self.registers.flags;
        flags.set_result(outcome.value);
        flags.carry = outcome.carry;
        flags.overflow = outcome.overflow;
    }

    #[inline(always)]
    fn data(&mut self, op: DataOp, d: Register, n: Register, set: SetFlags, operand: (u32, bool)) {
        let outcome = self.compute(op, self.registers.get(n), operand);
        if self.sets(set) {
            self.set_flags(&outcome);
        }
        self.registers.set(d, outcome.value);
    }

    #[inline(always)]
    fn compare(&mut self, op: DataOp, n: Register, operand: (u32, bool)) {
        let outcome = self.compute(op, self.registers.get(n), operand);
        self.set_flags(&outcome);
    }

    #[inline(always)]
    fn immediate(&self, carry: Carry, value: u32) -> (u32, bool) {
        let carry = match carry {
            Carry::Keep => self.registers.flags.carry,
            Carry::Clear => false,
            Carry::Set => true,
        };
        (value, carry)
    }

    #[inline(always)]
    pub(super) fn data_immediate(
        &mut self,
        op: DataOp,
        d: Register,
        n: Register,
        flags: SetFlags,
        carry: Carry,
        value: u32,
    ) {
        self.data(op, d, n, flags, self.immediate(carry, value));
    }

    #[inline(always)]
    pub(super) fn data_register(
        &mut self,
        op: DataOp,
        d: Register,
        n: Register,
        m: Register,
        flags: SetFlags,
    ) {
        let operand = (self.registers.get(m), self.registers.flags.carry);
        self.data(op, d, n, flags, operand);
    }

    #[inline(always)]
    pub(super) fn data_shifted(
        &mut self,
        op: DataOp,
        d: Register,
        n: Register,
        flags: SetFlags,
        operand: (u32, bool),
    ) {
        self.data(op, d, n, flags, operand);
    }

    #[inline(always)]
    pub(super) fn compare_immediate(&mut self, op: DataOp, n: Register, carry: Carry, value: u32) {
        self.compare(op, n, self.immediate(carry, value));
    }

    #[inline(always)]
    pub(super) fn compare_register(&mut self, op: DataOp, n: Register, m: Register) {
        let operand = (self.registers.get(m), self.registers.flags.carry);
        self.compare(op, n, operand);
    }

    #[inline(always)]
    pub(super) fn compare_shifted(&mut self, op: DataOp, n: Register, operand: (u32, bool)) {
        self.compare(op, n, operand);
    }

    #[inline(always)]
    pub(super) fn shift_by_register(
        &mut self,
        kind: Shift,
        d: Register,
        n: Register,
        m: Register,
        flags: SetFlags,
    ) {
        let amount = self.registers.get(m) as u8;
        let operand = self.shifted(n, kind, amount);
        self.data(DataOp::Mov, d, n, flags, operand);
    }

    pub(super) fn move_top(&mut self, d: Register, value: u16) {
        let low = self.registers.get(d) & 0xFFFF;
        self.registers.set(d, u32::from(value) << 16 | low);
    }

    pub(super) fn extend(&mut self, kind: Extend, d: Register, m: Register, rotation: u8) {
        let value = self.registers.get(m).rotate_right(rotation.into());
        let result = match kind {
            Extend::SignedByte => i32::from(value as i8) as u32,
            Extend::SignedHalfWord => i32::from(value as i16) as u32,
            Extend::Byte => value & 0xFF,
            Extend::HalfWord => value & 0xFFFF,
        };
        self.registers.set(d, result);
    }

    pub(super) fn rearrange(&mut self, kind: Rearrange, d: Register, m: Register) {
        let value = self.registers.get(m);
        let result = match kind {
            Rearrange::ReverseBytes => value.swap_bytes(),
            Rearrange::ReverseBytesOfHalfWords => value.swap_bytes().rotate_left(16),
            Rearrange::ReverseSignedHalfWord => {
                i32::from((value as u16).swap_bytes() as i16) as u32
            }
            Rearrange::ReverseBits => value.reverse_bits(),
            Rearrange::CountLeadingZeros => value.leading_zeros(),
        };
        self.registers.set(d, result);
    }

    /// SBFX and UBFX; the field ends within the register.
    pub(super) fn extract(&mut self, signed: bool, d: Register, n: Register, lsb: u8, width: u8) {
        let unused = 32 - u32::from(width);
        let top = self.registers.get(n) << (unused - u32::from(lsb));
        let result = if signed {
            ((top as i32) >> unused) as u32
        } else {
            top >> unused
        };
        self.registers.set(d, result);
    }

    /// BFI, and BFC with a value of 0.
    pub(super) fn insert(&mut self, d: Register, value: u32, lsb: u8, width: u8) {
        let mask = (u32::MAX >> (32 - u32::from(width))) << lsb;
        let rest = self.registers.get(d) & !mask;
        self.registers.set(d, rest | value << lsb & mask);
    }

    /// SSAT and USAT to this many bits.
    pub(super) fn saturate(&mut self, signed: bool, d: Register, value: u32, bits: u8) {
        let value = i64::from(value as i32);
        let (low, high) = if signed {
            (-(1 << (bits - 1)), (1 << (bits - 1)) - 1)
        } else {
            (0, (1 << bits) - 1)
        };
        let result = value.clamp(low, high);
        self.registers.flags.saturated |= result != value;
        self.registers.set(d, result as u32);
    }
}
