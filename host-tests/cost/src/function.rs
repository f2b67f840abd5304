//! The measured functions, by the end of their demangled names in the symbol table.

/// The functions of a node. None is inlined: core marks them `inline(never)`.
#[derive(Clone, Copy, Debug)]
pub struct NodeFunctions {
    /// `Communication::receive`.
    pub receive: &'static str,
    /// `Communication::is_idle`.
    pub is_idle: &'static str,
    /// `Communication::tick`.
    pub tick: &'static str,
    /// `Communication::action`.
    pub action: &'static str,
    /// `Communication::transmit`.
    pub transmit: &'static str,
    /// `Acquisition::sample`.
    pub sample: &'static str,
    /// `Communication::stored`.
    pub stored: &'static str,
}

/// The functions of the node of any product.
pub const NODE: NodeFunctions = NodeFunctions {
    receive: "plumbline::node::communication::Communication<A,P>::receive",
    is_idle: "plumbline::node::communication::Communication<A,P>::is_idle",
    tick: "plumbline::node::communication::Communication<A,P>::tick",
    action: "plumbline::node::communication::Communication<A,P>::action",
    transmit: "plumbline::node::communication::Communication<A,P>::transmit",
    sample: "plumbline::node::acquisition::Acquisition<A>::sample",
    stored: "plumbline::node::communication::Communication<A,P>::stored",
};

/// The end of a change of parameters: the values are published, as those of a reading.
pub const FINISH: &str = "plumbline::node::communication::Communication<A,P>::finish";

/// The calibration of a reading.
pub const CALIBRATION: &str = "plumbline::measure::calibration::Calibration::apply";
/// One step of the low-pass.
pub const STEP: &str = "plumbline::measure::low_pass::LowPass::step";
/// A change of the filter or cut-off frequency.
pub const TUNE: &str = "plumbline::measure::low_pass::LowPass::tune";
/// One step of the FIR low-pass.
pub const FIR_STEP: &str = "plumbline::measure::fir::Fir::step";
/// One step of the Kalman filter.
pub const FUSION_STEP: &str = "plumbline::measure::fusion::Fusion<_>::step";
/// The start of a save.
pub const STORE_SAVE: &str = "plumbline::store::slots::Store<M,_>::save";
/// One step of a save.
pub const STORE_STEP: &str = "plumbline::store::slots::Store<M,_>::step";
/// Both angles of two axes.
pub const PERPENDICULAR: &str = "plumbline::measure::definition::perpendicular";
/// One of these angles.
pub const TILT: &str = "plumbline::measure::definition::tilt";
/// The angle of one axis.
pub const ATAN2: &str = "plumbline::angle::Angle::atan2";

/// The functions that calculate the angles of a model: the key of a row and a symbol for each.
#[derive(Clone, Copy, Debug)]
pub struct Angles(pub &'static [(&'static str, &'static str)]);

impl Angles {
    /// The angle of one axis over a full turn.
    pub const ONE_AXIS: Self = Self(&[("atan2", ATAN2)]);
    /// Two perpendicular angles.
    pub const TWO_AXES: Self = Self(&[("perpendicular", PERPENDICULAR), ("tilt", TILT)]);
}
