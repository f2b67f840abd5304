//! A new product needs its file or folder, a line of the catalogue and a program for the boards, and no other change. The test applies the
//! patches in `host-tests/new-products`, one of each kind, to a copy of the tree.
//!
//! It builds the copy, so it runs only on request: `cargo test -p host-tests --test new_products`. With `PLUMBLINE_LONG=1` it runs all
//! tests on the copy.

use host_tests::effort;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::{fs, io};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// The existing files that a patch may change.
const LISTS: [&str; 3] = [
    "core/src/model/catalog.rs",
    "core/src/model/mod.rs",
    "core/src/model/gemac/mod.rs",
];

/// Each new product: its patch, its name, its description.
const PRODUCTS: [[&str; 3]; 2] = [
    // It differs from another one by constants only.
    ["constants.patch", "is2lean", "is2lean.dbc"],
    ["canopen.patch", "mast", "mast.eds"],
];

/// All runs share this folder, so that other packages are built once.
const TARGET: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/new-products-target");

/// The target of the Blue Pill.
const BOARD: &str = "thumbv7m-none-eabi";

/// A copy of the tree with the new products.
struct Copied {
    root: PathBuf,
}

impl Copied {
    fn new() -> Self {
        let root = Path::new(env!("CARGO_TARGET_TMPDIR")).join("new-products");
        let _ = fs::remove_dir_all(&root);
        copy(Path::new(ROOT), &root).expect("the tree can be copied");
        let copied = Self { root };
        // The copy is a repository of its own. Otherwise git would apply the patch to the enclosing repository.
        copied.run("git", &["init", "--quiet"]);
        for [patch, ..] in PRODUCTS {
            let patch = Path::new(ROOT).join("host-tests/new-products").join(patch);
            let text = fs::read_to_string(&patch).expect("a patch");
            for path in text.lines().filter_map(|line| line.strip_prefix("--- a/")) {
                assert!(LISTS.contains(&path), "a new product changes {path}");
            }
            copied.run("git", &["apply", &patch.display().to_string()]);
        }
        copied
    }

    fn command(&self, program: &str, arguments: &[&str]) -> Command {
        let mut command = Command::new(program);
        command
            .args(arguments)
            .current_dir(&self.root)
            .env("CARGO_TARGET_DIR", TARGET);
        command
    }

    #[track_caller]
    fn run(&self, program: &str, arguments: &[&str]) -> String {
        let output = self.command(program, arguments).output();
        let output = output.unwrap_or_else(|error| panic!("{program}: {error}"));
        let [text, errors] = [output.stdout, output.stderr].map(|bytes| {
            let text = String::from_utf8_lossy(&bytes);
            text.into_owned()
        });
        assert!(
            output.status.success(),
            "{program} {arguments:?}\n{text}\n{errors}"
        );
        text
    }

    #[track_caller]
    fn cargo(&self, arguments: &[&str]) -> String {
        self.run(env!("CARGO"), arguments)
    }

    /// Runs cargo for the PC. The simulator of the microcontroller only starts, so it is not optimized except in a long run.
    #[track_caller]
    fn host(&self, command: &str, arguments: &[&str]) {
        let fast = ["--config", "profile.dev.package.stm32-sim.opt-level=0"];
        let options = effort::choose(&fast[..], &[]);
        self.cargo(&[&[command, "--quiet"], options, arguments].concat());
    }

    /// The virtual sensor of a product is on its bus.
    fn starts(&self, name: &str, more: &[&str]) {
        let program = Path::new(TARGET).join("debug/virtual-sensor");
        let options = ["--model", name, "--listen", "127.0.0.1:0"];
        let mut sensor = Command::new(program)
            .args([&options, more].concat())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the virtual sensor runs");
        let mut line = String::new();
        if let Some(output) = sensor.stdout.take() {
            BufReader::new(output).read_line(&mut line).expect("a line");
        }
        sensor.kill().expect("it runs");
        sensor.wait().expect("it ends");
        assert!(line.starts_with("slcan socket://"), "{name}: {line}");
    }
}

/// Copies the files of a folder, except what is built and the repository.
fn copy(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in from.read_dir()? {
        let entry = entry?;
        let (name, path) = (entry.file_name(), entry.path());
        if ["target", ".git"].iter().any(|own| name == *own) {
            continue;
        }
        if path.is_dir() {
            copy(&path, &to.join(name))?;
        } else {
            fs::copy(&path, to.join(name))?;
        }
    }
    Ok(())
}

#[test]
fn new_product_in_the_tree_builds_and_changes_only_product_lists() {
    let copied = Copied::new();
    // Documents and traces; in a long run all tests. Without a selection of packages, all commands build the same libraries.
    let few: &[&str] = &["--test", "sensor", "--", "documents", "core_passes"];
    copied.host("test", effort::choose(few, &["--no-fail-fast"]));
    if effort::choose(false, true) {
        copied.host("test", &["--no-fail-fast", "--test", "images"]);
    }
    copied.host("build", &["--bin", "virtual-sensor"]);
    let out = copied.root.join("descriptions").display().to_string();
    copied.host("run", &["--bin", "descriptors", "--", "--out", &out]);
    let programs = PRODUCTS.iter().flat_map(|[_, name, _]| ["--bin", name]);
    let board = [
        "build",
        "-q",
        "--release",
        "-p",
        "firmware-stm32",
        "--target",
        BOARD,
    ];
    copied.cargo(&board.into_iter().chain(programs).collect::<Vec<_>>());
    for [_, name, description] in PRODUCTS {
        assert!(Path::new(&out).join(description).exists(), "{description}");
        copied.starts(name, &[]);
        let image = Path::new(TARGET).join(BOARD).join("release").join(name);
        let image = image.display().to_string();
        copied.starts(name, &["--elf", &image]);
        // Its messages are those of its protocol, or made from its tables.
        let cost = [
            "run", "-q", "--bin", "cost", "--", "--model", name, "--quick", "--elf", &image,
        ];
        let figures = copied.cargo(&cost);
        assert!(
            figures.contains("end of SYNC to reply, worst case"),
            "{figures}"
        );
    }
}
