//! Builds the firmware as it is flashed, to run its image on the PC.

use super::board::Board;
use super::elf::scan;
use cargo_metadata::Message;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fmt;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The reason why there is no image.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("the firmware cannot be built: {0}")]
pub struct BuildError(String);

impl BuildError {
    fn new(what: &str, why: impl fmt::Display) -> Self {
        Self(format!("{what}: {why}"))
    }
}

/// The ELF files of these programs, as they are flashed to a board, by name; builds those that are not up to
/// date. Each is checked ([`check`]).
///
/// Installs the target with rustup if it is missing.
///
/// # Errors
/// There is no program of a name, the build fails, a program has an unsafe instruction, or the target is missing and there is no rustup.
pub fn build(board: Board, names: &[&str]) -> Result<BTreeMap<String, PathBuf>, BuildError> {
    build_with(board, names, None)
}

/// The folder of a board in the target directory, as in its alias of cargo: two boards have the target of the Blue Pill, and the images of
/// one would replace those of the other.
fn own_folder(board: Board) -> Option<&'static str> {
    (board == Board::NucleoF103).then(|| board.facts().name)
}

/// The folder of the images of a board in the target directory.
pub fn folder(board: Board) -> PathBuf {
    let own = own_folder(board).unwrap_or_default();
    Path::new(own).join(board.facts().target).join("release")
}

/// As [`build`], with the log.
///
/// # Errors
/// As [`build`].
pub fn build_with_log(
    board: Board,
    names: &[&str],
) -> Result<BTreeMap<String, PathBuf>, BuildError> {
    build_with(board, names, Some("defmt"))
}

/// As [`build`], for the measuring element with this feature.
///
/// # Errors
/// As [`build`].
pub fn build_for_element(
    board: Board,
    names: &[&str],
    element: &str,
) -> Result<BTreeMap<String, PathBuf>, BuildError> {
    build_with(board, names, Some(element))
}

/// As [`build`], for a flash that begins with the bootloader of the board.
///
/// # Errors
/// As [`build`].
pub fn build_behind_bootloader(
    board: Board,
    names: &[&str],
) -> Result<BTreeMap<String, PathBuf>, BuildError> {
    build_with(board, names, Some("behind-bootloader"))
}

/// As [`build`], with a bootloader that checks signatures.
///
/// # Errors
/// As [`build`].
pub fn build_with_signatures(
    board: Board,
    names: &[&str],
) -> Result<BTreeMap<String, PathBuf>, BuildError> {
    build_with(board, names, Some("signature"))
}

/// Builds for a board and with another feature. Each feature and each board has a folder of its own, because images of one replace those of
/// another.
fn build_with(
    board: Board,
    names: &[&str],
    feature: Option<&str>,
) -> Result<BTreeMap<String, PathBuf>, BuildError> {
    let target = board.facts().target;
    let features: Vec<&str> = [board.facts().name].into_iter().chain(feature).collect();
    let folder = feature.map(|it| format!("with-{it}"));
    let folder: PathBuf = [folder.as_deref(), own_folder(board)]
        .into_iter()
        .flatten()
        .collect();
    add_target(target)?;
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut build = Command::new(cargo)
        .args(["build", "--locked", "--release", "--quiet"])
        .args(["--package", "firmware-stm32", "--target", target])
        .args(names.iter().flat_map(|name| ["--bin", name]))
        .args(["--no-default-features", "--features", &features.join(",")])
        .args(into_folder(&folder))
        .arg("--message-format=json-render-diagnostics")
        // They are for the programs of the PC, and would replace those of the board.
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .current_dir(workspace())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|error| BuildError::new("cargo", error))?;
    let mut images = BTreeMap::new();
    if let Some(output) = build.stdout.take() {
        for message in Message::parse_stream(BufReader::new(output)) {
            if let Ok(Message::CompilerArtifact(artifact)) = message
                && let Some(path) = artifact.executable
            {
                images.insert(artifact.target.name, path.into_std_path_buf());
            }
        }
    }
    let status = build
        .wait()
        .map_err(|error| BuildError::new("cargo", error))?;
    if !status.success() {
        return Err(BuildError::new("cargo build", status));
    }
    images.values().try_for_each(|path| check(path))?;
    Ok(images)
}

/// Checks that an image has no instruction that an erratum of its processor makes unsafe.
///
/// # Errors
/// The file is not an image, or has such an instruction.
pub fn check(path: &Path) -> Result<(), BuildError> {
    let file = path.display().to_string();
    let elf = std::fs::read(path).map_err(|error| BuildError::new(&file, error))?;
    let found = scan::unsafe_instructions(&elf).map_err(|error| BuildError::new(&file, error))?;
    match found.first() {
        None => Ok(()),
        Some(first) => Err(BuildError::new(
            &file,
            format!("unsafe instruction at {first}"),
        )),
    }
}

/// The options that put the programs into a folder of the target directory. What several folders need is built once.
fn into_folder(name: &Path) -> [OsString; 4] {
    let shared = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    let shared = shared.unwrap_or_else(|| workspace().join("target"));
    [
        "--target-dir".into(),
        shared.join(name).into(),
        "--config".into(),
        format!("build.build-dir='{}'", shared.display()).into(),
    ]
}

/// Ensures that the standard library for the board is installed.
fn add_target(target: &str) -> Result<(), BuildError> {
    let output = Command::new("rustc")
        .args(["--print", "target-libdir", "--target", target])
        .current_dir(workspace())
        .output()
        .map_err(|error| BuildError::new("rustc", error))?;
    let library = String::from_utf8_lossy(&output.stdout);
    if Path::new(library.trim()).is_dir() {
        return Ok(());
    }
    eprintln!("adding the target {target} with rustup");
    let status = Command::new("rustup")
        .args(["target", "add", target])
        .current_dir(workspace())
        .status()
        .map_err(|error| BuildError::new("rustup", error))?;
    if status.success() {
        Ok(())
    } else {
        Err(BuildError::new("rustup target add", status))
    }
}

/// The root of the project.
fn workspace() -> &'static Path {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.ancestors().nth(2).unwrap_or(own)
}
