use super::*;
use crate::meaning::german;
use crate::sheet::Sheet;
use plumbline::model::catalog::{PRODUCTS, find};
use texts::Text;

fn scale(unit: &'static str, decimals: u8) -> Scale {
    Scale::of(unit, decimals)
}

#[test]
fn unit_with_number_scales_values() {
    assert_eq!(scale("100 us", 0).with_unit(10), "1000 us");
    assert_eq!(scale("0.001 deg", 0).with_unit(10), "0.010 deg");
    assert_eq!(scale("0.001 deg", 0).times(10).with_unit(125), "1.25 deg");
    assert_eq!(scale("0.001 deg", 0).times(1000).with_unit(-12), "-12 deg");
    assert_eq!(scale("deg", 2).with_unit(-1), "-0.01 deg");
    assert_eq!(scale("0.1 degC", 0).with_unit(-5), "-0.5 degC");
    assert_eq!(scale("", 0).with_unit(-9), "-9");
}

fn parse(product: &str, name: &str, text: &str) -> Result<u32, NumberError> {
    let sheet = Sheet::of(find(product).unwrap());
    let entry = sheet
        .entries
        .iter()
        .find(|entry| entry.name == name)
        .unwrap();
    entry.parse(text)
}

#[test]
fn value_is_read_in_every_spelling_of_its_unit() {
    for (text, raw) in [
        ("2.5Hz", 2500),
        ("2.5 Hz", 2500),
        ("2500mHz", 2500),
        ("2500", 2500),
        ("0.0025kHz", 2500),
        ("raw:2500", 2500),
        ("2.5 HZ", 2500),
        ("2,5hz", 2500),
        ("2500 mhz", 2500),
        ("0.0025 KHZ", 2500),
        ("0,0000025MHz", 2500),
        ("raw:0x9C4", 2500),
        ("raw:9C4h", 2500),
    ] {
        assert_eq!(parse("is2", "cut-off", text), Ok(raw), "{text}");
    }
    assert_eq!(parse("is2", "zero-x", "-1.25deg"), Ok(0xFF83));
    assert_eq!(parse("is2", "zero-x", "-1.25°"), Ok(0xFF83));
    assert_eq!(parse("is2", "cyclic-time", "0.25s"), Ok(250));
    for (text, raw) in [("250 MS", 250), ("0.5min", 30_000), ("1 Min", 60_000)] {
        assert_eq!(parse("is2", "cyclic-time", text), Ok(raw), "{text}");
    }
    assert_eq!(parse("jn2101", "tpdo1-inhibit-time", "1ms"), Ok(10));
    assert_eq!(
        parse("jn2101", "tpdo1-inhibit-time", "1000\u{3bc}s"),
        Ok(10)
    );
    for text in [
        "250",
        "250k",
        "250kbit/s",
        "250 KBit/S",
        "250kbps",
        "0,25mbit/s",
        "250000",
    ] {
        for (product, raw) in [
            ("ims360", 250_000),
            ("jn2101", 250),
            ("tiltix080", 1),
            ("is2", 6),
        ] {
            assert_eq!(
                parse(product, "baud-rate", text),
                Ok(raw),
                "{product} {text}"
            );
        }
    }
    for (product, raw) in [("ims360", 1_000_000), ("is2", 9)] {
        assert_eq!(parse(product, "baud-rate", "1M"), Ok(raw));
    }
}

#[test]
fn value_that_is_not_exact_or_no_number_is_refused() {
    for text in [
        "2.5001Hz",
        "2.5deg",
        "x",
        "",
        "-",
        ".",
        "1e3",
        "2,5,0Hz",
        "2.500,5Hz",
        "2,Hzz",
        "9C4h",
        "100h",
        "0x9C4",
        "99999999999999999999Hz",
        "70Hz",
        "raw:x",
    ] {
        assert!(parse("is2", "cut-off", text).is_err(), "{text}");
    }
    assert!(
        parse("is2", "zero-x", "1.255deg")
            .unwrap_err()
            .to_string()
            .contains("0.01 deg")
    );
}

#[test]
fn hexadecimal_number_is_taken_only_without_unit() {
    let sheet = Sheet::of(find("is2").unwrap());
    let entry = sheet.entries.iter().find(|entry| entry.name == "cut-off");
    let of = |unit: &'static str, text: &str| {
        let scale = scale(unit, 0);
        let entry = Entry {
            scale,
            ..entry.unwrap().clone()
        };
        entry.parse(text).ok()
    };
    for (unit, text, raw) in [
        ("", "10h", Some(16)),
        ("", "0x10", Some(16)),
        ("", "1FH", Some(31)),
        ("h", "10h", Some(10)),
        ("h", "10 H", Some(10)),
        ("h", "90min", None),
        ("h", "120min", Some(2)),
        ("h", "0x10", None),
        ("h", "1Fh", None),
        ("Ah", "10Ah", Some(10)),
        ("Ah", "10h", None),
        ("kHz", "10h", None),
        ("s", "1h", Some(3600)),
        ("ms", "1h", None),
        ("ms", "0.5h", Some(1_800_000)),
    ] {
        // 1 h in ms has more than the 16 bits of this entry.
        let raw = raw.filter(|raw| *raw <= 0xFFFF);
        assert_eq!(of(unit, text), raw, "{text} in {unit:?}");
    }
}

#[test]
fn beginning_of_a_name_is_no_value() {
    for (product, name, text) in [
        ("is2", "filter-type", "butter"),
        ("is2", "filter-type", "b"),
        ("is2", "filter-type", ""),
        ("is2", "baud-rate", "250kg"),
        ("is2", "baud-rate", "25"),
        ("is2", "baud-rate", "-250"),
        ("jn2101", "filter", "10h"),
        ("jn2101", "filter", "10 h"),
        ("jn2101", "filter", "0x2"),
    ] {
        assert!(parse(product, name, text).is_err(), "{name}={text}");
    }
}

#[test]
fn name_is_read_without_regard_to_spaces_and_capitals() {
    for text in ["Butterworth", "butterworth", "BUTTER-worth", "1", "raw:1"] {
        assert_eq!(parse("is2", "filter-type", text), Ok(1), "{text}");
    }
    assert_eq!(parse("is2", "filter-type", "critically-damped"), Ok(2));
    for (text, raw) in [
        ("butterworth", 1),
        ("Butterworth-8th", 1),
        ("critically damped", 2),
    ] {
        assert_eq!(parse("ims360", "filter-type", text), Ok(raw), "{text}");
    }
    assert!(parse("ims360", "filter-type", "butterworth 8").is_err());
    for (text, raw) in [
        ("250", 6),
        ("250 KBIT/S", 6),
        ("0.25 Mbit/s", 6),
        ("62.5 kbit/s", 10),
        ("62,5", 10),
    ] {
        assert_eq!(parse("is2", "baud-rate", text), Ok(raw), "{text}");
    }
    assert_eq!(parse("is2", "baud-rate", "6"), Ok(6));
    assert_eq!(parse("jn2101", "filter", "5Hz"), Ok(2));
}

/// Each enumerated value of each product: in any case, and a proper name of it by itself.
#[test]
fn value_is_its_name_in_any_case_of_all_products() {
    for product in PRODUCTS {
        for entry in Sheet::of(product).entries {
            for (raw, name) in entry.meanings.iter().filter(|(_, name)| !name.is_empty()) {
                for text in [name.to_lowercase(), name.to_uppercase()] {
                    assert_eq!(entry.parse(&text), Ok(*raw), "{} {text}", entry.name);
                }
            }
        }
    }
    for text in ["j1939", "J1939", "sae-j1939"] {
        assert_eq!(parse("ims360", "can-protocol", text), Ok(1), "{text}");
    }
    for (name, text) in [("can-protocol", "sae 1"), ("can-protocol", "j193")] {
        assert!(parse("ims360", name, text).is_err(), "{name}={text}");
    }
}

#[test]
fn german_name_is_a_value_too() {
    for product in PRODUCTS {
        for entry in Sheet::of(product).entries {
            for (raw, name) in entry.meanings.iter().filter(|(_, name)| !name.is_empty()) {
                let german = german(name);
                assert_eq!(entry.parse(german), Ok(*raw), "{} {german}", entry.name);
            }
        }
    }
    let wrong = parse("is2", "filter-type", "Bessel").unwrap_err();
    assert_eq!(
        wrong.to_string(),
        "its values are off, Butterworth, critically damped"
    );
    assert_eq!(
        wrong.german(),
        "die Werte sind aus, Butterworth, kritisch gedämpft"
    );
}

#[test]
fn wrong_name_names_the_value_that_is_probably_meant() {
    for (product, name, text, meant) in [
        ("ims360", "can-protocol", "j1938", "SAE J1939"),
        ("ims360", "can-protocol", "canopne", "CANopen"),
        ("is2", "filter-type", "Buterworth", "Butterworth"),
        ("jn2101", "filter", "10h", "10 Hz"),
    ] {
        let sheet = Sheet::of(find(product).unwrap());
        let mut entries = sheet.entries.iter();
        let entry = entries.find(|entry| entry.name == name).unwrap();
        let why = entry.accept(text, &entry.scale).unwrap_err().to_string();
        let end = format!(". Did you mean {meant}?");
        assert!(why.ends_with(&end), "{why}");
    }
}

#[test]
fn number_that_is_another_name_is_ambiguous() {
    // Code 10 is 62.5 kbit/s, the name 10 kbit/s is code 1.
    assert!(
        parse("is2", "baud-rate", "10")
            .unwrap_err()
            .to_string()
            .contains("raw:10")
    );
    assert_eq!(parse("is2", "baud-rate", "10 kbit/s"), Ok(1));
    assert!(parse("jn2101", "filter", "1").is_err());
    assert!(
        parse("is2", "filter-type", "x")
            .unwrap_err()
            .to_string()
            .contains("Butterworth")
    );
}

#[test]
fn identifier_has_three_or_eight_digits() {
    assert_eq!(identifier("300"), Ok(0x300));
    assert_eq!(identifier("300h"), Ok(0x300));
    assert_eq!(identifier("0x7FF"), Ok(0x7FF));
    assert_eq!(identifier("00000361h"), Ok(0x8000_0361));
    for text in ["", "800", "1234", "20000000", "xyz", "-30", "+30"] {
        assert!(identifier(text).is_err(), "{text}");
    }
}

#[test]
fn version_format_follows_its_generation() {
    assert_eq!(version_text(0x0344), "3.44");
    assert_eq!(version_text(103), "1.03");
}
