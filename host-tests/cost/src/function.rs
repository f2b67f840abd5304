//! The functions that are measured, by the end of their readable names in the symbol table.

/// The functions of a node. None is inlined: core says so.
#[derive(Clone, Copy, Debug)]
pub struct NodeFunctions {
    /// `Node::receive`.
    pub receive: &'static str,
    /// `Node::poll`.
    pub poll: &'static str,
    /// `Node::transmit`.
    pub transmit: &'static str,
    /// `Node::sample`.
    pub sample: &'static str,
    /// `Node::stored`.
    pub stored: &'static str,
}

/// Those of a node of any product.
pub const NODE: NodeFunctions = NodeFunctions {
    receive: "plumbline::node::can_node::CanNode<A,P> as plumbline::node::Node>::receive",
    poll: "plumbline::node::can_node::CanNode<A,P> as plumbline::node::Node>::poll",
    transmit: "plumbline::node::can_node::CanNode<A,P> as plumbline::node::Node>::transmit",
    sample: "plumbline::node::can_node::CanNode<A,P> as plumbline::node::Node>::sample",
    stored: "plumbline::node::can_node::CanNode<A,P> as plumbline::node::Node>::stored",
};

/// The calibration of a reading.
pub const CALIBRATION: &str = "plumbline::measure::calibration::Calibration::apply";
/// One step of the low-pass.
pub const STEP: &str = "plumbline::measure::low_pass::LowPass::step";
/// Another filter or cut-off frequency.
pub const TUNE: &str = "plumbline::measure::low_pass::LowPass::tune";
/// One step of the low-pass with a finite impulse response.
pub const FIR_STEP: &str = "plumbline::measure::fir::Fir::step";
/// The beginning of a save.
pub const STORE_SAVE: &str = "plumbline::store::slots::Store<M,_>::save";
/// A piece of a save.
pub const STORE_STEP: &str = "plumbline::store::slots::Store<M,_>::step";
/// Both angles of two axes.
pub const PERPENDICULAR: &str = "plumbline::measure::definition::perpendicular";
/// One of them.
pub const TILT: &str = "plumbline::measure::definition::tilt";
/// The angle of one axis.
pub const ATAN2: &str = "plumbline::angle::Angle::atan2";

/// The functions that make a model's angles: each a row's key and a symbol.
#[derive(Clone, Copy, Debug)]
pub struct Angles(pub &'static [(&'static str, &'static str)]);

impl Angles {
    /// A full turn about one axis.
    pub const ONE_AXIS: Self = Self(&[("atan2", ATAN2)]);
    /// Two perpendicular angles.
    pub const TWO_AXES: Self = Self(&[("perpendicular", PERPENDICULAR), ("tilt", TILT)]);
}
