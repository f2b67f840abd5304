//! The DSP extension of the Cortex-M4 (ARM ARM A5.3.12 to A5.3.17, A7.7): the encodings that the decoder of the Cortex-M3 reports as
//! [`Rule::DspExtension`].
//!
//! MSR with a mask for the GE bits is not modelled: it stays UNPREDICTABLE.

use super::instruction::{Decoded, Extend, Instruction, ItRule, Register, Shift};
use super::rule::Rule;
use super::{bit, bits, refuse_if, refuse_sp_and_pc, register, should_be, undefined};

/// An instruction of the extension. The registers are named as in the manual: `d` destination, `n` first operand, `m` second
/// operand, `a` accumulated.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[expect(missing_docs, reason = "the fields are those of the manual")]
pub enum Dsp {
    /// SADD16 and the 35 similar ones: two or four sums and differences.
    Parallel {
        kind: ParallelKind,
        op: ParallelOp,
        d: Register,
        n: Register,
        m: Register,
    },
    /// QADD, QDADD, QSUB, QDSUB: d = m + n or m - n, saturated; n can be doubled.
    Saturating {
        doubles: bool,
        subtracts: bool,
        d: Register,
        n: Register,
        m: Register,
    },
    /// SEL: bytes by the GE bits.
    Select {
        d: Register,
        n: Register,
        m: Register,
    },
    /// SXTAB, SXTAH, UXTAB, UXTAH: adds the extended value.
    ExtendAdd {
        kind: Extend,
        d: Register,
        n: Register,
        m: Register,
        rotation: u8,
    },
    /// SXTAB16, UXTAB16, SXTB16, UXTB16: extends two bytes; adds the half-words of `n`, if there is one.
    ExtendPair {
        signed: bool,
        d: Register,
        n: Option<Register>,
        m: Register,
        rotation: u8,
    },
    /// PKHBT, PKHTB: one half-word of each operand.
    Pack {
        top: bool,
        d: Register,
        n: Register,
        m: Register,
        amount: u8,
    },
    /// SSAT16, USAT16. `bits` is the width of each result.
    SaturatePair {
        signed: bool,
        d: Register,
        n: Register,
        bits: u8,
    },
    /// SMULxy, SMLAxy: the product of two half-words.
    Halves {
        n_top: bool,
        m_top: bool,
        d: Register,
        n: Register,
        m: Register,
        a: Option<Register>,
    },
    /// SMULWy, SMLAWy: the upper 32 of the 48 bits of a product of a word and a half-word.
    WordByHalf {
        top: bool,
        d: Register,
        n: Register,
        m: Register,
        a: Option<Register>,
    },
    /// SMUAD, SMLAD, SMUSD, SMLSD: the sum or difference of two products of half-words.
    Dual {
        subtracts: bool,
        exchanges: bool,
        d: Register,
        n: Register,
        m: Register,
        a: Option<Register>,
    },
    /// SMMUL, SMMLA, SMMLS: the upper half of a product.
    Top {
        subtracts: bool,
        rounds: bool,
        d: Register,
        n: Register,
        m: Register,
        a: Option<Register>,
    },
    /// USAD8, USADA8: the sum of the differences of the bytes.
    Differences {
        d: Register,
        n: Register,
        m: Register,
        a: Option<Register>,
    },
    /// SMLALxy: adds the product of two half-words to 64 bits.
    HalvesLong {
        n_top: bool,
        m_top: bool,
        low: Register,
        high: Register,
        n: Register,
        m: Register,
    },
    /// SMLALD, SMLSLD: adds the sum or the difference of two products of half-words to 64 bits.
    DualLong {
        subtracts: bool,
        exchanges: bool,
        low: Register,
        high: Register,
        n: Register,
        m: Register,
    },
    /// UMAAL: high:low = n * m + high + low.
    AccumulateTwice {
        low: Register,
        high: Register,
        n: Register,
        m: Register,
    },
}

/// The range and the form of the results of a parallel operation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ParallelKind {
    /// S: signed, sets the GE bits.
    Signed,
    /// Q: signed, with saturated results.
    SignedSaturated,
    /// SH: signed, with halved results.
    SignedHalved,
    /// U: unsigned, sets the GE bits.
    Unsigned,
    /// UQ: unsigned, with saturated results.
    UnsignedSaturated,
    /// UH: unsigned, with halved results.
    UnsignedHalved,
}

/// The sums and differences of a parallel operation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ParallelOp {
    /// ADD16: two sums of half-words.
    Add16,
    /// ASX: exchanges the half-words of the second operand; the lower result is the difference, the upper one the sum.
    Asx,
    /// SAX: exchanges the half-words of the second operand; the lower result is the sum, the upper one the difference.
    Sax,
    /// SUB16: two differences of half-words.
    Sub16,
    /// ADD8: four sums of bytes.
    Add8,
    /// SUB8: four differences of bytes.
    Sub8,
}

/// An instruction, or the reason why the encoding is forbidden.
type Entry = Result<Dsp, Instruction>;

/// Decodes an instruction of the extension. `decoded` is the result of the Cortex-M3 decoder, which reports it as UNDEFINED.
pub(in super::super) fn extend(decoded: Decoded, first: u16, second: u16) -> Decoded {
    let word = u32::from(first) << 16 | u32::from(second);
    let entry = match bits(word, 24, 8) {
        0xEA => pack(word),
        0xFA => register_operands(word),
        0xFB if bit(word, 23) => long_multiply(word),
        0xFB => multiply(word),
        _ => saturate_pair(word),
    };
    Decoded {
        instruction: entry.map_or_else(|refused| refused, Instruction::Dsp),
        it: ItRule::Anywhere,
        ..decoded
    }
}

/// A5.3.12 to A5.3.15.
fn register_operands(word: u32) -> Entry {
    let (d, n, m) = (register(word, 8), register(word, 16), register(word, 0));
    if !bit(word, 23) {
        return extend_and_add(word, d, n, m);
    }
    let low = bits(word, 4, 2);
    if bit(word, 7) {
        refuse_sp_and_pc(&[d, n, m])?;
        return match bits(word, 20, 2) {
            0b00 => Ok(Dsp::Saturating {
                doubles: low & 0b01 != 0,
                subtracts: low & 0b10 != 0,
                d,
                n,
                m,
            }),
            0b10 if low == 0 => Ok(Dsp::Select { d, n, m }),
            _ => undefined(Rule::Unallocated),
        };
    }
    let kind = match (bit(word, 6), low) {
        (false, 0b00) => ParallelKind::Signed,
        (false, 0b01) => ParallelKind::SignedSaturated,
        (false, 0b10) => ParallelKind::SignedHalved,
        (true, 0b00) => ParallelKind::Unsigned,
        (true, 0b01) => ParallelKind::UnsignedSaturated,
        (true, 0b10) => ParallelKind::UnsignedHalved,
        _ => return undefined(Rule::Unallocated),
    };
    let op = match bits(word, 20, 3) {
        0b001 => ParallelOp::Add16,
        0b010 => ParallelOp::Asx,
        0b110 => ParallelOp::Sax,
        0b101 => ParallelOp::Sub16,
        0b000 => ParallelOp::Add8,
        0b100 => ParallelOp::Sub8,
        _ => return undefined(Rule::Unallocated),
    };
    refuse_sp_and_pc(&[d, n, m])?;
    Ok(Dsp::Parallel { kind, op, d, n, m })
}

/// SXTAB, SXTAH, UXTAB, UXTAH, and the extensions of two bytes.
fn extend_and_add(word: u32, d: Register, n: Register, m: Register) -> Entry {
    should_be(word, 1 << 6, 0)?;
    refuse_sp_and_pc(&[d, m])?;
    refuse_if(n == Register::SP, Rule::StackPointerOrPc)?;
    let rotation = 8 * bits(word, 4, 2) as u8;
    let kind = match bits(word, 20, 3) {
        0b000 => Extend::SignedHalfWord,
        0b001 => Extend::HalfWord,
        0b100 => Extend::SignedByte,
        0b101 => Extend::Byte,
        pair => {
            return Ok(Dsp::ExtendPair {
                signed: pair == 0b010,
                d,
                n: unless_pc(n),
                m,
                rotation,
            });
        }
    };
    Ok(Dsp::ExtendAdd {
        kind,
        d,
        n,
        m,
        rotation,
    })
}

/// The register of an optional operand; the encoding of PC means that there is no operand.
fn unless_pc(register: Register) -> Option<Register> {
    (register != Register::PC).then_some(register)
}

/// PKHBT and PKHTB (A5.3.11).
fn pack(word: u32) -> Entry {
    if bit(word, 20) || bit(word, 4) {
        return undefined(Rule::Unallocated);
    }
    let (d, n, m) = (register(word, 8), register(word, 16), register(word, 0));
    should_be(word, 1 << 15, 0)?;
    refuse_sp_and_pc(&[d, n, m])?;
    let top = bit(word, 5);
    let amount = (bits(word, 12, 3) << 2 | bits(word, 6, 2)) as u8;
    // DecodeImmShift (A7.4.2): an amount of 0 means ASR by 32.
    let amount = if top && amount == 0 { 32 } else { amount };
    Ok(Dsp::Pack {
        top,
        d,
        n,
        m,
        amount,
    })
}

impl Dsp {
    /// The shift of the second operand of PKHBT and PKHTB.
    pub const fn pack_shift(top: bool) -> Shift {
        if top { Shift::Asr } else { Shift::Lsl }
    }
}

/// SSAT16 and USAT16 (A5.3.3).
fn saturate_pair(word: u32) -> Entry {
    should_be(word, 1 << 26 | 0b11 << 4, 0)?;
    let (d, n) = (register(word, 8), register(word, 16));
    refuse_sp_and_pc(&[d, n])?;
    let signed = !bit(word, 23);
    Ok(Dsp::SaturatePair {
        signed,
        d,
        n,
        bits: bits(word, 0, 4) as u8 + u8::from(signed),
    })
}

/// A5.3.16: products of 32 bits.
fn multiply(word: u32) -> Entry {
    let (d, n, m) = (register(word, 8), register(word, 16), register(word, 0));
    let a = unless_pc(register(word, 12));
    let (high, low) = (bit(word, 5), bit(word, 4));
    let dsp = match (bits(word, 20, 3), high) {
        (0b001, _) => Dsp::Halves {
            n_top: high,
            m_top: low,
            d,
            n,
            m,
            a,
        },
        (op @ (0b010 | 0b100), false) => Dsp::Dual {
            subtracts: op == 0b100,
            exchanges: low,
            d,
            n,
            m,
            a,
        },
        (0b011, false) => Dsp::WordByHalf {
            top: low,
            d,
            n,
            m,
            a,
        },
        (op @ (0b101 | 0b110), false) => {
            refuse_if(op == 0b110 && a.is_none(), Rule::StackPointerOrPc)?;
            Dsp::Top {
                subtracts: op == 0b110,
                rounds: low,
                d,
                n,
                m,
                a,
            }
        }
        (0b111, false) if !low => Dsp::Differences { d, n, m, a },
        _ => return undefined(Rule::Unallocated),
    };
    refuse_sp_and_pc(&[d, n, m])?;
    refuse_if(a == Some(Register::SP), Rule::StackPointerOrPc)?;
    Ok(dsp)
}

/// A5.3.17: sums of 64 bits.
fn long_multiply(word: u32) -> Entry {
    let (low, high) = (register(word, 12), register(word, 8));
    let (n, m) = (register(word, 16), register(word, 0));
    refuse_sp_and_pc(&[low, high, n, m])?;
    refuse_if(low == high, Rule::SameRegister)?;
    Ok(match (bits(word, 20, 3), bits(word, 4, 4)) {
        (0b110, _) => Dsp::AccumulateTwice { low, high, n, m },
        (0b100, 0b1000..=0b1011) => Dsp::HalvesLong {
            n_top: bit(word, 5),
            m_top: bit(word, 4),
            low,
            high,
            n,
            m,
        },
        (op, _) => Dsp::DualLong {
            subtracts: op == 0b101,
            exchanges: bit(word, 4),
            low,
            high,
            n,
            m,
        },
    })
}
