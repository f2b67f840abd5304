//! CANopen (CiA 301): the part that all sensors with this protocol have in common.
//!
//! A master reads and writes the objects of the object dictionary with SDOs and controls the NMT state of the sensor. The sensor
//! sends the inclination in PDOs, triggered by its event timer or by the SYNC. Section numbers refer to CiA 301, version 4.2.
//!
//! - [`mod@cob_id`]: the identifiers.
//! - [`dictionary`]: how a product describes its objects, and the compact form in the device; [`profile`]: the objects of CiA
//!   301.
//! - [`nmt`]: states and commands; [`sdo`]: the server; [`pdo`]: transmit PDOs; [`emcy`]: errors; guarding and the heartbeat;
//!   [`mod@lss`]: layer setting services.
//! - [`feature`]: services that only some products have; [`own`]: own objects of a product, and its rules for stored parameters.
//! - [`Product`]: the description of a product.
//! - [`Canopen`]: the protocol, which consists of these services; [`CanopenNode`]: a node with this protocol.
//!
//! What a product needs for a function, besides the objects that each one has ([`profile::standard`]):
//!
//! | function | in [`Product`] | parameters | objects |
//! |---|---|---|---|
//! | TPDOs with a fixed mapping | [`TpdoArray`] | [`profile::tpdo_communication`] | [`profile::tpdo`], [`profile::mapping`] |
//! | TPDOs whose COB-ID and mapping a master changes | [`DynamicTpdos`] | [`profile::stored_tpdo_communication`], [`profile::mapping_parameters`] | [`profile::free_tpdo`], [`profile::dynamic_mapping`] |
//! | monitoring of the heartbeat of other nodes (1016h) | [`Heartbeats`] | [`profile::consumer_parameters`] | [`profile::consumers`] |
//! | LSS | `Present<Lss>`, [`LSS_TABLES`](Product::LSS_TABLES) for bit rates of the maker | [`profile::lss_node_id`] or [`profile::lss_node_id_to_127`] | [`profile::identity`] |
//! | SDO block transfer | `Present<Block>` | | |
//! | save and restore by groups | [`GROUPS`](Product::GROUPS) if the maker has several | | [`profile::store`], [`profile::restore`] |
//! | a command, or an object that is calculated | [`OWN`](Product::OWN) | | [`Object::own`] |
//! | a parameter that changes others, for example a preset | [`Application::write`](crate::application::Application::write) | the parameters | [`Object::parameter`] |
//! | objects between those of [`profile::standard`] | | | [`profile::merge`] |

mod abort;
#[doc(hidden)]
pub mod check;
pub mod cob_id;
mod cob_ids;
pub mod consumer;
mod diagnosis;
pub mod dictionary;
pub mod emcy;
pub mod feature;
mod group;
mod guarding;
mod hosted;
mod lookup;
pub mod lss;
mod mapping;
mod monitoring;
pub mod nmt;
mod objects;
pub mod own;
pub mod pdo;
mod process_data;
mod product;
pub mod profile;
mod program;
mod protocol;
mod ranges;
mod receive;
mod reset;
pub mod row;
mod saved;
mod saving;
pub mod sdo;
pub mod setting;
mod wide;

pub use crate::text::Text;
pub use abort::Abort;
pub use consumer::{Consumers, Heartbeats};
pub use dictionary::Object;
pub use feature::{Absent, Initial, Present};
pub use group::Group;
pub use lss::{Lss, LssRates, LssTable};
pub use own::{Own, Scope, Taken, Then};
pub use pdo::{DynamicTpdos, Tpdo, TpdoArray, Tpdos, Triggers};
pub use product::{ErrorHistory, LedTable, Product};
pub use protocol::{Canopen, CanopenNode};
pub use sdo::Block;
