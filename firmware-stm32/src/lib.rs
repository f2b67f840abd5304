//! Plumbline on hardware: an STM32 with bxCAN and an accelerometer on SPI, an ISM330DHCX or an ADXL355.
//!
//! The path of a frame: receive interrupt -> communicating half of the node -> mailbox (`link`). The path of a sample: every 5 ms
//! from the accelerometer into the measuring half, in the main loop (`app`). `can`, `imu`, `flash` and `clock` are the drivers. `board`
//! contains the pins. A file in `src/bin` selects the product.
//!
//! The board is selected by a feature (`bluepill`, `nucleo-f103rb`, `nucleo-f446re`), the feature `adxl355` selects another accelerometer,
//! and the feature `defmt` adds the log. On a PC, only the modules without hardware access are compiled, for their tests:
//! [`bit_timing`], [`silicon`], and of [`imu`] what has no driver.
#![cfg_attr(target_os = "none", no_std)]

#[cfg(all(target_os = "none", not(board)))]
compile_error!(
    "select one board: the default is the feature `bluepill`; the features of other boards go with --no-default-features"
);

#[cfg(all(target_os = "none", target_abi = "eabihf", feature = "stm32f103"))]
compile_error!("the STM32F103 has no FPU: build it with --target thumbv7m-none-eabi");

#[cfg(all(target_os = "none", feature = "signature", feature = "nucleo-f103rb"))]
compile_error!("the bootloader of the Nucleo-F103RB has no room for signatures");

/// For the macros of this crate.
#[doc(hidden)]
#[cfg(target_os = "none")]
pub use cortex_m_rt;

#[doc(hidden)]
pub use plumbline::node::ProductNode;
#[doc(hidden)]
pub use plumbline::update;

use plumbline::model::catalog::PRODUCTS;
use plumbline::store::ImageId;

#[cfg(board)]
#[macro_use]
mod log;

pub mod bit_timing;
pub mod imu;
pub mod silicon;

// The build script sets `board` if the target has no operating system and one board is selected.
#[cfg(board)]
pub mod app;
#[cfg(board)]
pub mod board;
#[cfg(board)]
pub mod bootloader;
#[cfg(board)]
pub mod can;
#[cfg(board)]
pub mod clock;
#[cfg(board)]
pub mod flash;
#[cfg(board)]
mod guard;
#[cfg(board)]
mod kept;
#[cfg(board)]
pub mod link;
#[cfg(board)]
mod mailbox;
#[cfg(board)]
mod mem;
#[cfg(all(board, feature = "behind-bootloader"))]
mod program;
#[cfg(board)]
mod reset;
#[cfg(board)]
mod sleep;

/// Whether the program with this name is that of the product with this image id, or of none.
pub const fn is_program_of(name: &str, image: ImageId) -> bool {
    let mut number = 0;
    while number < PRODUCTS.len() {
        let product = &PRODUCTS[number];
        let same_name = equal(product.name.as_bytes(), name.as_bytes());
        if same_name != (product.image.number() == image.number()) {
            return false;
        }
        number += 1;
    }
    true
}

const fn equal(one: &[u8], other: &[u8]) -> bool {
    let mut place = 0;
    while place < one.len() && place < other.len() && one[place] == other[place] {
        place += 1;
    }
    place == one.len() && place == other.len()
}

/// The interrupt of the bit rate detection, for products that have it.
#[macro_export]
macro_rules! pulse_interrupt {
    () => {
        #[cfg(target_os = "none")]
        mod pulse {
            use $crate::board::Interrupt as interrupt;
            use $crate::cortex_m_rt::interrupt;

            #[interrupt]
            fn TIM4() {
                $crate::can::on_pulse();
            }
        }
    };
}

/// The main function of a product. On a board it runs the node. On a PC it prints that it is firmware for a board. An article
/// contains name and image id; for a product without articles, they are arguments.
#[macro_export]
macro_rules! firmware {
    ($node:ty, $article:expr) => {
        $crate::pulse_interrupt!();
        $crate::firmware!($node, $article, $article.name, $article.image);
    };
    ($node:ty, $name:expr, $image:expr) => {
        const _: () = assert!(
            !<$node as $crate::ProductNode>::DETECTS,
            "a product that detects the bit rate needs `pulse_interrupt!`"
        );
        $crate::firmware!($node, &(), $name, $image);
    };
    ($node:ty, $article:expr, $name:expr, $image:expr) => {
        const _: () = assert!(
            $crate::is_program_of(env!("CARGO_BIN_NAME"), $image),
            "the program has the name of its product"
        );

        #[cfg(target_os = "none")]
        const _: () = assert!(
            <$node as $crate::ProductNode>::FILTERS <= $crate::board::FILTER_BANKS as usize,
            "the controller must have a bank for each filter"
        );

        /// The driver of the measuring element.
        #[cfg(target_os = "none")]
        type Element = $crate::imu::Fitted<
            { <$node as $crate::ProductNode>::HAS_SELF_TEST as usize },
            { <$node as $crate::ProductNode>::HAS_GYROSCOPE as usize },
        >;

        #[cfg(target_os = "none")]
        const _: () = {
            use $crate::imu::Element as Part;
            assert!(
                Element::GYROSCOPE || !<$node as $crate::ProductNode>::HAS_GYROSCOPE,
                "this product needs a gyroscope, which the measuring element of this build (ADXL355) does not have: build it without the feature `adxl355`"
            );
            assert!(
                Element::SELF_TEST || !<$node as $crate::ProductNode>::HAS_SELF_TEST,
                "this product needs a self-test, and the measuring element of this build has none"
            );
        };

        /// The number of the product, the measuring element, and the version. It is in the ELF file only, for the program that makes an
        /// image file of it.
        #[cfg(target_os = "none")]
        #[used]
        #[unsafe(link_section = ".plumbline.program")]
        static PROGRAM: $crate::update::About = $crate::update::About::new(
            $image,
            $crate::imu::NAME,
            [
                env!("CARGO_PKG_VERSION_MAJOR"),
                env!("CARGO_PKG_VERSION_MINOR"),
                env!("CARGO_PKG_VERSION_PATCH"),
            ],
        );

        #[cfg(target_os = "none")]
        static LINK: $crate::link::Shared<$node> = $crate::link::Shared::empty();

        /// The receive interrupt of the CAN controller. The vector table of the board contains it.
        #[cfg(target_os = "none")]
        #[unsafe(no_mangle)]
        extern "C" fn CAN_RECEIVE() {
            // SAFETY: this is the receive interrupt.
            unsafe { LINK.on_received() };
        }

        /// The transmit interrupt of the CAN controller.
        #[cfg(target_os = "none")]
        #[unsafe(no_mangle)]
        extern "C" fn CAN_TRANSMIT() {
            // SAFETY: this is the transmit interrupt.
            unsafe { LINK.on_transmitted() };
        }

        /// cortex-m-rt calls it before it initialises the RAM.
        // SAFETY: a jump, which changes no register.
        #[cfg(target_os = "none")]
        #[unsafe(no_mangle)]
        #[unsafe(naked)]
        unsafe extern "C" fn __pre_init() {
            core::arch::naked_asm!("b {check}", check = sym $crate::board::check_memories::<$node>)
        }

        /// The interrupt of the clock.
        #[cfg(target_os = "none")]
        #[unsafe(no_mangle)]
        extern "C" fn SysTick() {
            $crate::clock::on_tick();
        }

        /// Without the script `link.x`, the entry point is `_start`, and the linker reports that this function does not exist. With the
        /// script, the program does not contain `_start`.
        #[cfg(target_os = "none")]
        #[unsafe(no_mangle)]
        extern "C" fn _start() {
            unsafe extern "C" {
                safe fn linker_script_link_x_is_missing__use_the_build_script_of_the_template();
            }
            linker_script_link_x_is_missing__use_the_build_script_of_the_template();
        }

        #[cfg(target_os = "none")]
        #[$crate::cortex_m_rt::entry]
        fn main() -> ! {
            // In static memory, so that its size is part of the image and not of the stack. `entry` makes it safe to borrow.
            static mut NODE: $node = <$node>::INITIAL;
            static mut STORE: core::mem::MaybeUninit<$crate::app::ParameterStore<$node>> =
                core::mem::MaybeUninit::uninit();
            static mut ELEMENT: core::mem::MaybeUninit<Element> = core::mem::MaybeUninit::uninit();
            // SAFETY: `entry` permits no other call of this function.
            unsafe { $crate::app::run($article, STORE, ELEMENT, NODE, &LINK) }
        }

        #[cfg(not(target_os = "none"))]
        fn main() {
            println!(
                "{} is firmware for a board ({} filters, {:?}): see the README",
                $name,
                <$node as $crate::ProductNode>::FILTERS,
                <$node as $crate::ProductNode>::owner($article, 0),
            );
        }
    };
}
