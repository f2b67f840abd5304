//! Hands the linker its scripts. A build script works wherever cargo is started and whatever RUSTFLAGS says, where linker
//! arguments in a configuration file would be lost, and a changed memory layout links anew.

use std::env::{var, var_os};
use std::fs::write;
use std::path::Path;

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
    println!("cargo:rerun-if-env-changed=CARGO_ENCODED_RUSTFLAGS");
    if bluepill {
        require_processor();
    }
    // Before link.x, which includes memory.x.
    if nucleo {
        link("--defsym=NUCLEO_F446RE=1");
    }
    // The proof has the code of several products, and is not flashed.
    println!("cargo:rustc-link-arg-bin=panic-free=--defsym=PANIC_FREE=1");
    // The Blue Pill has a vector table of its own. cortex-m-rt expects the names of its handlers in this file: this one is only in
    // products that detect the bit rate.
    if bluepill && let Some(folder) = var_os("OUT_DIR") {
        let folder = Path::new(&folder);
        let handlers = "PROVIDE(TIM4 = DefaultHandler);\n";
        write(folder.join("device.x"), handlers).expect("the folder can be written");
        println!("cargo:rustc-link-search={}", folder.display());
    }
    // Do not align the segments to pages of 64 KiB: there are none.
    link("--nmagic");
    link("-Tlink.x");
    if feature("DEFMT") {
        link("-Tdefmt.x");
    }
}

/// Fails without the compiler flag of `.cargo/config.toml`: RUSTFLAGS replaces the flags there, and cargo finds that file only from inside
/// of the project.
fn require_processor() {
    let flags = var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default();
    assert!(
        flags.contains("target-cpu=cortex-m3"),
        "the Blue Pill needs the flag -Ctarget-cpu=cortex-m3 (Arm erratum 602117). .cargo/config.toml has it, but RUSTFLAGS replaces it: \
         add it there, and start cargo inside of the project"
    );
}

fn feature(name: &str) -> bool {
    var_os(format!("CARGO_FEATURE_{name}")).is_some()
}

fn link(argument: &str) {
    println!("cargo:rustc-link-arg-bins={argument}");
}
