use super::*;
use embedded_can::Id;
use plumbline::can::{extended, standard};

const WIDE: bool = true;
const NARROW: bool = false;
const LIST: bool = true;
const MASK: bool = false;

/// A bank to be activated.
struct Bank {
    number: usize,
    wide: bool,
    list: bool,
    fifo: usize,
    words: [u32; 2],
}

impl Bank {
    fn new(number: usize, wide: bool, list: bool, words: [u32; 2]) -> Self {
        Self {
            number,
            wide,
            list,
            fifo: 0,
            words,
        }
    }

    fn of_fifo(self, fifo: usize) -> Self {
        Self { fifo, ..self }
    }
}

/// Configures the banks as software does, and leaves filter initialization.
fn set_up(banks: &[Bank]) -> Filters {
    let mut filters = Filters::default();
    let mut violations = Violations::default();
    let bits = |is: fn(&Bank) -> bool| {
        banks
            .iter()
            .filter(|bank| is(bank))
            .fold(0, |bits, bank| bits | 1 << bank.number)
    };
    for (register, value) in [
        (Register::FilterMode, bits(|bank| bank.list)),
        (Register::FilterScale, bits(|bank| bank.wide)),
        (Register::FilterFifo, bits(|bank| bank.fifo == 1)),
        (Register::FilterActivation, bits(|_| true)),
    ] {
        filters.write(register, value, &mut violations);
        assert_eq!(filters.read(register), value);
    }
    for bank in banks {
        for (half, word) in bank.words.into_iter().enumerate() {
            let number = bank.number;
            let register = Register::FilterBank { bank: number, half };
            filters.write(register, word, &mut violations);
            assert_eq!(filters.read(register), word);
        }
    }
    filters.write(Register::FilterMaster, 0, &mut violations);
    assert_eq!(violations.all, []);
    filters
}

fn data(id: Id) -> Frame {
    Frame::data(id, &[]).unwrap()
}

fn remote(id: Id) -> Frame {
    Frame::remote(id, 0).unwrap()
}

fn accepted(filters: &Filters, frame: Frame) -> Option<(usize, u8)> {
    filters
        .accept(&frame)
        .map(|found| (found.fifo, found.index))
}

/// A standard identifier in the format of a 32-bit filter.
fn wide(id: u32) -> u32 {
    id << 21
}

/// Two standard identifiers in the format of 16-bit filters.
fn narrow_pair(low: u32, high: u32) -> u32 {
    high << 21 | low << 5
}

#[test]
fn wide_mask_compares_only_set_bits() {
    let filters = set_up(&[Bank::new(0, WIDE, MASK, [wide(0x120), wide(0x7F0) | 0b100])]);
    assert_eq!(accepted(&filters, data(standard(0x12F))), Some((0, 0)));
    assert_eq!(accepted(&filters, remote(standard(0x120))), Some((0, 0)));
    assert_eq!(accepted(&filters, data(standard(0x130))), None);
    // IDE is compared, RTR is not.
    assert_eq!(accepted(&filters, data(extended(0x120 << 18))), None);
}

#[test]
fn wide_list_compares_identifier_format_and_remote_bit() {
    let words = [wide(0x123), 0x1ABC_DEF0 << 3 | 0b110];
    let filters = set_up(&[Bank::new(0, WIDE, LIST, words)]);
    assert_eq!(accepted(&filters, data(standard(0x123))), Some((0, 0)));
    assert_eq!(accepted(&filters, remote(standard(0x123))), None);
    assert_eq!(accepted(&filters, data(extended(0x123 << 18))), None);
    assert_eq!(
        accepted(&filters, remote(extended(0x1ABC_DEF0))),
        Some((0, 1))
    );
    assert_eq!(accepted(&filters, data(extended(0x1ABC_DEF0))), None);
    assert_eq!(accepted(&filters, remote(extended(0x1ABC_DEF1))), None);
}

#[test]
fn narrow_mask_is_in_high_half_word() {
    let words = [narrow_pair(0x120, 0x7F0), narrow_pair(0x240, 0x7C0)];
    let filters = set_up(&[Bank::new(0, NARROW, MASK, words)]);
    assert_eq!(accepted(&filters, data(standard(0x12F))), Some((0, 0)));
    assert_eq!(accepted(&filters, remote(standard(0x27F))), Some((0, 1)));
    assert_eq!(accepted(&filters, data(standard(0x280))), None);
    assert_eq!(accepted(&filters, data(standard(0x130))), None);
}

#[test]
fn narrow_list_has_four_identifiers() {
    let words = [narrow_pair(0x101, 0x102), narrow_pair(0x103, 0x104)];
    let filters = set_up(&[Bank::new(0, NARROW, LIST, words)]);
    for index in 0..4 {
        let id = standard(0x101 + u16::from(index));
        assert_eq!(accepted(&filters, data(id)), Some((0, index)));
        assert_eq!(accepted(&filters, remote(id)), None);
    }
    assert_eq!(accepted(&filters, data(standard(0x105))), None);
}

#[test]
fn narrow_filter_compares_fourteen_bits_of_extended_identifier() {
    // STID[10:0] 155h, RTR 0, IDE 1, EXID[17:15] 101b.
    let word = 0x155 << 5 | 1 << 3 | 0b101;
    let filters = set_up(&[Bank::new(0, NARROW, LIST, [word, 0])]);
    let id = 0x155 << 18 | 0b101 << 15;
    assert_eq!(accepted(&filters, data(extended(id))), Some((0, 0)));
    assert_eq!(
        accepted(&filters, data(extended(id | 0x7FFF))),
        Some((0, 0))
    );
    assert_eq!(
        accepted(&filters, data(extended(id | 0x8000 | 0x1_0000))),
        None
    );
    assert_eq!(accepted(&filters, remote(extended(id))), None);
}

#[test]
fn wide_filter_has_priority_over_narrow() {
    let filters = set_up(&[
        Bank::new(0, NARROW, LIST, [narrow_pair(0x123, 0x123); 2]),
        Bank::new(1, WIDE, MASK, [0, 0]),
    ]);
    assert_eq!(accepted(&filters, data(standard(0x123))), Some((0, 4)));
}

#[test]
fn list_has_priority_over_mask() {
    for scale in [WIDE, NARROW] {
        let exact = if scale == WIDE {
            [wide(0x123); 2]
        } else {
            [narrow_pair(0x123, 0x123); 2]
        };
        let filters = set_up(&[
            Bank::new(0, scale, MASK, [0, 0]),
            Bank::new(1, scale, LIST, exact).of_fifo(1),
        ]);
        assert_eq!(accepted(&filters, data(standard(0x123))), Some((1, 0)));
        assert_eq!(accepted(&filters, data(standard(0x124))), Some((0, 0)));
    }
}

#[test]
fn lower_number_has_priority_among_equal_filters() {
    let filters = set_up(&[
        Bank::new(3, WIDE, LIST, [wide(0x123); 2]),
        Bank::new(5, WIDE, LIST, [wide(0x123); 2]).of_fifo(1),
    ]);
    // Banks 0 to 2 are not active: 16-bit masks, two filters each.
    assert_eq!(accepted(&filters, data(standard(0x123))), Some((0, 6)));
}

/// The example of the reference manual (figure "Example of filter numbering"): FIFO, scale, mode, activation, and number of the
/// first filter of each bank.
const EXAMPLE: [(usize, bool, bool, bool, u8); BANKS] = [
    (0, WIDE, LIST, true, 0),
    (0, WIDE, MASK, true, 2),
    (1, NARROW, MASK, true, 0),
    (0, NARROW, LIST, true, 3),
    (1, WIDE, LIST, true, 2),
    (0, WIDE, LIST, false, 7),
    (0, NARROW, MASK, true, 9),
    (1, NARROW, MASK, false, 4),
    (1, NARROW, MASK, true, 6),
    (0, WIDE, LIST, true, 11),
    (1, NARROW, LIST, false, 8),
    (1, WIDE, LIST, true, 12),
    (1, WIDE, MASK, true, 14),
    (0, WIDE, MASK, true, 13),
];

#[test]
fn filter_numbers_are_per_fifo_and_include_inactive_banks() {
    let banks: Vec<Bank> = (0..BANKS)
        .map(|number| {
            let (fifo, scale, list, ..) = EXAMPLE[number];
            let id = 0x100 + number as u32;
            // The first filter of each bank accepts its own identifier.
            let words = match (scale, list) {
                (WIDE, MASK) => [wide(id), wide(0x7FF)],
                (NARROW, MASK) => [narrow_pair(id, 0x7FF), narrow_pair(0x7FF, 0x7FF)],
                (WIDE, LIST) => [wide(id), wide(0x7FF)],
                (NARROW, LIST) => [narrow_pair(id, 0x7FF), narrow_pair(0x7FF, 0x7FF)],
            };
            Bank::new(number, scale, list, words).of_fifo(fifo)
        })
        .collect();
    let mut filters = set_up(&banks);
    let active = EXAMPLE.iter().rev().fold(0, |bits, (_, _, _, active, _)| {
        bits << 1 | u32::from(*active)
    });
    filters.write(
        Register::FilterActivation,
        active,
        &mut Violations::default(),
    );
    for (number, (fifo, _, _, active, index)) in EXAMPLE.into_iter().enumerate() {
        let frame = data(standard(0x100 + number as u16));
        let expected = active.then_some((fifo, index));
        assert_eq!(accepted(&filters, frame), expected, "bank {number}");
    }
}

#[test]
fn no_frame_is_received_during_filter_initialization() {
    let mut filters = set_up(&[Bank::new(0, WIDE, MASK, [0, 0])]);
    let mut violations = Violations::default();
    assert!(filters.accept(&data(standard(1))).is_some());
    filters.write(Register::FilterMaster, 1, &mut violations);
    assert_eq!(filters.accept(&data(standard(1))), None);
}

#[test]
fn reset_deactivates_banks_and_enters_initialization() {
    let filters = Filters::default();
    assert_eq!(filters.read(Register::FilterMaster), 1);
    assert_eq!(filters.read(Register::FilterActivation), 0);
}

#[test]
fn configuration_requires_filter_initialization() {
    let mut filters = set_up(&[Bank::new(2, WIDE, LIST, [0, 0])]);
    let mut violations = Violations::default();
    for (register, kept) in [
        (Register::FilterMode, 4),
        (Register::FilterScale, 4),
        (Register::FilterFifo, 0),
    ] {
        filters.write(register, 8, &mut violations);
        assert_eq!(filters.read(register), kept);
    }
    let registers: Vec<_> = violations.all.iter().map(|v| v.register).collect();
    assert_eq!(registers, ["CAN_FM1R", "CAN_FS1R", "CAN_FFA1R"]);
}

#[test]
fn active_bank_change_outside_initialization_is_violation() {
    let mut filters = set_up(&[Bank::new(2, WIDE, LIST, [7, 7])]);
    let mut violations = Violations::default();
    let word = |bank| Register::FilterBank { bank, half: 1 };
    filters.write(word(3), 9, &mut violations);
    assert_eq!((filters.read(word(3)), violations.all.len()), (9, 0));
    filters.write(word(2), 9, &mut violations);
    assert_eq!((filters.read(word(2)), violations.all.len()), (7, 1));
    // A deactivated bank can be changed.
    filters.write(Register::FilterActivation, 0, &mut violations);
    filters.write(word(2), 9, &mut violations);
    assert_eq!((filters.read(word(2)), violations.all.len()), (9, 1));
}

#[test]
fn access_to_fifteenth_bank_is_violation() {
    let mut filters = Filters::default();
    let mut violations = Violations::default();
    let bank = Register::FilterBank { bank: 14, half: 0 };
    filters.write(bank, 1, &mut violations);
    assert_eq!(violations.all.len(), 1);
    assert_eq!(violations.all[0].reason, "there is no filter bank 14");
    assert_eq!(filters.read(bank), 0);
}

#[test]
fn shared_banks_from_can2sb_on_belong_to_can2() {
    let mut filters = Filters::new(true, 0x2A1C_0E00);
    let mut violations = Violations::default();
    // Bank 20 accepts everything into FIFO 0.
    for (register, value) in [
        (Register::FilterScale, 1 << 20),
        (Register::FilterActivation, 1 << 20),
        (Register::FilterMaster, 14 << 8),
    ] {
        assert_eq!(filters.read(Register::FilterMaster), 14 << 8 | 1);
        filters.write(register, value, &mut violations);
    }
    assert_eq!(filters.read(Register::FilterMaster), 14 << 8);
    assert_eq!(filters.accept(&data(standard(1))), None, "CAN2SB is 14");
    for (start, accepts) in [(20, false), (21, true), (28, true), (0, false)] {
        let master = start << 8;
        assert_eq!(
            filters.reserved(Register::FilterMaster, 0x2A1C_0E00),
            (!0x3F01, 0x2A1C_0000)
        );
        filters.write(Register::FilterMaster, master, &mut violations);
        assert_eq!(filters.read(Register::FilterMaster), master);
        assert_eq!(
            filters.accept(&data(standard(1))).is_some(),
            accepts,
            "{start}"
        );
    }
    assert_eq!(violations.all, []);
}

#[test]
fn can2sb_of_stm32f103_is_reserved() {
    let mut filters = Filters::default();
    let mut violations = Violations::default();
    let reserved = filters.reserved(Register::FilterMaster, 0x2A1C_0E00);
    assert_eq!(reserved, (!1, 0x2A1C_0E00));
    filters.write(Register::FilterMaster, 0x2A1C_1C01, &mut violations);
    assert_eq!(filters.read(Register::FilterMaster), 1);
}

#[test]
fn shared_banks_belong_to_can2_after_a_reset_with_can2sb_0() {
    let mut filters = Filters::new(true, 0);
    let mut violations = Violations::default();
    assert_eq!(filters.read(Register::FilterMaster), 1);
    for (register, value) in [
        (Register::FilterScale, 1),
        (Register::FilterActivation, 1),
        (Register::FilterMaster, 0),
    ] {
        filters.write(register, value, &mut violations);
    }
    assert_eq!(filters.accept(&data(standard(1))), None);
    assert_eq!(violations.all, []);
}
