use super::*;
use crate::master::canopen::eds::dcf;
use crate::sheet::Form;
use plumbline::model::catalog::find;
use plumbline::param::Permitted;

mod bounds;
mod damaged;
mod hostile;
mod identity;
mod scales;
mod settings;
use hostile::check_all;

/// A data sheet with the forms that makers use.
const FOREIGN: &str = "\
[FileInfo]\r\nFileName=drive.eds\r\n\
[DeviceInfo]\r\nVendorName=Example\r\nVendorNumber=0x12345\r\nProductName=Motor Drive 7\r\nProductNumber=4711\r\n\
[OptionalObjects]\r\nSupportedObjects=2\r\n1=0x1014\r\n2=0x1A00\r\n\
[1014]\r\nParameterName=COB-ID EMCY\r\nObjectType=0x7\r\nDataType=0x0007\r\nAccessType=rw\r\nDefaultValue=$NODEID+0x80\r\n\
[1010]\r\nParameterName=Store parameters\r\nObjectType=0x8\r\nSubNumber=2\r\n\
[1010sub0]\r\nParameterName=Number of entries\r\nDataType=0x5\r\nAccessType=ro\r\n\
[1010sub1]\r\nParameterName=Save all\r\nDataType=0x7\r\nAccessType=rw\r\n\
[6010]\r\nPARAMETERNAME=Slope long16\r\nObjectType=7\r\nDataType=3\r\nAccessType=RO\r\nPDOMapping=1\r\n\
[2000]\r\nParameterName=Limit ; of the drive\r\nObjectType=0x7\r\nDataType=0x0003 ; signed\r\nAccessType=rw\r\nDefaultValue=0xFFFF\r\nLowLimit=0xFF9C\r\nHighLimit=0100\r\n\
[2001]\r\nParameterName=Name\r\nObjectType=0x7\r\nDataType=0x9\r\nAccessType=rw\r\n\
[2002]\r\nParameterName=Gain\r\nObjectType=0x7\r\nDataType=0x8\r\nAccessType=rw\r\n\
[2003]\r\nParameterName=Target\r\nObjectType=0x7\r\nDataType=0x4\r\nAccessType=rww\r\n\
[2004]\r\nParameterName=Start\r\nObjectType=0x7\r\nDataType=0x1\r\nAccessType=wo\r\n\
[2005]\r\nParameterName=Limit\r\nObjectType=0x7\r\nDataType=0x5\r\nAccessType=rw\r\nObjFlags=1\r\n\
[2100]\r\nParameterName=Curve\r\nObjectType=0x8\r\nDataType=0x6\r\nAccessType=rw\r\nCompactSubObj=3\r\nDefaultValue=5\r\n\
[2100Name]\r\nNrOfEntries=1\r\n2=Knee\r\n\
[1a00]\r\nParameterName=Transmit PDO mapping\r\nObjectType=0x9\r\n\
[1A00SUB0]\r\nParameterName=Number\r\nDataType=0x5\r\nAccessType=rw\r\n\
[1A00sub0A]\r\nParameterName=Entry\r\nDataType=0x7\r\nAccessType=rw\r\n";

/// The sheet of a file that is not kept: the tests read more different files than a process may read.
fn parsed(bytes: &[u8]) -> Result<Sheet, String> {
    let text = text_of(bytes);
    let parts = parts(&text).map_err(|why| why.to_string())?;
    Ok(sheet(text, parts))
}

fn foreign() -> Sheet {
    parsed(FOREIGN.as_bytes()).unwrap()
}

fn named<'a>(sheet: &'a Sheet, name: &str) -> &'a Entry {
    let found = sheet.entries.iter().find(|entry| entry.name == name);
    let names: Vec<&str> = sheet
        .entries
        .iter()
        .map(|entry| entry.name.as_str())
        .collect();
    found.unwrap_or_else(|| panic!("no {name} in {names:?}"))
}

fn object(index: u16, sub: u8) -> Address {
    Address::Object { index, sub }
}

#[test]
fn entries_have_the_names_addresses_types_and_access_of_the_file() {
    let sheet = foreign();
    assert_eq!(sheet.product.name, "motor-drive-7");
    assert_eq!(sheet.product.maker, "Example");
    let names: Vec<&str> = sheet
        .entries
        .iter()
        .map(|entry| entry.name.as_str())
        .collect();
    let expected = [
        "save-all",
        "cob-id-emcy",
        "number",
        "entry",
        "limit-2000-0",
        "name",
        "target",
        "start",
        "limit-2005-0",
        "curve-1",
        "knee",
        "curve-3",
        "slope-long16",
    ];
    assert_eq!(names, expected);
    assert_eq!(named(&sheet, "entry").address, object(0x1A00, 10));
    assert_eq!(named(&sheet, "knee").address, object(0x2100, 2));
    assert_eq!(named(&sheet, "knee").factory, Some(5));
    let access = |name| {
        let entry = named(&sheet, name);
        (entry.readable, entry.writable)
    };
    assert_eq!(access("slope-long16"), (true, false));
    assert_eq!(access("start"), (false, true));
    assert_eq!(access("target"), (true, true));
    let settings: Vec<&str> = sheet.settings().map(|entry| entry.name.as_str()).collect();
    let expected = [
        "cob-id-emcy",
        "number",
        "entry",
        "limit-2000-0",
        "curve-1",
        "knee",
        "curve-3",
    ];
    assert_eq!(settings, expected);
    let data_sheet = sheet.data_sheet.as_ref().unwrap();
    // A floating-point number.
    assert_eq!(data_sheet.left_out, 1);
    assert_eq!(data_sheet.identity, [Some(0x12345), Some(4711)]);
    assert_eq!(data_sheet.angles[0].address, object(0x6010, 0));
}

#[test]
fn numbers_are_decimal_hexadecimal_or_octal_and_signed_ones_can_be_bytes() {
    let sheet = foreign();
    let limit = named(&sheet, "limit-2000-0");
    assert_eq!(limit.factory, Some(0xFFFF));
    assert_eq!(limit.permitted, Permitted::Range(-100, 64));
    assert_eq!(limit.parse("-1"), Ok(0xFFFF));
    assert!(limit.check(0xFF9B, &limit.scale).is_err());
    let cob_id = named(&sheet, "cob-id-emcy");
    assert_eq!((cob_id.factory, cob_id.node_relative), (Some(0x80), true));
    assert_eq!(cob_id.form, Form::Hexadecimal);
}

#[test]
fn text_that_is_no_data_sheet_is_refused_with_a_reason() {
    for (text, reason) in [
        ("", "no entry"),
        ("[2000\nParameterName=x\n", "line 1"),
        ("[sensor]\nproduct = \"is2\"\n", "no entry"),
        ("[2000]\nDataType=99\nAccessType=rw\n", "no entry"),
        ("[2000]\nDataType=7\nAccessType=maybe\n", "no entry"),
        ("[Device]\nVendCode = 1;\n[Params]\nParam1 = 0", "no end"),
        ("[Device]\nVendName = \"open\n;\n", "line 2"),
        ("[Device]\n;\n", "no entry of an EDS"),
    ] {
        let why = parsed(text.as_bytes()).unwrap_err();
        assert!(why.contains(reason), "{text:?}: {why}");
    }
    let binary: Vec<u8> = (0..=255).cycle().take(4000).collect();
    parsed(&binary).unwrap_err();
}

#[test]
fn file_that_does_not_exist_or_is_too_long_is_refused() {
    let missing = read(Path::new("/nonexistent.eds")).unwrap_err();
    assert_eq!((missing.code(), missing.kind().exit_code()), ("no-file", 4));
    let mut text = String::new();
    for index in 0x2000..0x2100 {
        text.push_str(&format!(
            "[{index:04X}]\nParameterName=a\nObjectType=8\nDataType=5\nAccessType=rw\nCompactSubObj=254\n"
        ));
    }
    assert!(parsed(text.as_bytes()).unwrap_err().contains("20000"));
}

#[test]
fn names_are_unique_printable_and_not_in_the_catalogue() {
    let text = "[DeviceInfo]\nProductName=IS2\n\
        [2000]\nParameterName=\u{1b}[2J\u{7}Reset\nDataType=5\nAccessType=rw\n\
        [2001]\nParameterName=\u{3a9}\nDataType=5\nAccessType=rw\n\
        [2002]\nParameterName=object-2001-0\nDataType=5\nAccessType=rw\n\
        [2003]\nDataType=5\nAccessType=rw\n";
    let sheet = parsed(text.as_bytes()).unwrap();
    assert_eq!(sheet.product.name, "is2-eds");
    let names: Vec<&str> = sheet
        .entries
        .iter()
        .map(|entry| entry.name.as_str())
        .collect();
    assert_eq!(names.len(), 4);
    assert_eq!(names[0], "2jreset");
    check_all(&sheet);
}

#[test]
fn file_that_is_read_again_gives_the_same_product_and_too_many_different_ones_are_refused() {
    let mut kept = Vec::new();
    let mut read = |text: &str| parse_among(&mut kept, text.as_bytes());
    let text = |number: usize| FOREIGN.replace("4711", &number.to_string());
    let first = read(&text(0)).unwrap();
    let again = read(&text(0)).unwrap();
    assert!(std::ptr::eq(first.product, again.product));
    // Nothing is kept of a file that is refused.
    for number in 0..2 * MOST_FILES {
        read(&format!("[{number}]")).unwrap_err();
    }
    for number in 1..MOST_FILES {
        let other = read(&text(number)).unwrap();
        assert!(!std::ptr::eq(first.product, other.product));
    }
    let why = read(&text(MOST_FILES)).unwrap_err().to_string();
    assert!(why.contains("start it again"), "{why}");
    assert!(read(&text(0)).is_ok());
}

#[test]
fn latin_1_is_read() {
    let text = b"[2000]\nParameterName=Gr\xF6\xDFe\nDataType=5\nAccessType=rw\n";
    let sheet = parsed(text).unwrap();
    assert_eq!(sheet.entries[0].title, "Gr\u{f6}\u{df}e");
}

/// The data sheets of this project give what the tables give.
#[test]
fn data_sheets_of_the_catalogue_give_its_addresses_types_and_limits() {
    for product in ["jn2101", "ims360", "tiltix080", "tiltix360"] {
        let product = find(product).unwrap();
        let own = Sheet::of(product);
        let sheet = parsed(descriptors::describe(product).text.as_bytes()).unwrap();
        let mut count = 0;
        for entry in &own.entries {
            let Some(found) = sheet
                .entries
                .iter()
                .find(|found| found.address == entry.address)
            else {
                // The objects of DeviceNet itself have no parameter in the data sheet.
                let is_standard = matches!(entry.address, Address::Attribute { class: 1 | 3, .. });
                assert!(is_standard, "{} {}", product.name, entry.name);
                continue;
            };
            count += 1;
            let shape = |entry: &Entry| (entry.data_type, entry.readable, entry.writable);
            assert_eq!(
                shape(found),
                shape(entry),
                "{} {}",
                product.name,
                entry.name
            );
            if let (Permitted::Range(..), false) = (entry.permitted, own.follows_resolution(entry))
            {
                assert_eq!(found.permitted, entry.permitted, "{}", entry.name);
            }
            if let (Some(factory), true) = (entry.factory, found.factory.is_some()) {
                assert_eq!(found.factory, Some(factory), "{}", entry.name);
            }
        }
        assert!(count >= 15, "{} {count}", product.name);
        check_all(&sheet);
    }
}

#[test]
fn devicenet_parameters_have_names_of_numbers_units_and_scales() {
    let text = "$ comment\n[File]\nRevision = 1.0;\n[Device]\n VendCode = 0x13; VendName = \"Maker\"; ProdCode = 5; ProdName = \"Encoder\";\n\
        [Params]\n Param1 = 0, 6, \"20 65 24 01 30 71\", 0x0000, 0xC7, 2, \"Reso\" \"lution; $ [x]\", \"deg\", \"help\", 1, 100, 10, 1,100,1,0, 0,0,0,0, 0;\n\
        Param2 = 0,6,\"20 65 24 01 30 72\",0x0030,2,2,\"Angle\",\"\",\"\",0,0,0,1,1,1,0,0,0,0,0,1; $ measured\n\
        Param3 = 0,6,\"20 65 24 01 30 73\",0x0002,0xC6,1,\"Filter\",\"\",\"\",0,2,1,1,1,1,0,0,0,0,0,0;\n\
        Enum3 = 0, \"off\", 2, \"on\";\n\
        Param4 = 0,6,\"20 65 24 01 30 74\",0,0xCA,4,\"Float\",\"\",\"\",0,2,1,1,1,1,0,0,0,0,0,0;\n\
        Param5 = 0,0,,0,0xC3,2,\"Offset\",\"0 deg\",\"\",-10,10,0,1,1,1,0,0,0,0,0,0;\n\
        [EnumPar]\n Param5 = \"a\";\n";
    let sheet = parsed(text.as_bytes()).unwrap();
    let data_sheet = sheet.data_sheet.as_ref().unwrap();
    assert_eq!(data_sheet.identity, [Some(0x13), Some(5)]);
    assert_eq!(data_sheet.left_out, 1);
    let resolution = named(&sheet, "resolution-x");
    assert_eq!(resolution.text(10), "0.10 deg");
    assert_eq!(resolution.parse("0.5deg"), Ok(50));
    assert_eq!(resolution.permitted, Permitted::Range(1, 100));
    let angle = named(&sheet, "angle");
    assert!(!angle.writable && angle.command);
    assert_eq!(angle.text(123), "12.3");
    assert_eq!(named(&sheet, "filter").parse("on"), Ok(2));
    assert!(named(&sheet, "filter").parse("1").is_err());
    let offset = named(&sheet, "offset");
    let expected = Address::Attribute {
        class: 0x0F,
        instance: 5,
        attribute: 1,
    };
    assert_eq!(offset.address, expected);
    check_all(&sheet);
}

#[test]
fn configuration_file_has_the_values_and_the_commissioning() {
    let sheet = foreign();
    let values: Vec<(Entry, u32)> = [("cob-id-emcy", 0x8B), ("limit-2000-0", 0xFFFE), ("knee", 7)]
        .map(|(name, raw)| (named(&sheet, name).clone(), raw))
        .to_vec();
    let device = dcf::Commissioning {
        file: "a.dcf".to_owned(),
        node: 11,
        name: "boom".to_owned(),
        rate: Some(plumbline::can::BitRate::K125),
        serial: Some(7),
    };
    let text = dcf::text(FOREIGN, &device, &values);
    for expected in [
        "[FileInfo]\r\nFileName=a.dcf\r\nLastEDS=drive.eds\r\n",
        "[1014]\r\nParameterValue=0x8B\r\nParameterName=COB-ID EMCY\r\n",
        "[2000]\r\nParameterValue=-2\r\n",
        "\r\n[2100Value]\r\nNrOfEntries=1\r\n2=7\r\n",
        "\r\n[DeviceComissioning]\r\nNodeID=11\r\nNodeName=boom\r\nBaudrate=125\r\n",
        "LSS_SerialNumber=7\r\n",
    ] {
        assert!(text.contains(expected), "{expected:?} {text}");
    }
    // The second time it replaces what it has written.
    let again = dcf::text(&text, &device, &values);
    for once in ["ParameterValue=-2", "[2100Value]", "[DeviceComissioning]"] {
        assert_eq!(again.matches(once).count(), 1, "{once} {again}");
    }
}
