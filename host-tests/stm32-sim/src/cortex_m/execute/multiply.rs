//! Multiplication and division (ARM ARM A4.4.3, A4.4.7).

use super::super::CortexM3;
use super::super::decode::instruction::{Register, SetFlags};
use super::super::fault::{FaultKind, Result};

/// The absolute value of an operand.
fn magnitude(signed: bool, operand: u32) -> u32 {
    if signed {
        (operand as i32).unsigned_abs()
    } else {
        operand
    }
}

impl CortexM3 {
    fn product(&self, n: Register, m: Register) -> u32 {
        self.registers.get(n).wrapping_mul(self.registers.get(m))
    }

    /// MUL. C and V do not change.
    pub(super) fn multiply(&mut self, d: Register, n: Register, m: Register, flags: SetFlags) {
        let result = self.product(n, m);
        if self.sets(flags) {
            self.registers.flags.set_result(result);
        }
        self.registers.set(d, result);
    }

    pub(super) fn multiply_add(&mut self, d: Register, n: Register, m: Register, a: Register) {
        let sum = self.registers.get(a).wrapping_add(self.product(n, m));
        self.registers.set(d, sum);
    }

    pub(super) fn multiply_subtract(&mut self, d: Register, n: Register, m: Register, a: Register) {
        let difference = self.registers.get(a).wrapping_sub(self.product(n, m));
        self.registers.set(d, difference);
    }

    /// SMULL, UMULL, SMLAL, UMLAL.
    pub(super) fn multiply_long(
        &mut self,
        signed: bool,
        accumulate: bool,
        (low, high): (Register, Register),
        (n, m): (Register, Register),
    ) {
        let (a, b) = (self.registers.get(n), self.registers.get(m));
        if let Some(cycles) = &self.cycles {
            let operands = [a, b].map(|operand| magnitude(signed, operand));
            self.cycle += cycles.long_multiply(accumulate, operands) - 1;
        }
        let product = if signed {
            (i64::from(a as i32) * i64::from(b as i32)) as u64
        } else {
            u64::from(a) * u64::from(b)
        };
        let before = u64::from(self.registers.get(high)) << 32 | u64::from(self.registers.get(low));
        let result = product.wrapping_add(if accumulate { before } else { 0 });
        self.registers.set(low, result as u32);
        self.registers.set(high, (result >> 32) as u32);
    }

    /// SDIV and UDIV round towards zero. Division by zero gives 0 unless CCR.DIV_0_TRP is set; the lowest number divided by -1 is
    /// itself.
    pub(super) fn divide(
        &mut self,
        signed: bool,
        d: Register,
        n: Register,
        m: Register,
    ) -> Result<()> {
        let (a, b) = (self.registers.get(n), self.registers.get(m));
        if b == 0 && self.system.traps_division_by_zero() {
            return Err(FaultKind::DivisionByZero.into());
        }
        if let Some(cycles) = &self.cycles {
            self.cycle += cycles.divide(magnitude(signed, a), magnitude(signed, b)) - 1;
        }
        let result = match (b, signed) {
            (0, _) => 0,
            (_, true) => (a as i32).wrapping_div(b as i32) as u32,
            (_, false) => a / b,
        };
        self.registers.set(d, result);
        Ok(())
    }
}
