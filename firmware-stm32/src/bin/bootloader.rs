//! The bootloader of a board: it starts the program in the flash, or takes another one over CAN.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod board {
    /// The interrupts in the vector table of the library. The bootloader enables none of them.
    #[unsafe(no_mangle)]
    extern "C" fn CAN_RECEIVE() {}
    #[unsafe(no_mangle)]
    extern "C" fn CAN_TRANSMIT() {}

    /// The ELF file says that this bootloader checks signatures.
    #[cfg(feature = "signature")]
    #[used]
    #[unsafe(link_section = ".plumbline.signature")]
    static SIGNATURE: u8 = 1;

    #[firmware_stm32::cortex_m_rt::entry]
    fn main() -> ! {
        // SAFETY: `entry` permits no other call.
        unsafe { firmware_stm32::bootloader::run() }
    }
}

/// A PC has no bootloader.
#[cfg(not(target_os = "none"))]
fn main() {
    println!("bootloader is a program for a board: see the README");
}
