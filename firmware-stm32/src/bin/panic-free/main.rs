//! A proof, not a firmware: core cannot panic, whatever it is given. A panic is a link error.
//!
//! The program calls every method of every node (the older types are the same code with other constants) and of the store with values that the compiler must not look into, and its panic
//! handler calls a function that does not exist. It links only if the optimizer has found every panic path of core impossible:
//!
//! ```text
//! cargo build --release -p firmware-stm32 --target thumbv7m-none-eabi --bin panic-free
//! ```
//!
//! When it does not ("undefined symbol: panic_path_in_core"), this makes it link all the same, and the callers of the panic
//! functions in its disassembly are the culprits:
//!
//! ```text
//! cargo rustc --release -p firmware-stm32 --target thumbv7m-none-eabi --bin panic-free -- -C link-arg=--defsym=panic_path_in_core=0
//! llvm-objdump -d --demangle target/thumbv7m-none-eabi/release/panic-free
//! ```
//!
//! Only a release build proves anything: debug assertions add checks for overflow, and defmt has panic paths of its own.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod proof;

/// On a PC there is nothing to prove: what links there is not what goes into a board.
#[cfg(not(target_os = "none"))]
fn main() {}
