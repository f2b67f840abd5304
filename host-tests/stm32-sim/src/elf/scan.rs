//! Finds the instructions in a firmware image that errata of its processor make unsafe.
//!
//! - Arm erratum 602117, Cortex-M3 before r2p1: LDRD with the base as its first destination. After an interrupt between the two loads it can
//!   start again with the wrong base.
//! - Arm erratum 776924, Cortex-M4: VDIV and VSQRT, under a short interrupt handler. No image has floating-point instructions.

use super::{Image, ImageError};
use crate::cortex_m::Model;
use crate::cortex_m::decode::instruction::Instruction;
use crate::cortex_m::decode::is_wide;
use crate::cortex_m::decode::rule::Rule;
use object::read::elf::ElfFile32;
use object::{Object, ObjectSection, ObjectSymbol, SectionKind};

/// True for an instruction that an erratum of this processor makes unsafe.
pub fn is_unsafe(model: Model, instruction: &Instruction) -> bool {
    match (model, instruction) {
        (Model::CortexM3, Instruction::LoadDual { t, n, .. }) => t == n,
        (Model::CortexM4, Instruction::Undefined(Rule::FloatingPoint)) => true,
        _ => false,
    }
}

/// The unsafe instructions in an ELF file, each with its address and function.
///
/// # Errors
/// [`ImageError`].
pub fn unsafe_instructions(elf: &[u8]) -> Result<Vec<String>, ImageError> {
    let image = Image::parse(elf)?;
    let model = image.board().chip().facts().processor;
    let file: ElfFile32 = ElfFile32::parse(elf)?;
    // The marks of the ABI: $t begins instructions, $d data.
    let mut marks: Vec<(u32, bool)> = file
        .symbols()
        .filter_map(|symbol| {
            let name = symbol.name().ok()?;
            let is_mark = |mark: &str| name == mark || name.starts_with(&format!("{mark}."));
            let address = symbol.address() as u32 & !1;
            (is_mark("$t") || is_mark("$d")).then_some((address, is_mark("$t")))
        })
        .collect();
    marks.sort_unstable();
    let mut found = Vec::new();
    for section in file
        .sections()
        .filter(|one| one.kind() == SectionKind::Text)
    {
        let start = section.address() as u32;
        let bytes = section.data()?;
        let end = start + bytes.len() as u32;
        let here = marks.iter().filter(|(at, _)| (start..end).contains(at));
        let here: Vec<_> = here.copied().collect();
        if here.is_empty() && start < end {
            return Err(ImageError::Marks(section.name()?.to_owned()));
        }
        for (number, (at, is_code)) in here.iter().enumerate() {
            if !is_code {
                continue;
            }
            let until = here.get(number + 1).map_or(end, |(next, _)| *next);
            let code = &bytes[(at - start) as usize..(until - start) as usize];
            for address in unsafe_in(model, *at, code) {
                let function = image.name_of(address).map_or("?", |(name, _)| name);
                found.push(format!("{address:#010x} in {function}"));
            }
        }
    }
    Ok(found)
}

/// The addresses of the unsafe instructions in code that begins at `start`.
fn unsafe_in(model: Model, start: u32, code: &[u8]) -> Vec<u32> {
    let (half_words, _) = code.as_chunks::<2>();
    let half_word = |at: usize| half_words.get(at).map_or(0, |two| u16::from_le_bytes(*two));
    let mut found = Vec::new();
    let mut at = 0;
    while at < half_words.len() {
        let decoded = model.decode(half_word(at), half_word(at + 1));
        if is_unsafe(model, &decoded.instruction) {
            found.push(start + 2 * at as u32);
        }
        at += if is_wide(half_word(at)) { 2 } else { 1 };
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(model: Model, half_words: &[u16]) -> Vec<u32> {
        let code: Vec<u8> = half_words.iter().flat_map(|it| it.to_le_bytes()).collect();
        unsafe_in(model, 0x100, &code)
    }

    #[test]
    fn load_pair_is_unsafe_with_base_as_first_destination() {
        // NOP; LDRD R0, R1, [R0]; LDRD R1, R0, [R0]; LDRD R1, R2, [R0]; STRD R0, R1, [R0]
        let code = [
            0xBF00, 0xE9D0, 0x0100, 0xE9D0, 0x1000, 0xE9D0, 0x1200, 0xE9C0, 0x0100,
        ];
        assert_eq!(found(Model::CortexM3, &code), [0x102]);
        assert!(found(Model::CortexM4, &code).is_empty());
    }

    #[test]
    fn floating_point_is_unsafe_on_the_cortex_m4() {
        // NOP; VDIV.F32 S0, S0, S1
        let code = [0xBF00, 0xEE80, 0x0A20];
        assert_eq!(found(Model::CortexM4, &code), [0x102]);
    }
}
