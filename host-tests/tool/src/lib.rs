//! `plumbline`: finds, sets, shows and records CAN inclination sensors: the sensors of this project and the original sensors of the makers.
//!
//! From the bus to the user:
//!
//! - [`demo`]: the adapter with a virtual sensor; the others are in the crate `adapter`
//! - [`link`]: an adapter with a count of its frames; one request, one answer
//! - [`master`]: the master of each protocol, one folder for each
//! - [`sheet`], [`number`], [`resolve`]: the names and values of a product, made from the tables of the core; [`meaning`]: in German
//! - [`eds`]: the same from the data sheet of a device that is not in the catalogue
//! - [`identify`], [`connect`], [`session`]: which product answers, and a session with it
//! - [`backup`], [`plan`]: the file with the settings, and the order in which they are written
//! - [`sample`], [`cyclic`]: samples of the angles, polled or sent by the sensor
//! - [`decode`]: what the frames of a log mean
//! - [`calibrate`]: the log of a board, and when a sensor is at rest
//! - [`labels`]: the names that the user gives to sensors
//! - [`scan`]: finds sensors with unknown bit rate, protocol and address
//! - [`serve`]: the page in the browser
//! - [`ops`]: the operations on a sensor, for the command line and the page
//! - [`command`]: the commands; [`cli`]: the command line; [`output`], [`bar`], [`question`]: the terminal
//! - [`error`]: exit codes and messages; [`note`]: what else the user must know; [`counted`]: numbers of things in them
//!
//! Nothing about a parameter is known here. Names, types, units, ranges and factory values come from the catalogue of the core.

pub mod backup;
pub mod bar;
pub mod calibrate;
pub mod cli;
pub mod command;
pub mod connect;
pub mod counted;
pub mod cyclic;
pub mod decode;
pub mod demo;
pub mod eds;
pub mod error;
pub mod identify;
pub mod image;
pub mod known;
pub mod labels;
pub mod last;
pub mod link;
pub mod master;
pub mod meaning;
pub mod note;
pub mod number;
pub mod ops;
pub mod output;
pub mod plan;
pub mod port;
pub mod question;
pub mod resolve;
pub mod sample;
pub mod scan;
pub mod serve;
pub mod session;
pub mod sheet;
pub mod signing;
