//! The tables of the products are the only source of the behaviour: when two rows, two codes, two reply fields or two meanings
//! are swapped in a copy of a table, the copy does not build, or the tests `wire` of core fail.
//!
//! It builds core many times, so it runs only on request: `cargo test -p host-tests --test table_mutations -- --ignored`.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{fs, io};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
const COPY: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/mutant");

/// Two texts of a file that are swapped. Each of them occurs once in the file.
struct Swap {
    file: &'static str,
    texts: [&'static str; 2],
}

const fn swap(file: &'static str, texts: [&'static str; 2]) -> Swap {
    Swap { file, texts }
}

const FUNCTIONS: &str = "gemac/functions.rs";
const GEMAC: &str = "gemac/parameters.rs";
const IS1: &str = "gemac/is1.rs";
const IS2: &str = "gemac/is2.rs";
const OBJECTS: &str = "jn2101/objects.rs";
const JN2101: &str = "jn2101/parameters.rs";
const IMS360_OBJECTS: &str = "ims360/objects.rs";
const IMS360: &str = "ims360/parameters.rs";
const TILTIX_OBJECTS: &str = "tiltix/objects.rs";
const TILTIX: &str = "tiltix/parameters.rs";
const PROFILE: &str = "../canopen/profile.rs";

/// The swaps, for each kind of entry in the tables of GEMAC's products, of the JN2101, of the IMS360 and of the TILTIX.
const SWAPS: &[Swap] = &[
    // Rows.
    swap(
        FUNCTIONS,
        ["&[id::CYCLIC_TIME]),\n", "&[id::CYCLIC_MODE]),\n"],
    ),
    swap(FUNCTIONS, ["&[id::ZERO_X]", "&[id::ZERO_Y]"]),
    swap(FUNCTIONS, ["&[id::CUT_OFF, ", "id::FILTER_TYPE],"]),
    swap(FUNCTIONS, ["reply_id: id::", "sync_id: id::"]),
    swap(IS1, ["        CYCLIC_TIME,\n", "        CYCLIC_MODE,\n"]),
    swap(IS2, ["        SYNC_ID,\n", "        BAUD_RATE,\n"]),
    swap(
        OBJECTS,
        [
            "    parameter(0x2041, id::HEATING),\n",
            "    parameter(0x2042, id::TEACH),\n",
        ],
    ),
    swap(
        JN2101,
        [
            "profile::guard_time(id::GUARD_TIME)",
            "profile::life_time_factor(id::LIFE_TIME_FACTOR)",
        ],
    ),
    swap(TILTIX_OBJECTS, ["id::SIZE,", "id::TERMINATION,"]),
    swap(
        TILTIX_OBJECTS,
        ["polled_assembly: id::", "cyclic_assembly: id::"],
    ),
    swap(
        TILTIX_OBJECTS,
        ["value::SLOPE[axis]", "value::DIAGNOSTIC[axis]"],
    ),
    swap(
        TILTIX,
        ["\"0.1 deg\", Resolution(10)", "\"1 deg\", Resolution(100)"],
    ),
    // Codes.
    swap(FUNCTIONS, ["access(0x11, 0x21,", "access(0x12, 0x22,"]),
    swap(FUNCTIONS, ["code: 0x03,", "code: 0x04,"]),
    swap(FUNCTIONS, ["code: 0x40,", "code: 0x50,"]),
    swap(FUNCTIONS, ["b\"LOAD\"", "b\"SAVE\""]),
    swap(OBJECTS, ["id::QUADRANT", "id::DEFINITION"]),
    swap(OBJECTS, ["id::TPDO0)", "id::TPDO1)"]),
    swap(OBJECTS, ["value::TEMPERATURE", "value::HEATING_POWER"]),
    // Reply fields.
    swap(
        FUNCTIONS,
        [
            "Field::described(Source::Value(ANGLE_X)),\n",
            "Field::described(Source::Value(ANGLE_Y)),\n",
        ],
    ),
    swap(
        FUNCTIONS,
        [
            "named(Source::ProductNumber, \"Product Number\")",
            "named(Source::Revision, \"Revision\")",
        ],
    ),
    swap(
        FUNCTIONS,
        [
            "bit(\"SensorErrorX\", Condition::Fault(Faults::X))",
            "bit(\"SensorErrorY\", Condition::Fault(Faults::Y))",
        ],
    ),
    swap(
        FUNCTIONS,
        ["Condition::DefaultParam", "Condition::AutobaudDetection"],
    ),
    swap(
        OBJECTS,
        [
            "profile::entry(0x6010, 0, 16)",
            "profile::entry(0x6020, 0, 16)",
        ],
    ),
    swap(
        OBJECTS,
        [
            "profile::entry(0x6110, 0, 32)",
            "profile::entry(0x6120, 0, 32)",
        ],
    ),
    // Meanings.
    swap(PROFILE, ["BitRate::K125", "BitRate::K250"]),
    swap(GEMAC, ["Some(BitRate::K125)", "Some(BitRate::K250)"]),
    swap(GEMAC, ["Kind::Off),", "Kind::Butterworth),"]),
    swap(JN2101, ["Cutoff::TenHertz", "Cutoff::OneHertz"]),
    swap(JN2101, ["Definition::Euler)", "Definition::GimbalX)"]),
    swap(
        JN2101,
        ["Quadrants::FourSigned)", "Quadrants::FourUnsigned)"],
    ),
    swap(IMS360, ["Kind::Off),", "Kind::Butterworth),"]),
    swap(IMS360_OBJECTS, ["id::ZERO_X)", "id::ZERO_Y)"]),
    swap(IMS360_OBJECTS, ["value::X)", "value::Y)"]),
    swap(IMS360_OBJECTS, ["value::FORCE16)", "value::RATE16)"]),
    swap(IMS360_OBJECTS, ["2, id::FUSION)", "1, id::FILTER_TYPE)"]),
    swap(IMS360_OBJECTS, ["id::TPDO[2])", "id::TPDO[3])"]),
    swap(IMS360_OBJECTS, ["id::PROTOCOL)", "id::BUS_OFF_RECOVERY)"]),
];

/// Copies a file or a folder.
fn copy(from: &Path, to: &Path) -> io::Result<()> {
    if from.is_dir() {
        fs::create_dir_all(to)?;
        for entry in fs::read_dir(from)? {
            let name = entry?.file_name();
            copy(&from.join(&name), &to.join(&name))?;
        }
    } else if fs::read(to).ok() != Some(fs::read(from)?) {
        fs::copy(from, to)?;
    }
    Ok(())
}

fn copy_core() -> PathBuf {
    let copied = PathBuf::from(COPY);
    let _ = fs::remove_dir_all(copied.join("core"));
    fs::create_dir_all(&copied).expect("a folder");
    for name in ["Cargo.lock", "core"] {
        copy(&Path::new(ROOT).join(name), &copied.join(name)).expect("a copy");
    }
    // A workspace with only core.
    let manifest = fs::read_to_string(Path::new(ROOT).join("Cargo.toml")).expect("a manifest");
    let (_, after) = manifest
        .split_once("\n[workspace.package]")
        .expect("the package's fields");
    let manifest = format!(
        "[workspace]\nmembers = [\"core\"]\nresolver = \"3\"\n\n[workspace.package]{after}"
    );
    fs::write(copied.join("Cargo.toml"), manifest).expect("a manifest");
    copied
}

/// Whether the tests `wire` of core pass.
fn passes() -> bool {
    let output = Command::new(env!("CARGO"))
        .args([
            "test",
            "--quiet",
            "--offline",
            "-p",
            "core",
            "--test",
            "wire",
        ])
        .args([
            "--config",
            "profile.test.opt-level=0",
            "--config",
            "profile.test.debug=0",
        ])
        .current_dir(COPY)
        .env(
            "CARGO_TARGET_DIR",
            concat!(env!("CARGO_TARGET_TMPDIR"), "/mutants"),
        )
        .output()
        .expect("cargo runs");
    output.status.success()
}

#[test]
#[ignore = "builds core many times; .ci/run runs it"]
fn swapped_entries_of_a_table_are_detected() {
    let copied = copy_core();
    assert!(passes(), "the copy without a swap must pass");
    let mut undetected = Vec::new();
    for Swap { file, texts } in SWAPS {
        let path = copied.join("core/src/model").join(file);
        let original = fs::read_to_string(&path).expect("a file");
        for text in texts {
            assert_eq!(original.matches(text).count(), 1, "{file}: {text}");
        }
    }
    for Swap {
        file,
        texts: [a, b],
    } in SWAPS
    {
        let path = copied.join("core/src/model").join(file);
        let original = fs::read_to_string(&path).expect("a file");
        let swapped = original
            .replace(a, "\u{0}")
            .replace(b, a)
            .replace('\u{0}', b);
        fs::write(&path, swapped).expect("a file");
        if passes() {
            undetected.push(format!("{file}: {a:?} and {b:?}"));
        }
        fs::write(&path, original).expect("a file");
    }
    assert!(passes(), "the copy without a swap must still pass");
    assert!(undetected.is_empty(), "{undetected:#?}");
}
