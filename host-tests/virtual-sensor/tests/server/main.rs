//! The program `virtual-sensor`: its command line, its files, its output, its end, and its clients on TCP and on the pseudoterminal.

mod both;
mod clock;
mod command_line;
mod control;
mod on;
mod output;
mod process;
mod several;
mod slcan_pty;
mod slcan_tcp;
mod store;

/// The options of what runs in the virtual sensor: the model built for the PC. In the test `images` it is an image.
fn firmware(_model: &str) -> Vec<&'static str> {
    Vec::new()
}
