//! Mistakes in the tables of a product are errors of the compiler at the macro of the table, without code generation, as in `cargo check`.
//! Their messages name the row.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// The product without mistakes.
const PRODUCT: &str = include_str!("product.rs");

/// The macro of each table, whose line the error shows.
const PARAMETERS: &str = "plumbline::project!(parameters);";
const OBJECTS: &str = "plumbline::project!(objects);";

/// A text of the product, another text in its place, the macro and the message.
type Mistake = (&'static str, &'static str, &'static str, &'static str);

#[rustfmt::skip]
const MISTAKES: &[Mistake] = &[
    ("within(1, 100, 50)", "within(1, 100, 101)", PARAMETERS, "parameter 2 \"Limit\": the factory value must be permitted"),
    ("within(1, 100, 50)", "within(1, 256, 50)", PARAMETERS, "parameter 2 \"Limit\": the range must fit the type"),
    ("\"Request\", DataType::U8),", "\"Request\", DataType::U64),", PARAMETERS, "parameter 7 \"Request\": a parameter of 64 bits has two rows"),
    ("profile::node_id(NODE_ID, 20),\n", "", PARAMETERS, "parameter 0 \"Bit rate\": the id of a parameter must be its index"),
    ("[profile::device_type(0x0001_019A), ", "[", OBJECTS, "object 1000h:00: this object is mandatory in CiA 301"),
    (", profile::ERROR_REGISTER]", "]", OBJECTS, "object 1001h:00: this object is mandatory in CiA 301"),
    ("profile::identity(1, 2, 3),\n", "", OBJECTS, "object 1018h:00: this object is mandatory in CiA 301"),
    ("profile::bit_rate(BIT_RATE, 250),", "Parameter { permitted: Permitted::OneOf(&[250, 300]), ..profile::bit_rate(BIT_RATE, 250) },",
        OBJECTS, "parameter 1 \"Bit rate\": BIT_RATES has no bit rate for the permitted number 300"),
    ("const NODE_ID: ParameterId = NODE_ID;", "const NODE_ID: ParameterId = ParameterId(99);", OBJECTS, "NODE_ID: the table has no parameter 99"),
    ("const BIT_RATE: ParameterId = BIT_RATE;", "const BIT_RATE: ParameterId = ParameterId(10);", OBJECTS, "BIT_RATE: the table has no parameter 10"),
    ("Published<2>", "Published<1>", OBJECTS, "quantity 1: the application publishes fewer values"),
    ("history: HISTORY[0]", "history: HISTORY[1]", OBJECTS, "KEPT: the table has no parameter 10"),
    ("\"Error 2\", DataType::U16", "\"Error 2\", DataType::U8", OBJECTS, "parameter 9 \"Error 2\": a hidden parameter is stored on save"),
    ("request: REQUEST", "request: ParameterId(11)", OBJECTS, "KEPT: the table has no parameter 11"),
    ("ErrorHistory<2>", "ErrorHistory<3>", OBJECTS, "object 1003h:01: the dictionary has 2 errors, the capacity of the error history is 3"),
    ("Object::value(0x6011, 0, RATE)", "Object::value(0x6011, 0, ValueId(2))", OBJECTS, "object 6011h:00: the application has no quantity 2"),
    ("Object::parameter(0x2100, 0, LIMIT)", "Object::parameter(0x2100, 0, ParameterId(50))", OBJECTS, "object 2100h:00: the table has no parameter 50"),
    ("Object::parameter(0x2100, 0, LIMIT)", "Object::parameter(0x2100, 0, BIT_RATE)", OBJECTS, "object 2100h:00: this parameter is in two rows"),
    ("Object::parameter(0x2100, 0, LIMIT)", "Object::parameter(0x1F00, 0, LIMIT)", OBJECTS, "object 1F00h:00: rows must be sorted"),
    ("TpdoArray<1, 1>", "TpdoArray<2, 1>", OBJECTS, "object 1801h:01: the number of TPDOs is not that of the dictionary"),
    ("0x6010_0010", "0x6010_0020", OBJECTS, "object 1A00h:01: the mapped object 6010h:00 has another length"),
    ("0x6010_0010", "0x6012_0010", OBJECTS, "object 1A00h:01: the mapped object 6012h:00 does not exist"),
    ("type Consumers = Absent;", "type Consumers = plumbline::canopen::Heartbeats<1>;", OBJECTS, "object 1016h:01: the number of entries is not that of `Consumers`"),
    // Without a stored request, each group has a range of indices.
    ("const KEPT: Option<Kept> = Some(Kept {\n        request: REQUEST,\n        history: HISTORY[0],\n    });\n", "const GROUPS: &'static [(u16, u16)] = &[];\n",
        OBJECTS, "object 1010h:04: there is no group of parameters for this sub-index"),
];

/// The directory with the compiled library and those on which it depends.
fn libraries() -> PathBuf {
    let test = env::current_exe().unwrap();
    test.parent().unwrap().to_owned()
}

/// The library `plumbline`: the newest one, because other builds leave theirs.
fn library(libraries: &Path) -> PathBuf {
    let files = fs::read_dir(libraries)
        .unwrap()
        .map(|file| file.unwrap().path());
    let is_own = |file: &PathBuf| {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        name.starts_with("libplumbline-") && name.ends_with(".rlib")
    };
    let changed = |file: &PathBuf| fs::metadata(file).unwrap().modified().unwrap();
    files.filter(is_own).max_by_key(changed).unwrap()
}

/// Compiles a product without code generation. Returns the errors.
fn compile(name: &str, product: &str) -> String {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let file = directory.join(format!("mistake_{name}.rs"));
    fs::write(&file, product).unwrap();
    let libraries = libraries();
    let output = Command::new(env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args([
            "--edition=2024",
            "--crate-type=lib",
            "--emit=metadata",
            "--cap-lints=allow",
        ])
        .arg(format!("--out-dir={}", directory.display()))
        .arg(format!("-Ldependency={}", libraries.display()))
        .arg(format!(
            "--extern=plumbline={}",
            library(&libraries).display()
        ))
        .arg(&file)
        .output()
        .unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.success(), errors.is_empty(), "{errors}");
    errors
}

#[test]
fn product_without_mistakes_compiles() {
    assert_eq!(compile("none", PRODUCT), "");
}

#[test]
fn each_mistake_is_an_error_at_its_table_that_names_the_row() {
    for (number, (text, other, table, message)) in MISTAKES.iter().enumerate() {
        assert!(PRODUCT.contains(text), "{text}");
        let product = PRODUCT.replace(text, other);
        let errors = compile(&number.to_string(), &product);
        let expected = format!("error[E0080]: evaluation panicked: {message}");
        assert!(errors.contains(&expected), "{other}\n{errors}");
        let line = 1 + product
            .lines()
            .position(|line| line.trim() == *table)
            .unwrap();
        let place = format!("mistake_{number}.rs:{line}:");
        assert!(errors.contains(&place), "{other}: {place}\n{errors}");
    }
}
