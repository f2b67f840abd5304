//! Execution of instructions: dispatch and IT blocks. The functions are grouped as in chapter A4 of the ARM ARM.

mod branch;
mod data;
mod dsp;
mod load_store;
mod load_store_several;
mod multiply;
mod system;

use super::CortexM3;
use super::cache::Place;
use super::decode::instruction::{Instruction, ItRule, SetFlags};
use super::decode::rule::Rule;
use super::fault::{FaultKind, Result};
use super::scb::SCR;
use super::sleep::Sleep;
use super::timing::Cost;
use crate::io::Io;

impl CortexM3 {
    /// Executes an instruction outside IT blocks, or one whose condition is true.
    #[inline(always)]
    pub(super) fn execute(&mut self, io: &mut impl Io, instruction: &Instruction) -> Result<()> {
        use Instruction as I;
        match *instruction {
            I::DataImmediate {
                op,
                d,
                n,
                flags,
                carry,
                value,
            } => self.data_immediate(op, d, n, flags, carry, value),
            I::DataRegister { op, d, n, m, flags } => self.data_register(op, d, n, m, flags),
            I::DataShifted {
                op,
                d,
                n,
                m,
                flags,
                shift,
                amount,
            } => {
                self.data_shifted(op, d, n, flags, self.shifted(m, shift, amount));
            }
            I::CompareImmediate {
                op,
                n,
                carry,
                value,
            } => self.compare_immediate(op, n, carry, value),
            I::CompareRegister { op, n, m } => self.compare_register(op, n, m),
            I::CompareShifted {
                op,
                n,
                m,
                shift,
                amount,
            } => {
                self.compare_shifted(op, n, self.shifted(m, shift, amount));
            }
            I::ShiftByRegister {
                shift,
                d,
                n,
                m,
                flags,
            } => self.shift_by_register(shift, d, n, m, flags),
            I::MoveTop { d, value } => self.move_top(d, value),
            I::Address { d, offset } => self
                .registers
                .set(d, self.literal_base().wrapping_add_signed(offset)),
            I::ExtendRegister {
                kind,
                d,
                m,
                rotation,
            } => self.extend(kind, d, m, rotation),
            I::RearrangeBits { kind, d, m } => self.rearrange(kind, d, m),
            I::BitFieldExtract {
                signed,
                d,
                n,
                lsb,
                width,
            } => self.extract(signed, d, n, lsb, width),
            I::BitFieldInsert { d, n, lsb, width } => {
                self.insert(d, self.registers.get(n), lsb, width)
            }
            I::BitFieldClear { d, lsb, width } => self.insert(d, 0, lsb, width),
            I::Saturate {
                signed,
                d,
                n,
                bits,
                shift,
                amount,
            } => {
                let (value, _) = self.shifted(n, shift, amount);
                self.saturate(signed, d, value, bits);
            }
            I::Multiply { d, n, m, flags } => self.multiply(d, n, m, flags),
            I::MultiplyAdd { d, n, m, a } => self.multiply_add(d, n, m, a),
            I::MultiplySubtract { d, n, m, a } => self.multiply_subtract(d, n, m, a),
            I::MultiplyLong {
                signed,
                accumulate,
                low,
                high,
                n,
                m,
            } => {
                self.multiply_long(signed, accumulate, (low, high), (n, m));
            }
            I::Divide { signed, d, n, m } => return self.divide(signed, d, n, m),

            I::LoadOffset { size, t, n, offset } => {
                let address = self.registers.get(n).wrapping_add_signed(offset.into());
                return self.load_to(io, size, t, address);
            }
            I::LoadIndexed {
                size,
                t,
                n,
                index,
                offset,
            } => return self.load_indexed(io, size, t, n, index, offset),
            I::LoadRegister {
                size,
                t,
                n,
                m,
                shift,
            } => {
                let address = self.indexed_address(n, m, shift);
                return self.load_to(io, size, t, address);
            }
            I::LoadLiteral { size, t, offset } => {
                let address = self.literal_base().wrapping_add_signed(offset.into());
                return self.load_to(io, size, t, address);
            }
            I::StoreOffset { size, t, n, offset } => {
                let address = self.registers.get(n).wrapping_add_signed(offset.into());
                return self.store_value(io, size, address, self.registers.get(t));
            }
            I::StoreIndexed {
                size,
                t,
                n,
                index,
                offset,
            } => return self.store_indexed(io, size, t, n, index, offset),
            I::StoreRegister {
                size,
                t,
                n,
                m,
                shift,
            } => {
                let address = self.indexed_address(n, m, shift);
                return self.store_value(io, size, address, self.registers.get(t));
            }
            I::LoadDual {
                t,
                t2,
                n,
                index,
                offset,
            } => return self.load_dual(io, (t, t2), n, index, offset),
            I::StoreDual {
                t,
                t2,
                n,
                index,
                offset,
            } => return self.store_dual(io, (t, t2), n, index, offset),
            I::LoadMultiple {
                n,
                kind,
                write_back,
                list,
            } => {
                return self.load_multiple(io, n, kind, write_back, list);
            }
            I::StoreMultiple {
                n,
                kind,
                write_back,
                list,
            } => {
                return self.store_multiple(io, n, kind, write_back, list);
            }
            I::LoadExclusive { size, t, n, offset } => {
                return self.load_exclusive(io, size, t, n, offset);
            }
            I::StoreExclusive {
                size,
                d,
                t,
                n,
                offset,
            } => {
                return self.store_exclusive(io, size, (d, t), n, offset);
            }
            I::ClearExclusive => self.exclusive = false,

            I::Branch { offset } => self.branch(offset),
            I::BranchIf { condition, offset } => {
                if self.registers.flags.pass(condition) {
                    self.branch(offset);
                }
            }
            I::BranchLink { offset } => {
                self.link();
                self.branch(offset);
            }
            I::BranchExchange { m } => return self.branch_exchange(self.registers.get(m)),
            I::BranchLinkExchange { m } => {
                let target = self.registers.get(m);
                self.link();
                return self.branch_to_state(target);
            }
            I::MoveToPc { m } => self.next = self.registers.get(m) & !1,
            I::AddToPc { m } => self.add_to_pc(m),
            I::CompareBranch { n, zero, offset } => {
                if (self.registers.get(n) == 0) == zero {
                    self.branch(offset.into());
                }
            }
            I::TableBranch { n, m, half_words } => return self.table_branch(io, n, m, half_words),

            I::IfThen { state } => self.registers.it.0 = state,
            I::Nop => {}
            I::Barrier { instructions } => {
                self.drain();
                io.barrier();
                if instructions {
                    self.fetch.forget();
                }
            }
            I::WaitForInterrupt if self.system.sleeps_deeply() => {
                return Err(FaultKind::System(SCR, "Stop mode is not modelled").into());
            }
            I::WaitForInterrupt => self.sleep(Sleep::Interrupt),
            I::WaitForEvent => self.sleep(Sleep::Event),
            I::SendEvent => self.event = true,
            I::ChangeState {
                disable,
                primask,
                faultmask,
            } => self.change_state(disable, primask, faultmask),
            I::MoveFromSpecial { d, special } => {
                let value = self.special(special);
                self.registers.set(d, value);
            }
            I::MoveToSpecial { n, special } => self.set_special(special, self.registers.get(n)),
            I::SupervisorCall => return self.supervisor_call(),
            I::Breakpoint(number) => self.stop_at_bkpt(number),
            I::Dsp(dsp) => self.execute_dsp(dsp),
            I::Undefined(rule) => return Err(FaultKind::Undefined(rule).into()),
            I::Unpredictable(rule) => return Err(FaultKind::Unpredictable(rule).into()),
        }
        Ok(())
    }

    /// Executes any instruction and charges its cycles: the instruction loop calls it only in rare cases.
    #[inline(never)]
    pub(super) fn execute_apart(&mut self, io: &mut impl Io, place: &Place) -> Result<()> {
        let after = self.next;
        let executed = if self.registers.it.is_active() {
            self.execute_in_it_block(io, place)?
        } else {
            self.execute(io, &place.instruction)?;
            true
        };
        let cost = if executed { &place.cost } else { &Cost::ONE };
        self.charge(after, cost);
        Ok(())
    }

    /// Executes or skips an instruction in an IT block; true if it executes. BKPT ignores the condition (A7.7.17).
    fn execute_in_it_block(&mut self, io: &mut impl Io, place: &Place) -> Result<bool> {
        let it = self.registers.it;
        let refuse = |rule| Err(FaultKind::Unpredictable(rule).into());
        match place.it {
            ItRule::Outside => return refuse(Rule::InItBlock),
            ItRule::Last if !it.is_last() => return refuse(Rule::NotLastInItBlock),
            _ => {}
        }
        let always = matches!(place.instruction, Instruction::Breakpoint(_));
        if !self.registers.flags.pass(it.condition()) && !always {
            self.registers.it = it.next();
            return Ok(false);
        }
        // Advances ITSTATE first, because an exception or an exception return saves or restores it.
        self.registers.it = it.next();
        self.in_it_block = true;
        let result = self.execute(io, &place.instruction);
        self.in_it_block = false;
        if result.is_err()
            || std::mem::take(&mut self.abandoned)
            || self
                .pause
                .is_some_and(|pause| matches!(pause, super::Pause::Bkpt(_)))
        {
            self.registers.it = it;
        }
        result.map(|()| true)
    }

    /// True if an instruction writes the flags.
    #[inline(always)]
    fn sets(&self, flags: SetFlags) -> bool {
        match flags {
            SetFlags::No => false,
            SetFlags::Yes => true,
            SetFlags::OutsideIt => !self.in_it_block,
        }
    }
}
