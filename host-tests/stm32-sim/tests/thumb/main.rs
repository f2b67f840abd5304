//! The simulated Cortex-M3 against an independent judge: the same random instructions in Unicorn
//! (`host-tests/clients/thumb_judge.py`).
//!
//! A sample is a short straight program, with IT blocks, which may end with a branch, on random registers and flags; most registers
//! point into RAM. Compared are all registers, the flags and all of RAM. Words that the decoder says are UNDEFINED must be refused
//! by the judge as well.
//!
//! Not sampled are, by rule:
//! - what is UNPREDICTABLE, in the words of the decoder;
//! - what faults, which the judge and the chip handle differently: there a NOP takes its place;
//! - what only means something with exceptions, sleep or a debugger, of which the judge has none;
//! - what may leave the low two bits of SP set: they always read as 0 (ARM ARM B1.4.1), but the judge keeps them;
//! - YIELD, which is a NOP (A7.7.264) and makes the judge stop;
//! - accesses to a bit-band alias, which the judge has not: it skips the sample;
//! - DSP, floating point and Advanced SIMD, which are UNDEFINED here (A1.3), but which the judge has in every model;
//! - stores relative to PC, which the judge executes ("if Rn == '1111' then UNDEFINED", A7.7.161);
//! - LDREX but in a pair with its STREX: whether the monitor compares addresses is IMPLEMENTATION DEFINED (ARM ARM A3.4.1).

mod sample;

use host_tests::python;
use sample::{Random, Sampler};
use std::path::Path;
use stm32_sim::cortex_m3::decode;
use stm32_sim::cortex_m3::decode::instruction::Instruction;

/// Programs that run.
const PROGRAMS: usize = 6000;
/// Single instructions, with an eye to branches.
const SINGLES: usize = 6000;
/// UNDEFINED words.
const UNDEFINED: usize = 3000;
const SEED: u64 = 0x0103_C8B1_0E51_11E5;

#[test]
fn an_independent_emulator_agrees() {
    let mut sampler = Sampler::new(SEED);
    for _ in 0..PROGRAMS {
        sampler.program();
    }
    for _ in 0..SINGLES {
        sampler.single();
    }
    for _ in 0..UNDEFINED {
        sampler.undefined();
    }
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("thumb-samples");
    std::fs::write(&path, sampler.finish()).expect("the samples are written");
    let path = path.to_str().expect("the path is text");
    python::run("thumb_judge.py", &["unicorn"], &[path]);
}

/// The samples are worth something: of every kind of instruction that is judged there are many.
#[test]
fn every_kind_of_instruction_is_sampled() {
    let mut random = Random::new(SEED);
    let mut kinds = std::collections::BTreeMap::<String, usize>::new();
    for _ in 0..1_000_000 {
        let (first, second) = random.encoding();
        let instruction = decode::decode(first, second).instruction;
        if !matches!(
            instruction,
            Instruction::Undefined(_) | Instruction::Unpredictable(_)
        ) {
            let text = format!("{instruction:?}");
            let kind = text.split([' ', '(']).next().unwrap_or_default();
            *kinds.entry(kind.to_owned()).or_default() += 1;
        }
    }
    let rare: Vec<_> = kinds.iter().filter(|(_, count)| **count < 10).collect();
    assert!(rare.is_empty(), "{rare:?}");
    assert!(kinds.len() >= 50, "only {} kinds: {kinds:?}", kinds.len());
}
