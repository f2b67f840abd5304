//! Replays every recorded trace against the image, which sends the same bytes as the sensor built for the PC.
#![cfg(target_os = "linux")]

use crate::rig::*;
use bench::NodeType;
use bench::motion::Motion;
use bench::scene::{Axes, Scene, SceneArgument};
use host_tests::trace::Trace;
use plumbline::time::Duration;
use std::path::Path;
use stm32_sim::Microcontroller;

/// Maximum time after which the image takes part in the bus: it waits until the accelerometer has settled.
const BOOT: Duration = ms(200);

/// Maximum additional delay of the image: it handles a deadline at the next tick of its clock, and an event in the next run of
/// its main loop.
const TICK: Duration = ms(1);

fn scene(node_type: &NodeType, text: &str) -> Result<Box<dyn Motion>, String> {
    let argument: SceneArgument = text.parse().map_err(|error| format!("{error}"))?;
    let scene =
        Scene::open(Some(&argument), Axes::of(node_type)).map_err(|error| error.to_string())?;
    Ok(Box::new(scene))
}

/// Replays a trace if the image of its product is tested.
fn replay(path: &Path) -> Option<Result<(), String>> {
    let text = std::fs::read_to_string(path).expect("a trace");
    let mut trace: Trace = text.parse().expect("a trace");
    if !MODELS.contains(&trace.model.as_str()) {
        return None;
    }
    trace.loosen(TICK);
    let result = trace.replay_on(
        &node_type(&trace.model),
        &scene,
        BOOT,
        &|node_type, serial, motion| {
            let image = image(node_type.name);
            let flash = blank();
            Box::new(Microcontroller::new(
                node_type.name,
                image,
                serial,
                flash,
                motion,
            ))
        },
    );
    Some(result.map_err(|failure| format!("{}:\n{failure}", path.display())))
}

#[test]
fn image_passes_every_trace() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("traces");
    let mut paths: Vec<_> = folder
        .read_dir()
        .expect("the folder of the traces")
        .map(|entry| entry.expect("an entry of the folder").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "log"))
        .collect();
    paths.sort();
    let results: Vec<_> = paths.iter().filter_map(|path| replay(path)).collect();
    assert!(results.len() >= 10, "{paths:?}");
    let failures: Vec<String> = results.into_iter().filter_map(Result::err).collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
