//! Random programs and their results in the simulated processor, in the format of `host-tests/clients/thumb_judge.py`.
//!
//! The file: all of RAM before each sample; then for each sample its kind (0 runs, 1 refused), the number of instructions to
//! execute (0: until the end of the code), bytes of code, the code, R0 to R15 and xPSR before and after, the number of changed
//! bytes of RAM (16 bits), and each with its offset (16 bits) and value.

use stm32_sim::cortex_m::decode::instruction::{Instruction, ItRule, Register};
use stm32_sim::cortex_m::decode::rule::Rule;
use stm32_sim::cortex_m::decode::{self};
use stm32_sim::cortex_m::{CortexM3, FaultKind, MemorySizes, Model, Pause};
use stm32_sim::io::NoPeripherals;

const CODE: u32 = 0x0800_0400;
/// Unicorn has this much memory for code.
const CODE_SIZE: usize = 0x80;
const RAM: u32 = 0x2000_0000;
const RAM_SIZE: usize = 0x5000;
const LONGEST: usize = 12;
const NOP: u16 = 0xBF00;
/// A hint that stops Unicorn.
const YIELD: [&[u16]; 2] = [&[0xBF10], &[0xF3AF, 0x8001]];
const CLREX: [u16; 2] = [0xF3BF, 0x8F2F];

/// The fixed bits of a group of encodings: masks and values of both half-words.
type Group = (u16, u16, u16, u16);

/// The groups of the DSP extension and of the divisions, which the other groups rarely contain.
const DSP: [Group; 9] = [
    (0xFFD0, 0xFB90, 0xF0F0, 0xF0F0),
    (0xFFF0, 0xEAC0, 0x8010, 0),
    (0xFF80, 0xFA00, 0xF0C0, 0xF080),
    (0xFF80, 0xFA80, 0xF080, 0xF000),
    (0xFFC0, 0xFA80, 0xF0C0, 0xF080),
    (0xFF80, 0xFB00, 0x00C0, 0),
    (0xFFE0, 0xFBC0, 0x0080, 0x0080),
    (0xFFF0, 0xFBE0, 0x00F0, 0x0060),
    (0xFF70, 0xF320, 0xF0F0, 0),
];

/// Numbers from a seed (SplitMix64).
pub struct Random {
    model: Model,
    state: u64,
}

impl Random {
    pub fn new(model: Model, seed: u64) -> Self {
        Self { model, state: seed }
    }

    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }

    fn half_word(&mut self) -> u16 {
        self.next() as u16
    }

    /// Two half-words: random, or from a group of 32-bit instructions that random words would seldom hit.
    pub fn encoding(&mut self) -> (u16, u16) {
        const GROUPS: [Group; 16] = [
            (0xF800, 0xE800, 0, 0),
            (0xFA00, 0xF000, 0x8000, 0),
            (0xFE00, 0xEA00, 0x8000, 0),
            (0xFB00, 0xF300, 0x8000, 0),
            (0xFE00, 0xF800, 0, 0),
            (0xFE80, 0xF800, 0x0FC0, 0),
            (0xFF80, 0xFA00, 0xF0F0, 0xF000),
            (0xFF80, 0xFA00, 0xF0C0, 0xF080),
            (0xFFC0, 0xFA80, 0xF0C0, 0xF080),
            (0xFF80, 0xFB00, 0x00E0, 0),
            (0xFF80, 0xFB80, 0x0000, 0),
            (0xFF80, 0xF380, 0xD000, 0x8000),
            (0xFFF0, 0xF380, 0xFFFC, 0x8800),
            (0xFFFF, 0xF3EF, 0xF0FC, 0x8000),
            (0xFFFF, 0xF36F, 0x8020, 0),
            (0xFF0F, 0xBF00, 0, 0),
        ];
        let (first, second) = (self.half_word(), self.half_word());
        if self.below(2) == 0 {
            return (first, second);
        }
        let group = if self.model == Model::CortexM4 && self.below(2) == 0 {
            DSP[self.below(9) as usize]
        } else {
            GROUPS[self.below(16) as usize]
        };
        let (mask, value, second_mask, second_value) = group;
        (first & !mask | value, second & !second_mask | second_value)
    }

    /// A value of a register: mostly an address in the middle of RAM, or a small number.
    fn register(&mut self) -> u32 {
        let any = self.next();
        match any >> 32 & 7 {
            0..=3 => RAM + 0x2000 + (any as u32 & 0xFFC),
            4 => any as u32 & 0x3F,
            5 => [0, 1, 0x7FFF_FFFF, 0x8000_0000, u32::MAX, 0xFF, 0xFFFF][(any % 7) as usize],
            _ => any as u32,
        }
    }
}

/// The half-words of an instruction.
type Words = Vec<u16>;

/// Makes random instructions of each kind.
pub struct Sampler {
    random: Random,
    processor: CortexM3,
    ram: Vec<u8>,
    file: Vec<u8>,
}

impl Sampler {
    pub fn new(model: Model, seed: u64) -> Self {
        let mut random = Random::new(model, seed);
        let ram: Vec<u8> = (0..RAM_SIZE).map(|_| random.next() as u8).collect();
        let file = ram.clone();
        let sizes = MemorySizes {
            flash: 0x1_0000,
            ram: RAM_SIZE,
            ram_repeats: false,
        };
        let mut processor = CortexM3::with(model, sizes);
        // The runs count instructions.
        processor.set_cycles(None);
        Self {
            random,
            processor,
            ram,
            file,
        }
    }

    pub fn finish(self) -> Vec<u8> {
        self.file
    }

    /// A program of some instructions, the last of which may be a branch.
    pub fn program(&mut self) {
        let mut program: Vec<Words> = Vec::new();
        while program.len() < LONGEST {
            match self.random.below(8) {
                0 => self.it_block(&mut program),
                1 => self.exclusive_pair(&mut program),
                _ => program.push(self.instruction(|it| it == ItRule::Anywhere)),
            }
        }
        self.run(program, false);
    }

    /// One instruction of any kind.
    pub fn single(&mut self) {
        let instruction = self.instruction(|_| true);
        self.run(vec![instruction], true);
    }

    /// A word that is UNDEFINED.
    pub fn undefined(&mut self) {
        let code = loop {
            let (first, second) = self.random.encoding();
            let decoded = self.random.model.decode(first, second);
            match decoded.instruction {
                // Unicorn has these extensions on every model, and executes stores relative to PC.
                Instruction::Undefined(
                    Rule::DspExtension | Rule::FloatingPoint | Rule::AdvancedSimd | Rule::StoreToPc,
                ) => {}
                Instruction::Undefined(Rule::NoCoprocessor) if is_floating_point(second) => {}
                Instruction::Undefined(_) if is_dual_exclusive(first, second) => {}
                Instruction::Undefined(_) if is_set_endianness(first) => {}
                Instruction::Undefined(_) => break words(first, second),
                _ => {}
            }
        };
        let before = self.state();
        self.write(1, 1, &code, &before, &before);
    }

    /// An instruction that can be compared and is permitted at this position.
    fn instruction(&mut self, allowed: impl Fn(ItRule) -> bool) -> Words {
        loop {
            let (first, second) = self.random.encoding();
            let decoded = self.random.model.decode(first, second);
            let words = words(first, second);
            let judged = is_judged(decoded.instruction) && !YIELD.contains(&words.as_slice());
            if judged && allowed(decoded.it) {
                return words;
            }
        }
    }

    /// IT with one to four instructions.
    fn it_block(&mut self, program: &mut Vec<Words>) {
        let state = self.random.below(0xE0) as u16;
        if state & 0xF == 0 {
            return;
        }
        program.push(vec![0xBF00 | state]);
        for _ in (state & 0xF).trailing_zeros()..4 {
            program.push(self.instruction(|it| it == ItRule::Anywhere));
        }
    }

    /// LDREX and STREX of the same word, half-word or byte.
    fn exclusive_pair(&mut self, program: &mut Vec<Words>) {
        // R12 is stored, R0 loaded, R1 is the status; the base is R4 to R7.
        let n = 4 + self.random.below(4) as u16;
        let (load, store) = match self.random.below(3) {
            0 => {
                let offset = self.random.below(4) as u16;
                ([0xE850 | n, 0x0F00 | offset], [0xE840 | n, 0xC100 | offset])
            }
            1 => ([0xE8D0 | n, 0x0F4F], [0xE8C0 | n, 0xCF41]),
            _ => ([0xE8D0 | n, 0x0F5F], [0xE8C0 | n, 0xCF51]),
        };
        program.extend([load.to_vec(), store.to_vec(), CLREX.to_vec()]);
    }

    /// Random registers and flags: R0 to R15, xPSR.
    fn state(&mut self) -> [u32; 17] {
        let mut state = std::array::from_fn(|_| self.random.register());
        state[13] = RAM + 0x2800 + (state[13] & 0x3FC);
        state[15] = CODE;
        state[16] = (self.random.next() as u32 & 0xF800_0000) | 1 << 24;
        state
    }

    /// Runs a program and writes the sample; a NOP replaces an instruction that faults.
    fn run(&mut self, mut program: Vec<Words>, counted: bool) {
        let before = self.state();
        for _ in 0..program.len() + 1 {
            let code = program.concat();
            assert!(code.len() * 2 <= CODE_SIZE);
            self.load(&code, &before);
            let start = self.processor.cycle();
            let end = start + program.len() as u64;
            match self.processor.run(&mut NoPeripherals, end) {
                Ok(pause) => {
                    assert_eq!(pause, Pause::Reached);
                    let after = self.read_state();
                    // Execute Never (ARM ARM B3.1): Unicorn reports the fault at the branch.
                    if matches!(after[15], 0x4000_0000..0x6000_0000 | 0xA000_0000..) {
                        return;
                    }
                    let count = if counted { program.len() as u8 } else { 0 };
                    self.write(0, count, &code, &before, &after);
                    return;
                }
                Err(fault) => {
                    let refused = matches!(
                        fault.kind,
                        FaultKind::Undefined(_) | FaultKind::Unpredictable(_)
                    );
                    assert!(!refused, "{fault}");
                    let mut address = CODE;
                    let faulty = program.iter_mut().find(|words| {
                        address += 2 * words.len() as u32;
                        address > fault.pc
                    });
                    faulty.expect("it is in the program").fill(NOP);
                    let split = program.iter().flat_map(|words| {
                        let chunk = if words[0] == NOP { 1 } else { words.len() };
                        words.chunks(chunk).map(<[u16]>::to_vec)
                    });
                    program = split.collect();
                }
            }
        }
    }

    fn load(&mut self, code: &[u16], state: &[u32; 17]) {
        let processor = &mut self.processor;
        let mut bytes: Vec<u8> = code.iter().flat_map(|word| word.to_le_bytes()).collect();
        bytes.resize(CODE_SIZE, 0xFF);
        assert!(processor.load(CODE, &bytes) && processor.load(RAM, &self.ram));
        processor.reset();
        for (number, value) in (0..).zip(&state[..16]) {
            processor.set_register(number, *value);
        }
        processor.set_xpsr(state[16]);
    }

    fn read_state(&self) -> [u32; 17] {
        std::array::from_fn(|number| match number {
            16 => self.processor.xpsr(),
            _ => self.processor.register(number as u8),
        })
    }

    fn write(
        &mut self,
        verdict: u8,
        count: u8,
        code: &[u16],
        before: &[u32; 17],
        after: &[u32; 17],
    ) {
        let code: Vec<u8> = code.iter().flat_map(|word| word.to_le_bytes()).collect();
        self.file.extend([verdict, count, code.len() as u8]);
        self.file.extend(code);
        for word in before.iter().chain(after) {
            self.file.extend(word.to_le_bytes());
        }
        let memory = self.processor.bytes(RAM, RAM_SIZE).expect("it is there");
        let changes: Vec<(u16, u8)> = (0..)
            .zip(self.ram.iter().zip(memory))
            .filter(|(_, (old, new))| verdict == 0 && old != new)
            .map(|(offset, (_, new))| (offset, *new))
            .collect();
        self.file.extend((changes.len() as u16).to_le_bytes());
        for (offset, value) in changes {
            self.file.extend(offset.to_le_bytes());
            self.file.push(value);
        }
    }
}

fn words(first: u16, second: u16) -> Words {
    if decode::is_wide(first) {
        vec![first, second]
    } else {
        vec![first]
    }
}

/// Coprocessors 10 and 11 are the floating-point extension (ARM ARM A5.3.18).
const fn is_floating_point(second: u16) -> bool {
    second >> 9 & 0b111 == 0b101
}

/// LDREXD and STREXD, which only other profiles have (ARM ARM A5.3.6): Unicorn executes them.
const fn is_dual_exclusive(first: u16, second: u16) -> bool {
    first & 0xFFE0 == 0xE8C0 && second & 0xF0 == 0x70
}

/// SETEND, which only other profiles have (ARM ARM A5.2.5): Unicorn executes it.
const fn is_set_endianness(first: u16) -> bool {
    first & 0xFFF7 == 0xB650
}

/// True if Unicorn can execute an instruction comparably: see the list at the test.
fn is_judged(instruction: Instruction) -> bool {
    match instruction {
        Instruction::Undefined(_) | Instruction::Unpredictable(_) => false,
        Instruction::WaitForInterrupt
        | Instruction::WaitForEvent
        | Instruction::SendEvent
        | Instruction::SupervisorCall
        | Instruction::Breakpoint(_)
        | Instruction::ChangeState { .. } => false,
        // Only the flags of the special registers.
        Instruction::MoveFromSpecial { special, .. }
        | Instruction::MoveToSpecial { special, .. } => special == 0,
        Instruction::LoadExclusive { .. } | Instruction::IfThen { .. } => false,
        _ => !may_misalign_stack(instruction),
    }
}

/// True if an instruction may write to SP a value whose low two bits are not 0. The chip clears them (ARM ARM B1.4.1), Unicorn
/// keeps them.
fn may_misalign_stack(instruction: Instruction) -> bool {
    const SP: Register = Register::SP;
    match instruction {
        Instruction::DataImmediate { d: SP, value, .. } => value % 4 != 0,
        Instruction::DataRegister { d: SP, .. }
        | Instruction::DataShifted { d: SP, .. }
        | Instruction::LoadOffset { t: SP, .. }
        | Instruction::LoadIndexed { t: SP, .. }
        | Instruction::LoadRegister { t: SP, .. }
        | Instruction::LoadLiteral { t: SP, .. } => true,
        Instruction::LoadIndexed { n: SP, offset, .. }
        | Instruction::StoreIndexed { n: SP, offset, .. } => offset % 4 != 0,
        _ => false,
    }
}
