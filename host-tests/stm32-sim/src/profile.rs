//! Counts the instructions and cycles of function calls, with breakpoints at the first instruction and at the return address.

use super::cortex_m::CortexM3;

/// Register numbers.
const SP: u8 = 13;
const LR: u8 = 14;

/// One call of a watched function.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Call {
    /// The name under which it is watched.
    pub function: &'static str,
    /// Instructions from its first one to its return, with nested calls, without interrupts.
    pub instructions: u64,
    /// Cycles of the same, sleep and busy flash included.
    pub cycles: u64,
    /// The processor cycle of its first instruction.
    pub start: u64,
    /// The processor cycle of its return.
    pub end: u64,
    /// The nesting depth among watched calls.
    pub depth: usize,
    /// R0 at its return: the result, if it fits into a word.
    pub result: u32,
}

/// A call that has not returned.
#[derive(Clone, Copy, Debug)]
struct Open {
    function: &'static str,
    return_to: u32,
    stack: u32,
    instructions: u64,
    cycles: u64,
    start: u64,
}

/// Watches functions.
#[derive(Debug, Default)]
pub struct Profile {
    functions: Vec<(&'static str, u32)>,
    open: Vec<Open>,
    calls: Vec<Call>,
}

impl Profile {
    /// Watches the function that begins at `address`.
    pub fn watch(&mut self, core: &mut CortexM3, name: &'static str, address: u32) {
        self.functions.push((name, address));
        core.add_breakpoint(address);
    }

    /// The calls that have ended since the last call of this function.
    pub fn take(&mut self) -> Vec<Call> {
        std::mem::take(&mut self.calls)
    }

    /// The processor is being reset: open calls will not return.
    pub fn reset(&mut self, core: &mut CortexM3) {
        for call in std::mem::take(&mut self.open) {
            self.release(core, call.return_to);
        }
    }

    /// The processor has stopped at a breakpoint: a call begins or ends there, or both.
    pub fn stopped(&mut self, core: &mut CortexM3) {
        let pc = core.pc();
        while let Some(call) = self.open.last().copied()
            && call.return_to == pc
            && core.register(SP) == call.stack
        {
            self.open.pop();
            self.release(core, pc);
            self.calls.push(Call {
                function: call.function,
                instructions: core.thread_instructions() - call.instructions,
                cycles: core.thread_cycles() - call.cycles,
                start: call.start,
                end: core.cycle(),
                depth: self.open.len(),
                result: core.register(0),
            });
        }
        let begins = self.functions.iter().find(|(_, address)| *address == pc);
        if let Some((function, _)) = begins {
            let return_to = core.register(LR) & !1;
            self.open.push(Open {
                function,
                return_to,
                stack: core.register(SP),
                instructions: core.thread_instructions(),
                cycles: core.thread_cycles(),
                start: core.cycle(),
            });
            core.add_breakpoint(return_to);
        }
    }

    /// Removes a breakpoint that is no longer used.
    fn release(&self, core: &mut CortexM3, address: u32) {
        let waited = self.open.iter().any(|call| call.return_to == address);
        let begins = self.functions.iter().any(|(_, first)| *first == address);
        if !waited && !begins {
            core.remove_breakpoint(address);
        }
    }
}
