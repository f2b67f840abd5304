//! The parameters of a product. All other data about a parameter is derived from one description.
//!
//! A [`Parameter`] describes a parameter: name, type, unit, permitted values, factory value and persistence. A [`Table`] is the
//! list of the parameters of a product. The [`ParameterRow`]s that the device uses are derived from it at compile time. On a PC
//! it is the source of data sheets, documents and limits for tools. The protocols only map their addresses (function select code,
//! index and sub-index) to a [`ParameterId`].
//!
//! [`Parameters`] are the values, with checks, factory values and the stored image. A [`Coding`] contains the names and values of
//! the numbers of a parameter. A [`Quantity`] describes a published value of the application.
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
//!         ..Parameter::plain()
//!     }];
//!     plumbline::project!(parameters);
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
pub mod ids;
#[doc(hidden)]
pub mod join;
pub mod projection;
mod real;
mod row;
mod set;
mod setting;
mod values;
mod wide;

pub use crate::mistake::Origin;
pub use coding::{Coding, decode, meaning};
pub use description::{
    Constraint, DataType, Meaning, Parameter, ParameterId, Permitted, Persistence, Quantity,
    Ranges, Relation, ValueId,
};
pub use real::{is_nan, is_nan_64, real32};
pub use row::{Limits, ParameterRow, Refused};
pub use set::ParameterSet;
pub use setting::Setting;
pub use values::{Numbers, Parameters, Table, number};
pub use wide::WideLimits;
