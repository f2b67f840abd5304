//! A proof that the core cannot panic with any input. A possible panic is a link error. This is not a firmware image.
//!
//! The program calls all methods of all nodes and of the store with values that are opaque to the compiler. (The older types are
//! the same code with other constants.) Its panic handler calls a function that does not exist. The program links only if the
//! optimizer has removed all panic paths of the core:
//!
//! ```text
//! cargo build --release -p firmware-stm32 --target thumbv7m-none-eabi --bin panic-free
//! ```
//!
//! If it does not link ("undefined symbol: panic_path_in_core"), define the symbol. The callers of the panic functions are in the
//! disassembly:
//!
//! ```text
//! cargo rustc --release -p firmware-stm32 --target thumbv7m-none-eabi --bin panic-free -- -C link-arg=--defsym=panic_path_in_core=0
//! llvm-objdump -d --demangle target/thumbv7m-none-eabi/release/panic-free
//! ```
//!
//! Only a release build without defmt is a proof: debug assertions add overflow checks, and defmt has its own panic paths.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod proof;

/// A build for a PC proves nothing, because it is not the code of a board.
#[cfg(not(target_os = "none"))]
fn main() {}
