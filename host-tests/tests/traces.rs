//! Replays every trace in host-tests/traces against a sensor of the product that it names.
#![cfg(target_os = "linux")]

use bench::NodeType;
use bench::motion::Motion;
use bench::scene::{Axes, Scene, SceneArgument};
use host_tests::trace::Trace;
use plumbline::model::catalog::PRODUCTS;
use std::path::{Path, PathBuf};

/// The paths of all traces.
fn traces() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("traces");
    let entries = folder.read_dir().expect("the folder of the traces");
    let paths = entries.map(|entry| entry.expect("an entry of the folder").path());
    let is_trace = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "log");
    let mut traces: Vec<_> = paths.filter(is_trace).collect();
    traces.sort();
    traces
}

fn scene(node_type: &NodeType, text: &str) -> Result<Box<dyn Motion>, String> {
    let argument: SceneArgument = text.parse().map_err(|error| format!("{error}"))?;
    let scene =
        Scene::open(Some(&argument), Axes::of(node_type)).map_err(|error| error.to_string())?;
    Ok(Box::new(scene))
}

fn replay(path: &Path) -> Result<(), String> {
    let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
    let trace: Trace = text.parse().map_err(|error| format!("{error}"))?;
    let node_type = NodeType::find(&trace.model).ok_or("there is no such model")?;
    trace
        .replay(&node_type, &scene)
        .map_err(|failure| failure.to_string())
}

#[test]
fn sensor_passes_every_trace() {
    let traces = traces();
    assert!(traces.len() >= 8, "{traces:?}");
    let failures: Vec<String> = traces
        .iter()
        .filter_map(|path| Some(format!("{}:\n{}", path.display(), replay(path).err()?)))
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn every_product_has_a_trace() {
    for product in PRODUCTS {
        let named = format!("{}-", product.name);
        let of = |path: &PathBuf| {
            path.file_name()
                .is_some_and(|name| name.to_string_lossy().starts_with(&named))
        };
        assert!(traces().iter().any(of), "{}", product.name);
    }
}
