//! The server of the page over TCP, without a browser.

mod adapter;
mod api;
mod calibrate;
mod client;
mod data_sheets;
mod files;
mod foreign;
mod guard;
mod j1939;
mod scan;
mod sentences;
mod stream;
mod which;
