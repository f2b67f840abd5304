//! Compares the simulated Cortex-M3 and M4 with an independent emulator: the same random instructions in Unicorn
//! (`host-tests/clients/thumb_judge.py`).
//!
//! A sample is a short program without loops, with IT blocks, which may end with a branch, with random registers and flags; most
//! registers point into RAM. The test compares all registers, the flags and all of RAM. Unicorn must also refuse words that the
//! decoder reports as UNDEFINED.
//!
//! Samples exclude:
//! - UNPREDICTABLE instructions, as reported by the decoder;
//! - instructions that fault, which Unicorn and the chip handle differently: a NOP replaces them;
//! - instructions for exceptions, sleep or a debugger, which Unicorn does not have;
//! - instructions that may set the low two bits of SP: they always read as 0 (ARM ARM B1.4.1), but Unicorn keeps them;
//! - YIELD, which is a NOP (A7.7.264) and stops Unicorn;
//! - accesses to a bit-band alias, which Unicorn does not have: it skips the sample;
//! - floating point and Advanced SIMD, and on the Cortex-M3 DSP, which are UNDEFINED here (A1.3), but which Unicorn has in every
//!   model;
//! - stores relative to PC, which Unicorn executes ("if Rn == '1111' then UNDEFINED", A7.7.161);
//! - LDREX, except in a pair with its STREX: the monitor may compare addresses, which is IMPLEMENTATION DEFINED (ARM ARM A3.4.1).

mod sample;

use host_tests::python;
use sample::{Random, Sampler};
use std::path::Path;
use stm32_sim::cortex_m::Model;
use stm32_sim::cortex_m::decode::instruction::Instruction;

/// The number of programs that run.
const PROGRAMS: usize = 6000;
/// Single instructions, many of them branches.
const SINGLES: usize = 6000;
/// The number of UNDEFINED words.
const UNDEFINED: usize = 3000;
const SEED: u64 = 0x0103_C8B1_0E51_11E5;

#[test]
fn random_programs_match_independent_emulator() {
    compare(Model::CortexM3, "m3");
}

#[test]
fn random_programs_with_dsp_match_independent_emulator() {
    compare(Model::CortexM4, "m4");
}

fn compare(model: Model, name: &str) {
    let mut sampler = Sampler::new(model, SEED);
    for _ in 0..PROGRAMS {
        sampler.program();
    }
    for _ in 0..SINGLES {
        sampler.single();
    }
    for _ in 0..UNDEFINED {
        sampler.undefined();
    }
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("thumb-samples-{name}"));
    std::fs::write(&path, sampler.finish()).expect("the samples are written");
    let path = path.to_str().expect("the path is text");
    python::run("thumb_judge.py", &["unicorn"], &[name, path]);
}

/// Checks the coverage: there are many samples of every compared kind of instruction.
#[test]
fn samples_cover_every_kind_of_instruction() {
    covered(Model::CortexM3, 50);
}

#[test]
fn samples_cover_every_kind_of_instruction_with_dsp() {
    covered(Model::CortexM4, 65);
}

fn covered(model: Model, least: usize) {
    let mut random = Random::new(model, SEED);
    let mut kinds = std::collections::BTreeMap::<String, usize>::new();
    for _ in 0..1_000_000 {
        let (first, second) = random.encoding();
        let instruction = model.decode(first, second).instruction;
        if !matches!(
            instruction,
            Instruction::Undefined(_) | Instruction::Unpredictable(_)
        ) {
            let text = format!("{instruction:?}");
            let text = text.trim_start_matches("Dsp(");
            let kind = text.split([' ', '(']).next().unwrap_or_default();
            *kinds.entry(kind.to_owned()).or_default() += 1;
        }
    }
    let rare: Vec<_> = kinds.iter().filter(|(_, count)| **count < 10).collect();
    assert!(rare.is_empty(), "{rare:?}");
    assert!(
        kinds.len() >= least,
        "only {} kinds: {kinds:?}",
        kinds.len()
    );
}
