//! Passes the scripts to the linker. A build script works in every working directory and with every RUSTFLAGS; linker arguments in a
//! configuration file do not. After a change of the memory layout, cargo links again.
//!
//! Cargo gives linker arguments to the programs of this package only. The build script of a program in another package gets them in
//! `DEP_FIRMWARE_STM32_ARGUMENTS`: see `host-tests/template/build.rs`.

use std::env::{var, var_os, vars};
use std::fs::{copy, write};
use std::path::{Path, PathBuf};

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(board)");
    if var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let boards: Vec<String> = vars().filter_map(|(name, _)| board(&name)).collect();
    let [board] = &boards[..] else {
        // The library reports the error.
        return;
    };
    println!("cargo:rustc-cfg=board");
    println!("cargo:rerun-if-env-changed=CARGO_ENCODED_RUSTFLAGS");
    let is_f103 = feature("STM32F103");
    if is_f103 {
        require_processor();
    }
    // The linker searches here for the scripts that link.x includes, also for a program of another package.
    let folder = PathBuf::from(var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    println!("cargo:rustc-link-search={}", folder.display());
    // In the published package, the file is beside this one.
    let common = ["memory.x", "../memory.x"].map(PathBuf::from);
    let common = common.into_iter().find(|path| path.exists());
    let common = common.expect("the package contains memory.x");
    for (script, name) in [(common, "memory.x"), (regions(board), "regions.x")] {
        println!("cargo:rerun-if-changed={}", script.display());
        copy(script, folder.join(name)).expect("the folder can be written");
    }
    write(folder.join("board.x"), name_section(board)).expect("the folder can be written");
    // The boards with an STM32F103 have a vector table of their own. cortex-m-rt expects the names of its handlers in this file: this one
    // is only in products that detect the bit rate.
    if is_f103 {
        let handlers = "PROVIDE(TIM4 = DefaultHandler);\n";
        write(folder.join("device.x"), handlers).expect("the folder can be written");
    }
    // Otherwise the linker aligns segments to pages of 64 KiB.
    let mut arguments = vec!["--nmagic", "-Tlink.x", "-Tboard.x"];
    if feature("DEFMT") {
        arguments.push("-Tdefmt.x");
    }
    if feature("BEHIND_BOOTLOADER") {
        arguments.push("--defsym=BEHIND_BOOTLOADER=1");
    }
    for argument in &arguments {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    println!("cargo:arguments={}", arguments.join(" "));
    // The program contains the code of several products, and is not flashed.
    println!("cargo:rustc-link-arg-bin=panic-free=--defsym=PANIC_FREE=1");
    println!("cargo:rustc-link-arg-bin=bootloader=--defsym=BOOTLOADER=1");
}

/// The linker script of sections that are not loaded: the name of the board, the product with its version, which the program
/// contains, and that of a bootloader that checks signatures. Programs on a PC read them.
fn name_section(board: &str) -> String {
    let name = board.replace('_', "-");
    let bytes: String = name.bytes().map(|byte| format!(" BYTE({byte})")).collect();
    format!(
        "SECTIONS {{\n  .plumbline.board 0 (INFO) : {{{bytes} }}\n  .plumbline.program 0 (INFO) : {{ KEEP(*(.plumbline.program)) }}\n  .plumbline.signature 0 (INFO) : {{ KEEP(*(.plumbline.signature)) }}\n}}\n"
    )
}

/// The memory regions of a board, which `memory.x` includes.
fn regions(board: &str) -> PathBuf {
    Path::new("src/board").join(board).join("regions.x")
}

/// The board that this variable of cargo selects: its feature has the name of its folder, which contains its memory regions.
fn board(variable: &str) -> Option<String> {
    let board = variable.strip_prefix("CARGO_FEATURE_")?.to_lowercase();
    regions(&board).exists().then_some(board)
}

/// Fails without the compiler flag of `.cargo/config.toml`: RUSTFLAGS replaces the flags there, and cargo finds that file only from inside
/// of the project.
fn require_processor() {
    let flags = var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default();
    assert!(
        flags.contains("target-cpu=cortex-m3"),
        "the STM32F103 needs the flag -Ctarget-cpu=cortex-m3 (Arm erratum 602117). .cargo/config.toml has it, but RUSTFLAGS replaces it: \
         add it there, and start cargo inside of the project"
    );
}

fn feature(name: &str) -> bool {
    var_os(format!("CARGO_FEATURE_{name}")).is_some()
}
