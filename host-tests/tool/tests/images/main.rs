//! The tool with the images that are flashed, on the simulated microcontroller.
//!
//! - [`commands`]: the commands against the image of each family
//! - [`image_file`]: image files of updates
//! - [`update`]: updates of images behind a bootloader; [`page`]: the same by the requests of the page

mod commands;
mod image_file;
mod page;
mod update;

// Helpers of the test `tool`, which uses all of them.
#[allow(dead_code)]
#[path = "../tool/serve/client.rs"]
mod client;
#[allow(dead_code)]
#[path = "../tool/serve/fast_bus.rs"]
mod fast_bus;
#[allow(dead_code)]
#[path = "../tool/serve/hooked.rs"]
mod hooked;
#[path = "../tool/serve/plugged.rs"]
mod plugged;
#[allow(dead_code)]
#[path = "../tool/bus/rig/mod.rs"]
mod rig;
#[allow(dead_code)]
#[path = "../tool/process/sensor.rs"]
mod sensor;
