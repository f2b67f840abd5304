//! The models by name.

use plumbline::node::Node;
use plumbline::store::{ImageId, Loaded};
use plumbline::time::Instant;

/// What the bench needs to know of a model to bring it to life.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    /// The name on the command line and in traces: `is2`.
    pub name: &'static str,
    /// The identification of its images in nonvolatile memory.
    pub image: ImageId,
    /// The size of an image's payload in bytes.
    pub payload: usize,
    /// Starts a node as after power-up: the time, what nonvolatile memory holds, the serial number.
    pub boot: fn(now: Instant, loaded: Loaded, serial: u32) -> Box<dyn Node>,
}

/// Every model.
pub const MODELS: &[Model] = &[];

/// The model of this name.
pub fn find(name: &str) -> Option<&'static Model> {
    MODELS.iter().find(|model| model.name == name)
}
