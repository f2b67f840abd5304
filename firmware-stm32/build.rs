//! Hands the linker its scripts. A build script works wherever cargo is started and whatever RUSTFLAGS says, where linker
//! arguments in a configuration file would be lost, and a changed memory layout links anew.

use std::env::{var, var_os};

fn main() {
    println!("cargo:rerun-if-changed=../memory.x");
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(board)");
    if var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let bluepill = feature("BLUEPILL");
    let nucleo = feature("NUCLEO_F446RE");
    if bluepill != nucleo {
        println!("cargo:rustc-cfg=board");
    }
    // Before link.x, which includes memory.x.
    if nucleo {
        link("--defsym=NUCLEO_F446RE=1");
    }
    // Do not align the segments to pages of 64 KiB: there are none.
    link("--nmagic");
    link("-Tlink.x");
    if feature("DEFMT") {
        link("-Tdefmt.x");
    }
}

fn feature(name: &str) -> bool {
    var_os(format!("CARGO_FEATURE_{name}")).is_some()
}

fn link(argument: &str) {
    println!("cargo:rustc-link-arg-bins={argument}");
}
