//! Passes the scripts to the linker. A build script works in every working directory and with every RUSTFLAGS; linker arguments in a
//! configuration file do not. After a change of the memory layout, cargo links again.
//!
//! Cargo gives linker arguments to the programs of this package only. The build script of a program in another package gets them in
//! `DEP_FIRMWARE_STM32_ARGUMENTS`: see `host-tests/template/build.rs`.

use std::env::{var, var_os};
use std::fs::{copy, write};
use std::path::{Path, PathBuf};

fn main() {
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
    // The linker searches here for the scripts that link.x includes, also for a program of another package.
    let folder = PathBuf::from(var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    println!("cargo:rustc-link-search={}", folder.display());
    // In the published package, the memory is beside this file.
    let memory = ["memory.x", "../memory.x"].map(Path::new);
    let memory = memory.iter().find(|path| path.exists());
    let memory = memory.expect("the package contains memory.x");
    println!("cargo:rerun-if-changed={}", memory.display());
    copy(memory, folder.join("memory.x")).expect("the folder can be written");
    // The Blue Pill has a vector table of its own. cortex-m-rt expects the names of its handlers in this file: this one is only in
    // products that detect the bit rate.
    if bluepill {
        let handlers = "PROVIDE(TIM4 = DefaultHandler);\n";
        write(folder.join("device.x"), handlers).expect("the folder can be written");
    }
    // Otherwise the linker aligns segments to pages of 64 KiB.
    let mut arguments = vec!["--nmagic"];
    // Before link.x, which includes memory.x.
    if nucleo {
        arguments.push("--defsym=NUCLEO_F446RE=1");
    }
    arguments.push("-Tlink.x");
    if feature("DEFMT") {
        arguments.push("-Tdefmt.x");
    }
    for argument in &arguments {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    println!("cargo:arguments={}", arguments.join(" "));
    // The program contains the code of several products, and is not flashed.
    println!("cargo:rustc-link-arg-bin=panic-free=--defsym=PANIC_FREE=1");
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
