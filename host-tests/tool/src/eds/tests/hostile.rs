//! Damaged and hostile files: a sheet whose entries can be used, or an error.

use super::*;
use proptest::prelude::*;

/// Everything that the commands do with an entry.
pub(super) fn check_all(sheet: &Sheet) {
    let mut names = HashSet::new();
    for entry in &sheet.entries {
        assert!(
            !entry.name.is_empty() && names.insert(entry.name.clone()),
            "{}",
            entry.name
        );
        let is_plain = |letter: char| letter.is_ascii_alphanumeric() || letter == '-';
        assert!(entry.name.chars().all(is_plain), "{}", entry.name);
        let is_printable = |text: &str| !text.chars().any(char::is_control);
        assert!(is_printable(&entry.title) && is_printable(entry.scale.unit));
        let _ = entry.range();
        if entry.data_type == DataType::Text {
            continue;
        }
        let mask = u32::MAX >> (32 - 8 * u32::from(entry.data_type.size()));
        for raw in [0, 1, 0x7F, 0x80, 0x7FFF, 0x8000, 0x7FFF_FFFF, u32::MAX] {
            let raw = raw & mask;
            let text = entry.text(raw);
            assert!(is_printable(&text), "{text:?}");
            let _ = (entry.json(raw), entry.check(raw, &entry.scale));
            let _ = (
                entry.parse(&text),
                entry.parse("1.5deg"),
                entry.parse("-99999999999999999999"),
            );
        }
    }
    let values: Vec<(Entry, u32)> = sheet.settings().map(|entry| (entry.clone(), 1)).collect();
    let text = &sheet.data_sheet.as_ref().unwrap().text;
    let _ = dcf::text(text, &dcf::Commissioning::default(), &values);
}

/// Pieces of which hostile files consist.
fn piece() -> impl Strategy<Value = String> {
    let number = prop_oneof![
        Just("0x7".to_owned()),
        Just("-1".to_owned()),
        Just("0".to_owned()),
        Just("$NODEID+0xFFFFFFFFFFFFFFFFFF".to_owned()),
        Just("$NODEID".to_owned()),
        Just("-0x8000000000000000".to_owned()),
        Just("99999999999999999999999999".to_owned()),
        any::<i64>().prop_map(|number| number.to_string()),
        any::<u32>().prop_map(|number| format!("0x{number:X}")),
        "\\PC{0,12}",
    ];
    let key = prop::sample::select(vec![
        "ParameterName",
        "ObjectType",
        "DataType",
        "AccessType",
        "DefaultValue",
        "LowLimit",
        "HighLimit",
        "CompactSubObj",
        "SubNumber",
        "ObjFlags",
        "ParameterValue",
    ]);
    prop_oneof![
        (any::<u16>(), any::<u8>()).prop_map(|(index, sub)| format!("[{index:04x}sub{sub:X}]\n")),
        (0x1000_u16..0x1020)
            .prop_map(|index| format!("[{index:04X}]\nDataType=5\nAccessType=rw\n")),
        (key, number).prop_map(|(key, value)| format!("{key}={value}\n")),
        Just("AccessType=rw\nDataType=0x0004\n".to_owned()),
        ".{0,20}\n",
    ]
}

/// Data sheets of this project with some bytes changed.
fn damaged() -> impl Strategy<Value = Vec<u8>> {
    let texts: Vec<String> = ["jn2101", "tiltix080"]
        .map(|name| descriptors::describe(find(name).unwrap()).text)
        .to_vec();
    let changes =
        prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..3_u8), 1..40);
    (prop::sample::select(texts), changes).prop_map(|(text, changes)| {
        let mut bytes = text.into_bytes();
        for (place, byte, kind) in changes {
            let place = place.index(bytes.len());
            match kind {
                0 => bytes[place] = byte,
                1 => {
                    bytes.remove(place);
                }
                _ => bytes.insert(place, byte % 96 + 32),
            }
        }
        bytes
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn any_bytes_give_a_sheet_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = parsed(&bytes);
    }

    #[test]
    fn hostile_sections_give_a_sheet_or_an_error(pieces in prop::collection::vec(piece(), 0..40)) {
        if let Ok(sheet) = parsed(pieces.concat().as_bytes()) {
            check_all(&sheet);
        }
    }

    #[test]
    fn damaged_data_sheets_give_a_sheet_or_an_error(bytes in damaged()) {
        if let Ok(sheet) = parsed(&bytes) {
            check_all(&sheet);
        }
    }
}
