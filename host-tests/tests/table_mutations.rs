//! The tables of the products are the only source of the behaviour: when two rows, two codes, two reply fields or two meanings
//! are swapped in a copy of a table, the copy does not build, or the tests `wire` of core fail.
//!
//! It builds core many times, so it runs only on request: `cargo test --test table_mutations`. With
//! `PLUMBLINE_SWAPS=j1939` in the environment, only the swaps with this text in their path or texts are made.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Mutex, PoisonError};
use std::{fs, io, iter, thread};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
const MODEL: &str = "core/src/model";

/// Two texts of a file that are swapped. Each of them occurs once in the file. If the second one does not occur, it replaces the first
/// one.
struct Swap {
    file: &'static str,
    texts: [&'static str; 2],
}

const fn swap(file: &'static str, texts: [&'static str; 2]) -> Swap {
    Swap { file, texts }
}

const FUNCTIONS: &str = "gemac/functions.rs";
const GEMAC: &str = "gemac/parameters.rs";
const IS2: &str = "gemac/is2.rs";
const OBJECTS: &str = "jn2101/objects.rs";
const JN2101: &str = "jn2101/parameters.rs";
const IMS360_OBJECTS: &str = "ims360/objects.rs";
const IMS360: &str = "ims360/parameters.rs";
const TILTIX_OBJECTS: &str = "tiltix/objects.rs";
const TILTIX: &str = "tiltix/parameters.rs";
const IMS360_J1939: &str = "ims360/j1939.rs";
const PROFILE: &str = "../canopen/profile.rs";
const GROUPS: &str = "../j1939/groups.rs";
const NAME: &str = "../j1939/name.rs";

/// The swaps, for each kind of entry in the tables of GEMAC's products, of the JN2101, of the IMS360 and of the TILTIX.
const SWAPS: &[Swap] = &[
    // Rows.
    swap(
        FUNCTIONS,
        ["&[id::CYCLIC_TIME]),\n", "&[id::CYCLIC_MODE]),\n"],
    ),
    swap(FUNCTIONS, ["&[id::ZERO_X]", "&[id::ZERO_Y]"]),
    swap(
        FUNCTIONS,
        [
            "        &[id::CUT_OFF, id::FILTER_TYPE],\n",
            "        &[id::FILTER_TYPE, id::CUT_OFF],\n",
        ],
    ),
    swap(FUNCTIONS, ["reply_id: id::", "sync_id: id::"]),
    swap(GEMAC, ["\n    CYCLIC_TIME,", "\n    CYCLIC_MODE,"]),
    swap(GEMAC, ["\n    SYNC_ID,", "\n    BAUD_RATE,"]),
    swap(
        IS2,
        ["signed_offset(id::ZERO_X", "signed_offset(id::ZERO_Y"],
    ),
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
        [
            "&value::SLOPE, axis), UNIT",
            "&value::DIAGNOSTIC, axis), \"\"",
        ],
    ),
    swap(
        TILTIX,
        ["\"0.1 deg\", Resolution(10)", "\"1 deg\", Resolution(100)"],
    ),
    // Codes.
    swap(
        FUNCTIONS,
        ["Access::new(0x11, 0x21,", "Access::new(0x12, 0x22,"],
    ),
    swap(FUNCTIONS, ["new(0x03,", "new(0x04,"]),
    swap(FUNCTIONS, ["new(0x40,", "new(0x50,"]),
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
            "StatusBit::new(\"SensorErrorX\", Condition::Fault(Faults::X))",
            "StatusBit::new(\"SensorErrorY\", Condition::Fault(Faults::Y))",
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
    swap(GEMAC, ["Kind::Analog),", "Kind::Butterworth),"]),
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
    // J1939: objects, factory values, groups, fields of the NAME, trouble codes.
    swap(IMS360_OBJECTS, ["id::J1939_RATES[0]", "id::J1939_RATES[1]"]),
    swap(
        IMS360_OBJECTS,
        ["id::J1939_PRIORITIES[2]", "id::J1939_PRIORITIES[3]"],
    ),
    swap(IMS360_OBJECTS, ["id::J1939_NAME[4]", "id::J1939_NAME[5]"]),
    swap(IMS360_OBJECTS, ["id::J1939_NAME[1]", "id::J1939_NAME[3]"]),
    swap(
        IMS360,
        [
            "\"Transmission rate SSI2\", 10",
            "\"Transmission rate SSI\", 0",
        ],
    ),
    swap(IMS360_J1939, ["id::J1939_RATES", "id::J1939_PRIORITIES"]),
    swap(IMS360_J1939, ["[y, x, z]", "[z, x, y]"]),
    swap(IMS360_J1939, ["number: pitch,", "number: roll,"]),
    swap(IMS360_J1939, ["groups::PITCH_SPN", "groups::ROLL_SPN"]),
    swap(IMS360_J1939, ["u32 = 168;", "u32 = 630;"]),
    swap(IMS360_J1939, ["u8 = 3;", "u8 = 4;"]),
    swap(GROUPS, ["], 61_481", "], 61_459"]),
    swap(GROUPS, ["], 61_482", "], 61_485"]),
    swap(GROUPS, ["u32 = 4976;", "u32 = 4977;"]),
    swap(GROUPS, ["PITCH_SPN, 0,", "ROLL_SPN, 24,"]),
    swap(GROUPS, ["3318, 0,", "3319, 16,"]),
    swap(
        GROUPS,
        ["((2, 1000), -64, \"deg/s\")", "((1, 128), -250, \"deg/s\")"],
    ),
    swap(
        GROUPS,
        [
            "\"LateralAcceleration\", 0,",
            "\"LongitudinalAcceleration\", 16,",
        ],
    ),
    swap(
        GROUPS,
        ["\"PitchRateExRange\", 0,", "\"YawRateExRange\", 32,"],
    ),
    swap(GROUPS, ["4979, 50,", "4981, 54,"]),
    swap(NAME, ["(56, 4)", "(60, 3)"]),
    swap(NAME, ["(35, 5)", "(32, 3)"]),
];

/// The environment variable with the text that selects swaps.
const SELECTION: &str = "PLUMBLINE_SWAPS";

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

/// Whether the compiler reports an error with a place in core. Empty lines separate its messages.
fn has_error_in_core(text: &str) -> bool {
    text.split("\n\n")
        .any(|part| part.starts_with("error") && part.contains("--> core/"))
}

/// A copy of core that is built in its own folder.
struct Copied {
    sources: PathBuf,
    target: PathBuf,
}

impl Copied {
    fn new(number: usize) -> Self {
        let folder =
            |name: &str| Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{number}"));
        let (sources, target) = (folder("mutant"), folder("mutants"));
        let _ = fs::remove_dir_all(sources.join("core"));
        fs::create_dir_all(&sources).expect("a folder");
        for name in ["Cargo.lock", "core"] {
            copy(&Path::new(ROOT).join(name), &sources.join(name)).expect("a copy");
        }
        // A workspace with only core.
        let manifest = fs::read_to_string(Path::new(ROOT).join("Cargo.toml")).expect("a manifest");
        let (_, after) = manifest
            .split_once("\n[workspace.package]")
            .expect("the package's fields");
        let manifest = format!(
            "[workspace]\nmembers = [\"core\"]\nresolver = \"3\"\n\n[workspace.package]{after}"
        );
        fs::write(sources.join("Cargo.toml"), manifest).expect("a manifest");
        Self { sources, target }
    }

    /// Runs the tests `wire` of core. Whether they pass, and the output.
    fn run(&self) -> (bool, String) {
        let Output {
            status,
            stdout,
            stderr,
        } = Command::new(env!("CARGO"))
            .args([
                "test",
                "--quiet",
                "--offline",
                "-p",
                "core",
                "--test",
                "wire",
            ])
            .args(["--config", "profile.test.opt-level=0"])
            .args(["--config", "profile.test.debug=0"])
            .current_dir(&self.sources)
            .env("CARGO_TARGET_DIR", &self.target)
            .output()
            .expect("cargo runs");
        let texts = [stdout, stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
        (status.success(), texts.concat())
    }

    /// Fails if the tests fail without a swap.
    fn must_pass(&self) {
        let (passed, text) = self.run();
        assert!(passed, "the copy without a swap must pass:\n{text}");
    }

    /// Whether the copy with a swap does not build, or its tests fail.
    fn detects(&self, swap: &Swap) -> bool {
        let [a, b] = swap.texts;
        let path = self.sources.join(MODEL).join(swap.file);
        let original = fs::read_to_string(&path).expect("a file");
        let swapped = original
            .replace(a, "\u{0}")
            .replace(b, a)
            .replace('\u{0}', b);
        fs::write(&path, swapped).expect("a file");
        let (passed, text) = self.run();
        fs::write(&path, original).expect("a file");
        // Another failure, such as a full disk, detects nothing.
        assert!(
            passed || text.contains("test result: FAILED") || has_error_in_core(&text),
            "{}: {a:?} and {b:?}: neither the build nor a test has failed because of the swap:\n{text}",
            swap.file
        );
        !passed
    }

    /// Takes swaps until none is left. Returns those that are not detected.
    fn undetected<'a>(&self, swaps: &Mutex<impl Iterator<Item = &'a Swap>>) -> Vec<String> {
        self.must_pass();
        let next = || swaps.lock().unwrap_or_else(PoisonError::into_inner).next();
        let undetected = iter::from_fn(next)
            .filter(|swap| !self.detects(swap))
            .map(
                |Swap {
                     file,
                     texts: [a, b],
                 }| format!("{file}: {a:?} and {b:?}"),
            )
            .collect();
        self.must_pass();
        undetected
    }
}

/// `.ci/run` runs this test alone, so that a change of a table changes the swaps too.
#[test]
fn texts_of_all_swaps_occur_once() {
    for Swap { file, texts } in SWAPS {
        let path = Path::new(ROOT).join(MODEL).join(file);
        let original = fs::read_to_string(&path).expect("a file");
        let [first, second] = texts.map(|text| original.matches(text).count());
        assert!(first == 1 && second <= 1, "{file}: {texts:?}");
    }
}

#[test]
fn swapped_entries_of_a_table_are_detected() {
    let selection = std::env::var(SELECTION).unwrap_or_default().to_lowercase();
    let is_selected = |swap: &&Swap| {
        let mut texts = swap.texts.iter().chain([&swap.file]);
        texts.any(|text| text.to_lowercase().contains(&selection))
    };
    let swaps = Mutex::new(SWAPS.iter().filter(is_selected));
    // The compiler uses one processor for most of the time.
    let copies = thread::available_parallelism().map_or(1, usize::from);
    let undetected: Vec<String> = thread::scope(|scope| {
        let swaps = &swaps;
        let workers: Vec<_> = (0..copies)
            .map(|number| scope.spawn(move || Copied::new(number).undetected(swaps)))
            .collect();
        let ended = workers
            .into_iter()
            .map(|worker| worker.join().expect("a worker"));
        ended.flatten().collect()
    });
    assert!(undetected.is_empty(), "{undetected:#?}");
}
