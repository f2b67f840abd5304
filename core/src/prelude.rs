//! What the description of a product usually names: `use plumbline::prelude::*;`.

pub use crate::application::{Application, Faults, Published, Values};
pub use crate::can::{Frame, standard};
pub use crate::measure::{Calibration, I32x3, Inclinometer, Reading, definition};
pub use crate::node::{Boot, Node};
pub use crate::param::{
    Coding, DataType, Parameter, ParameterId, Parameters, Permitted, Persistence, Quantity, Table,
    ValueId,
};
pub use crate::store::ImageId;
pub use crate::time::Instant;
