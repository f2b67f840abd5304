//! Passes the arguments of the board from `firmware-stm32` to the linker. Without them, the program does not link.

fn main() {
    let arguments = std::env::var("DEP_FIRMWARE_STM32_ARGUMENTS").unwrap_or_default();
    for argument in arguments.split_whitespace() {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
}
