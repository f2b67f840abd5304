//! The recorded traces: in `host-tests/traces`, and beside a product in its folder in `core/src/model`.

use super::{Failure, Trace};
use bench::NodeType;
use bench::motion::Motion;
use bench::scene::{Axes, Scene, SceneArgument};
use std::path::{Path, PathBuf};

/// The files of the recorded traces of all products, sorted.
///
/// # Panics
/// If a folder of traces cannot be read.
pub fn all() -> Vec<PathBuf> {
    let host_tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders = vec![host_tests.join("traces")];
    let mut traces = Vec::new();
    let models = host_tests.join("../core/src/model").read_dir();
    let models = models.expect("the folder of the products");
    folders.extend(models.map(|entry| entry.expect("an entry of the folder").path()));
    for folder in folders.into_iter().filter(|path| path.is_dir()) {
        let entries = folder.read_dir().expect("a folder of traces");
        let paths = entries.map(|entry| entry.expect("an entry of the folder").path());
        let is_trace = |path: &PathBuf| path.extension().is_some_and(|end| end == "log");
        traces.extend(paths.filter(is_trace));
    }
    traces.sort();
    traces
}

/// The files of the traces of a product.
///
/// # Panics
/// If a folder of traces cannot be read.
pub fn of(product: &str) -> Vec<PathBuf> {
    let start = format!("{product}-");
    let named = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default();
        name.to_string_lossy().starts_with(&start)
    };
    all().into_iter().filter(named).collect()
}

/// The scene of a trace: a text as for `--scene`.
///
/// # Errors
/// The text is not a scene.
pub fn scene(node_type: &NodeType, text: &str) -> Result<Box<dyn Motion>, String> {
    let argument: SceneArgument = text.parse().map_err(|error| format!("{error}"))?;
    let scene =
        Scene::open(Some(&argument), Axes::of(node_type)).map_err(|error| error.to_string())?;
    Ok(Box::new(scene))
}

/// Replays all traces of a product.
///
/// # Panics
/// With the differences of all, or if a file is no trace of this product.
pub fn check(product: &str, replay: impl Fn(Trace) -> Result<(), Failure>) {
    let mut failures = Vec::new();
    for path in of(product) {
        let text = std::fs::read_to_string(&path).expect("a trace");
        let name = path.display();
        let trace: Trace = text
            .parse()
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(trace.model, product, "{name}");
        if let Err(failure) = replay(trace) {
            failures.push(format!("{name}:\n{failure}"));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
