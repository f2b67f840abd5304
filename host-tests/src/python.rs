//! Clients written in Python, which the tests run.
//!
//! They need the packages of `clients/requirements.txt` and `clients/requirements-no-deps.txt`; `clients/constraints.txt` has the
//! versions of the packages that those need. The first test that runs a client
//! installs the packages into the virtual environment `clients-venv` in the target directory. `PLUMBLINE_PYTHON` selects another interpreter. Without `python3` or
//! without a package registry the tests print `skipped`. In a continuous integration run (`CI` is set) they fail.

use std::fs::{self, File};
use std::io::{Write, stderr};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

/// Runs `clients/SCRIPT` with these arguments and panics if it fails. `modules` are the modules outside the standard library that
/// it imports.
#[track_caller]
pub fn run(script: &str, modules: &[&str], arguments: &[&str]) {
    let python = match interpreter(modules) {
        Ok(python) => python,
        Err(reason) => {
            assert!(std::env::var_os("CI").is_none(), "{script}: {reason}");
            // Written directly to standard error, which the test harness does not capture.
            let _ = writeln!(stderr(), "skipped: {script}: {reason}");
            return;
        }
    };
    let path = clients().join(script);
    let output = Command::new(python)
        .arg(path)
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .expect("the interpreter starts");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success(),
        "{script} failed:\n{text}{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

/// An interpreter that has these modules, or the reason why there is none.
fn interpreter(modules: &[&str]) -> Result<PathBuf, String> {
    if let Some(named) = std::env::var_os("PLUMBLINE_PYTHON") {
        return Some(PathBuf::from(named))
            .filter(|python| has(python, modules))
            .ok_or_else(|| format!("PLUMBLINE_PYTHON has no {}", modules.join(", ")));
    }
    // One installation for all tests of this process.
    static ENVIRONMENT: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    let environment = ENVIRONMENT.get_or_init(environment).clone();
    if let Ok(python) = &environment
        && has(python, modules)
    {
        return Ok(python.clone());
    }
    // Without an installation, the packages of the system are used.
    let system = PathBuf::from("python3");
    if has(&system, modules) {
        return Ok(system);
    }
    Err(environment
        .err()
        .unwrap_or_else(|| format!("no {}", modules.join(", "))))
}

/// Whether an interpreter can import these modules.
fn has(python: &Path, modules: &[&str]) -> bool {
    let program = format!("import {}", modules.join(", "));
    let mut command = Command::new(python);
    let status = command.arg("-c").arg(program).stdin(Stdio::null());
    let status = status.stdout(Stdio::null()).stderr(Stdio::null()).status();
    status.is_ok_and(|status| status.success())
}

/// The interpreter of the virtual environment, which is installed if it is missing or outdated.
fn environment() -> Result<PathBuf, String> {
    /// The packages, those that are installed without their dependencies and without a check of the version of Python, and the
    /// versions of the packages that they need.
    const REQUIREMENTS: &str = concat!(
        include_str!("../clients/requirements.txt"),
        include_str!("../clients/requirements-no-deps.txt"),
        include_str!("../clients/constraints.txt"),
    );
    let failed = |error: std::io::Error| error.to_string();
    // The test program is in the folder `deps` of its profile.
    let test = std::env::current_exe().map_err(failed)?;
    let target = test.ancestors().nth(3).ok_or("no target directory")?;
    let folder = target.join("clients-venv");
    let scripts = if cfg!(windows) { "Scripts" } else { "bin" };
    let python = folder.join(scripts).join("python");
    // Tests of another process wait until the installation is complete.
    let lock = File::create(target.join("clients-venv.lock")).map_err(failed)?;
    lock.lock().map_err(failed)?;
    let installed = folder.join("requirements.txt");
    if fs::read_to_string(&installed).is_ok_and(|text| text == REQUIREMENTS)
        && has(&python, &["sys"])
    {
        return Ok(python);
    }
    let _ = writeln!(
        stderr(),
        "installing the Python clients into {}",
        folder.display()
    );
    command(
        Command::new("python3")
            .args(["-m", "venv", "--clear"])
            .arg(&folder),
    )?;
    let constraints = clients().join("constraints.txt");
    let constraints = constraints.to_str().ok_or("a path that is not Unicode")?;
    install(&python, "requirements.txt", &["--constraint", constraints])?;
    let options = ["--no-deps", "--ignore-requires-python"];
    install(&python, "requirements-no-deps.txt", &options)?;
    fs::write(installed, REQUIREMENTS).map_err(failed)?;
    Ok(python)
}

/// Installs the packages of this file of `clients`.
fn install(python: &Path, file: &str, options: &[&str]) -> Result<(), String> {
    let mut pip = Command::new(python);
    pip.args([
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        // Python compiles what a test imports.
        "--no-compile",
    ]);
    pip.args(options);
    pip.args(["--retries", "10", "--timeout", "60", "--requirement"]);
    command(pip.arg(clients().join(file)))
}

/// The folder of the clients.
fn clients() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("clients")
}

/// Runs a command; returns the last line of its standard error if it fails.
fn command(command: &mut Command) -> Result<(), String> {
    let program = command.get_program().to_string_lossy().into_owned();
    let output = command.stdin(Stdio::null()).output();
    let output = output.map_err(|error| format!("{program}: {error}"))?;
    if output.status.success() {
        return Ok(());
    }
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    let reason = text.lines().rfind(|line| !line.trim().is_empty());
    Err(format!("{program}: {}", reason.unwrap_or("failed")))
}
