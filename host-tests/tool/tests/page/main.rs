//! The page in a headless Chromium, driven by chromedriver. Without them the tests print `skipped`; in a continuous integration run
//! (`CI` is set) they fail.

mod browser;
mod bus;
mod colours;
mod controls;
mod devices;
mod files;
#[path = "../serve/foreign.rs"]
mod foreign;
mod keyboard;
mod load;
mod next_steps;
mod oscilloscope;
mod parts;
mod position;
mod products;
mod questions;
mod reading;
mod server;
mod states;
mod table;
mod which;
