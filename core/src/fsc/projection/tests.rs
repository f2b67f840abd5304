//! The tests of the parent module.

use super::*;

const FUNCTION: Function = Function::new(0, "", Operation::Alive);

const fn access(read: u8, write: u8) -> Access {
    Access::new(read, write, "", &[ParameterId(0)])
}

const ACCESS: &[Access] = &[access(0x12, 0x20), access(0x15, 0x05)];
const FUNCTIONS: &[Function] = &[Function {
    code: 0xFF,
    ..FUNCTION
}];

const ROLES: Roles = Roles {
    set_id: ParameterId(1),
    reply_id: ParameterId(1),
    sync_id: ParameterId(1),
    bit_rate: ParameterId(1),
    bit_rates: &[],
    bus_off_recovery: ParameterId(1),
    cyclic_time: ParameterId(1),
    cyclic_mode: ParameterId(1),
};

const fn codes() -> Codes {
    Codes::new(
        const { &groups(ACCESS, FUNCTIONS) },
        const { &rows::<{ row_count(ACCESS, FUNCTIONS) }>(ACCESS, FUNCTIONS, &ROLES, &[]) },
        &[],
    )
}

#[test]
fn find_returns_row_of_code_and_none_for_others() {
    let expected = [
        (0x05, Operation::Write),
        (0x12, Operation::Read),
        (0x15, Operation::Read),
        (0x20, Operation::Write),
        (0xFF, Operation::Alive),
    ];
    for code in 0..=u8::MAX {
        let found = codes().find(code).map(|row| (row.code, row.operation));
        let row = expected.into_iter().find(|(of, _)| *of == code);
        assert_eq!(found, row, "{code:02X}h");
    }
    assert_eq!(row_count(ACCESS, FUNCTIONS), 7);
    assert_eq!(codes().row_of(Operation::Alive).code, 0xFF);
}

#[test]
fn find_returns_none_for_every_code_between_distant_codes() {
    const FUNCTIONS: &[Function] = &[
        Function {
            code: 0x10,
            ..FUNCTION
        },
        Function {
            code: 0xE0,
            ..FUNCTION
        },
        Function {
            code: 0xEF,
            ..FUNCTION
        },
    ];
    let codes = Codes::new(
        const { &groups(&[], FUNCTIONS) },
        const { &rows::<{ row_count(&[], FUNCTIONS) }>(&[], FUNCTIONS, &ROLES, &[]) },
        &[],
    );
    for code in 0..=u8::MAX {
        let declared = FUNCTIONS.iter().any(|function| function.code == code);
        assert_eq!(codes.find(code).is_some(), declared, "{code:02X}h");
    }
}

#[test]
fn read_and_write_codes_have_same_fields() {
    let of = |code| codes().find(code).map(|row| (row.first, row.form & COUNT));
    assert_eq!((of(0x12), of(0x20)), (Some((0, 1)), Some((0, 1))));
    assert_eq!((of(0x15), of(0x05)), (Some((1, 1)), Some((1, 1))));
    assert_eq!(of(0xFF), Some((2, 0)));
}

#[test]
fn flags_describe_parameters_of_row() {
    let [cyclic, zero, pair] = [
        &[ParameterId(1)][..],
        &[ParameterId(0)],
        &[ParameterId(0), ParameterId(2)],
    ];
    let different = [Constraint::different(ParameterId(2), ParameterId(1))];
    assert_eq!(flags(cyclic, &ROLES, &[]), OWN | CYCLIC_TIME);
    assert_eq!(
        flags(cyclic, &ROLES, &different),
        OWN | CYCLIC_TIME | CONSTRAINED
    );
    assert_eq!(flags(zero, &ROLES, &different), 0);
    assert_eq!(flags(pair, &ROLES, &different), CONSTRAINED);
}

#[test]
fn row_knows_whether_it_has_several_fields_and_is_constrained() {
    const PAIR: &[ParameterId] = &[ParameterId(0), ParameterId(2)];
    const ACCESS: &[Access] = &[
        access(0x10, 0x20),
        Access {
            parameters: PAIR,
            ..access(0x11, 0x21)
        },
        Access {
            parameters: &[ParameterId(3)],
            ..access(0x12, 0x22)
        },
    ];
    const CONSTRAINTS: &[Constraint] = &[Constraint::different(ParameterId(3), ParameterId(4))];
    let codes = Codes::new(
        const { &groups(ACCESS, &[]) },
        const { &rows::<{ row_count(ACCESS, &[]) }>(ACCESS, &[], &ROLES, CONSTRAINTS) },
        &[],
    );
    for (code, several, constrained) in [
        (0x20, false, false),
        (0x21, true, false),
        (0x22, false, true),
    ] {
        let row = codes.find(code).unwrap();
        assert_eq!(row.has_several(), several, "{code:02X}h");
        assert_eq!(row.is_constrained(), constrained, "{code:02X}h");
    }
}

#[test]
fn source_is_unchanged_after_encode_and_decode() {
    for source in 0..=ACTIVE_SET_ID {
        let item = Item { source, size: 1 };
        let parameters = [Parameter::plain(); 128];
        let quantity = Quantity::new(ValueId(0), "", crate::param::DataType::U8).within(0, 0);
        let again = Item::new(item.source(), &parameters, &[quantity; 128]);
        assert_eq!(again.source, source);
    }
}
