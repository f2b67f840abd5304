//! The parameters of a product: one description each, from which everything else follows.
//!
//! A [`Parameter`] says for people and tools what a parameter is: name, type, unit, permitted values, factory value and whether
//! it is stored. A [`Table`] is the list of a product's parameters. Out of it come, at compile time, the [`Rule`]s that the
//! device keeps; and on a PC the data sheets, the documents and the limits of other tools. The protocols only map their
//! addresses (function select code, index and sub-index) to a [`ParameterId`].
//!
//! [`Parameters`] are the values: checks, factory values, and their place in the stored image. A [`Coding`] ties the numbers of
//! a parameter to what they stand for. A [`Quantity`] describes a value that the application publishes in the same words.
//!
//! ```
//! use plumbline::param::{DataType, Parameter, ParameterId, Parameters, Permitted, Refused, Table};
//!
//! const CYCLE: ParameterId = ParameterId(0);
//!
//! struct Product;
//!
//! impl Table for Product {
//!     const PARAMETERS: &'static [Parameter] = &[Parameter {
//!         id: CYCLE,
//!         name: "Cycle time",
//!         data_type: DataType::U16,
//!         unit: "ms",
//!         permitted: Permitted::Range(1, 1000),
//!         factory: 250,
//!         ..Parameter::PLAIN
//!     }];
//!     plumbline::project_parameters!();
//! }
//!
//! let mut parameters = Parameters::<Product>::factory();
//! assert_eq!(Parameters::<Product>::check(CYCLE, 0), Err(Refused::TooLow));
//! assert_eq!(Parameters::<Product>::check(CYCLE, 20), Ok(()));
//! parameters.set(CYCLE, 20);
//! let mut image = [0; 2];
//! assert_eq!(parameters.encode(&mut image), Some(2));
//! assert_eq!(image, [20, 0]);
//! ```

mod coding;
mod description;
pub mod projection;
mod rule;
mod set;
mod values;

pub use coding::{Coding, decode, meaning};
pub use description::{
    Constraint, DataType, Meaning, Parameter, ParameterId, Permitted, Persistence, Quantity,
    Ranges, ValueId,
};
pub use rule::{Limits, Refused, Rule};
pub use set::ParameterSet;
pub use values::{Numbers, Parameters, Table, number};
