//! The tool in one process: its commands on a simulated bus, its server, its page; and the program itself.
//!
//! - [`bus`]: the commands against every product, in virtual time
//! - [`serve`]: the server of the page, without a browser
//! - [`page_modules`]: the modules of the page, in node
//! - [`browser`]: what only a browser can show
//! - [`process`]: the program as a process

mod browser;
mod bus;
mod key;
mod page_modules;
mod process;
mod serve;

// The test `images` has these helpers at the same path.
use bus::rig;
