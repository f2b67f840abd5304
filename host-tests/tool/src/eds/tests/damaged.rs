//! Files with a damaged line: it costs itself, or the error names it. It never changes another entry.

use super::*;

const OBJECTS: &str = "[2000]\nParameterName=One\nObjectType=7\nDataType=5\nAccessType=rw\n\
    [2001]\nParameterName=Two\nObjectType=7\nDataType=7\nAccessType=rw\n";

const DEVICE: &str = "[Device]\nVendCode = 9;\nVendName = \"Example\";\nProdCode = 7;\nProdName = \"Drive\";\n[Params]\n\
    Param1 = 0, 6, \"20 65 24 01 30 71\", 0, 0xC7, 2, \"One\", \"\", \"help\", 10, 1000, 10;\n\
    Param2 = 0, 6, \"20 65 24 01 30 72\", 0, 0xC6, 1, \"Two\", \"\", \"help\", 1, 9, 2;\n";

/// The same device with an entry of several lines, as most makers write it.
const LINES: &str = "[Device]\nVendCode = 9;\nProdCode = 7;\n[Params]\n\
    Param1 =\n0,\n6, \"20 65 24 01 30 71\",\n0, 0xC7, 2,\n\"One\",\n\"\",\n\"help\"\n\"more\",\n10, 1000, 10;\n\
    Param2 = 0, 6, \"20 65 24 01 30 72\", 0, 0xC6, 1, \"Two\", \"\", \"help\", 1, 9, 2;\n";

fn entries(sheet: &Sheet) -> Vec<(Address, DataType, String, Permitted)> {
    let entries = sheet.entries.iter();
    let entries = entries.map(|own| (own.address, own.data_type, own.title.clone(), own.permitted));
    entries.collect()
}

/// Inserts a line after this number of lines.
fn with_line(text: &str, behind: usize, line: &str) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    lines.insert(behind, line);
    lines.join("\n") + "\n"
}

#[test]
fn stray_line_changes_no_entry() {
    for (text, stray) in [
        (OBJECTS, "// terminator"),
        (OBJECTS, "***"),
        (OBJECTS, "DataType"),
        (OBJECTS, "[]"),
        (OBJECTS, "[ ]"),
        (OBJECTS, "= 5"),
        (DEVICE, "// terminator"),
        (DEVICE, "***"),
    ] {
        let wanted = entries(&parsed(text.as_bytes()).unwrap());
        for behind in 0..=text.lines().count() {
            let sheet = parsed(with_line(text, behind, stray).as_bytes()).unwrap();
            assert_eq!(entries(&sheet), wanted, "{stray} behind line {behind}");
            let ignored = &sheet.data_sheet.unwrap().ignored;
            assert_eq!(*ignored, [behind + 1], "{stray}");
        }
    }
}

#[test]
fn missing_name_of_a_section_does_not_change_the_object_before_it() {
    let text = OBJECTS.replace("[2001]\n", "");
    let sheet = parsed(text.as_bytes()).unwrap();
    let wanted = entries(&parsed(OBJECTS.as_bytes()).unwrap());
    assert_eq!(entries(&sheet), wanted[..1]);
    assert_eq!(sheet.data_sheet.unwrap().ignored, [6, 7, 8, 9]);
}

#[test]
fn stray_line_in_an_entry_of_several_lines_is_an_error_with_its_line() {
    for stray in [
        "// terminator",
        "***",
        "words",
        "words 7",
        "]",
        "[]",
        "[Params",
        "= 5;",
        ",",
        ",,",
        ";",
        "5;",
    ] {
        for behind in 5..=12 {
            let why = parsed(with_line(LINES, behind, stray).as_bytes()).unwrap_err();
            let line = format!("line {} ", behind + 1);
            assert!(why.contains(&line), "{stray} behind line {behind}: {why}");
        }
    }
    let wanted = entries(&parsed(LINES.as_bytes()).unwrap());
    for behind in [0, 1, 2, 3, 4, 13, 14] {
        let sheet = parsed(with_line(LINES, behind, ", 5").as_bytes()).unwrap();
        assert_eq!(entries(&sheet), wanted, "behind line {behind}");
        assert_eq!(sheet.data_sheet.unwrap().ignored, [behind + 1]);
    }
    let why = parsed(LINES.replace("Param1 =\n", "").as_bytes()).unwrap_err();
    assert!(why.contains("line 5 "), "{why}");
}

#[test]
fn second_end_of_an_entry_is_an_error_with_its_line() {
    for stray in [";", "5;"] {
        for behind in [2, 3, 13, 14] {
            let why = parsed(with_line(LINES, behind, stray).as_bytes()).unwrap_err();
            let line = format!("line {} ", behind + 1);
            assert!(why.contains(&line), "{stray} behind line {behind}: {why}");
        }
    }
}

/// Makers write empty fields so, and the semicolon on a line of its own.
#[test]
fn line_of_commas_is_empty_fields_of_a_complete_parameter() {
    let complete = LINES.replace("10, 1000, 10;", "10, 1000, 10,\n,,,,\n,,,,\n;");
    let wanted = entries(&parsed(LINES.as_bytes()).unwrap());
    let sheet = parsed(complete.as_bytes()).unwrap();
    assert_eq!(entries(&sheet), wanted);
    assert_eq!(sheet.data_sheet.unwrap().ignored, [0; 0]);
    for (behind, line) in [(5, 6), (12, 13), (13, 14)] {
        let why = parsed(with_line(&complete, behind, ",").as_bytes()).unwrap_err();
        assert!(why.contains(&format!("line {line} ")), "{behind}: {why}");
    }
}

#[test]
fn line_of_a_comma_in_an_entry_that_needs_no_empty_field_is_an_error_with_its_line() {
    let names = LINES.replace("[Params]\n", "[Params]\nEnum2 =\n1, \"off\",\n2, \"on\";\n");
    let identity = LINES.replace("VendCode = 9;", "VendCode =\n9;");
    for (text, behind) in [(&names, 5), (&names, 6), (&identity, 2)] {
        let why = parsed(with_line(text, behind, ",").as_bytes()).unwrap_err();
        assert!(why.contains(&format!("line {} ", behind + 1)), "{why}");
    }
}

#[test]
fn missing_semicolon_of_an_entry_of_several_lines_is_an_error_with_its_line() {
    for (entry, line) in [("9;", 2), ("7;", 3), ("10;", 13)] {
        let text = LINES.replacen(entry, &entry[..entry.len() - 1], 1);
        let why = parsed(text.as_bytes()).unwrap_err();
        assert!(
            why.contains(&format!("line {line} has no semicolon")),
            "{why}"
        );
    }
}

#[test]
fn object_that_is_there_twice_is_an_error_with_its_line() {
    for again in ["[2000]", "[2000] as above"] {
        let why = parsed(with_line(OBJECTS, 8, again).as_bytes()).unwrap_err();
        assert!(why.contains("line 9 "), "{why}");
    }
}

#[test]
fn byte_order_mark_anywhere_and_utf_16_change_nothing() {
    for text in [OBJECTS, DEVICE] {
        let wanted = entries(&parsed(text.as_bytes()).unwrap());
        let mark = "\u{FEFF}";
        let joined = format!("{mark}{}", text.replace("\n[", &format!("\n{mark}[")));
        let mut latin = joined.clone().into_bytes();
        latin.extend(b"$;\xE4\n");
        let utf_16: Vec<u16> = joined.encode_utf16().collect();
        let little = utf_16.iter().flat_map(|unit| unit.to_le_bytes()).collect();
        let big = utf_16.iter().flat_map(|unit| unit.to_be_bytes()).collect();
        for bytes in [joined.clone().into_bytes(), little, big] {
            assert_eq!(entries(&parsed(&bytes).unwrap()), wanted, "{text}");
        }
        if text == OBJECTS {
            assert_eq!(entries(&parsed(&latin).unwrap()), wanted);
        }
    }
}

#[test]
fn damaged_section_is_an_error_with_its_line() {
    for (damaged, line) in [
        ("[2001", 6),
        ("2001]", 6),
        ("// [2001]", 6),
        ("[[2001]]", 6),
        ("[20[01]", 6),
    ] {
        let text = OBJECTS.replace("[2001]", damaged);
        let why = parsed(text.as_bytes()).unwrap_err();
        assert!(why.contains(&format!("line {line} ")), "{damaged}: {why}");
    }
    let why = parsed(DEVICE.replace("[Params]", "[Params").as_bytes()).unwrap_err();
    assert!(why.contains("line 6 "), "{why}");
}

#[test]
fn missing_semicolon_is_an_error_with_its_line() {
    for line in [2, 3, 4, 5, 7, 8] {
        for comment in ["", " $ a comment; of = it", "\n\n$ more"] {
            let mut lines: Vec<String> = DEVICE.lines().map(str::to_owned).collect();
            lines[line - 1] = lines[line - 1].replace(';', comment);
            let why = parsed((lines.join("\n") + "\n").as_bytes()).unwrap_err();
            let named = [format!("line {line} "), format!("line {line}:")];
            assert!(named.iter().any(|own| why.contains(own)), "{line}: {why}");
        }
    }
    let why = parsed(DEVICE.replace("9;\n", "9 ").as_bytes()).unwrap_err();
    assert!(why.contains("line 2 "), "{why}");
}

#[test]
fn quotation_mark_in_a_text_shifts_no_field() {
    let wanted = entries(&parsed(DEVICE.as_bytes()).unwrap());
    for help in [r#"5\" pipe, "#, r#"a \"b\" c"#, r"C:\", r#"\"\"x"#] {
        let text = DEVICE.replace("help", help);
        assert_eq!(entries(&parsed(text.as_bytes()).unwrap()), wanted, "{help}");
    }
    let text = DEVICE.replace("Drive", r#"5\" Drive"#);
    assert_eq!(parsed(text.as_bytes()).unwrap().product.name, "5-drive");
}

#[test]
fn sub_indices_without_an_object_are_counted() {
    let subs = "[3000sub0]\nDataType=5\nAccessType=ro\n[3000sub1]\nDataType=5\nAccessType=rw\n\
        [2001sub1]\nDataType=5\nAccessType=rw\n";
    let sheet = parsed(format!("{OBJECTS}{subs}").as_bytes()).unwrap();
    assert_eq!(sheet.data_sheet.unwrap().left_out, 2);
}

#[test]
fn section_of_a_commissioned_device_is_read_and_replaced_in_both_spellings() {
    for name in [
        "DeviceComissioning",
        "DeviceCommissioning",
        "DEVICECOMMISSIONING",
    ] {
        let text = format!("{OBJECTS}[{name}]\nNodeID=5\nLSS_SerialNumber=77\n");
        let unit = super::super::identity::sheet(&text, find("jn2101").unwrap()).unwrap();
        let serial = unit.values.iter().find(|(key, _)| *key == "serial");
        let number = descriptors::unit::Value::Number(77);
        assert_eq!(serial.map(|(_, own)| own == &number), Some(true), "{name}");
        let again = dcf::text(&text, &dcf::Commissioning::default(), &[]);
        assert!(!again.contains("NodeID=5"), "{again}");
        assert_eq!(again.to_lowercase().matches("missioning]").count(), 1);
    }
}
