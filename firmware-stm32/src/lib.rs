//! Plumbline's nodes on real pins: an STM32 with bxCAN and an ISM330DHCX accelerometer on SPI.
//!
//! The path of a frame: receive interrupt -> queue -> [`Node`](plumbline::node::Node) -> mailbox. The path of a sample: every
//! 5 ms from the accelerometer into the node. `app` turns the crank; `can`, `imu`, `flash` and `clock` are what it
//! turns; `board` knows the pins; and a file in `src/bin` names the model.
//!
//! A board is a feature (`bluepill`, `nucleo-f446re`), and so is the log (`defmt`). On a PC only the parts without hardware
//! exist, for their tests: [`bit_timing`], [`counts`] and [`self_test`].
#![cfg_attr(target_os = "none", no_std)]

#[cfg(all(
    target_os = "none",
    not(any(feature = "bluepill", feature = "nucleo-f446re"))
))]
compile_error!("choose a board: feature `bluepill` (the default) or `nucleo-f446re`");

#[cfg(all(feature = "bluepill", feature = "nucleo-f446re"))]
compile_error!("one board only: `nucleo-f446re` goes with --no-default-features");

#[cfg(all(target_os = "none", target_abi = "eabihf", feature = "bluepill"))]
compile_error!("the Blue Pill has no FPU: build it with --target thumbv7m-none-eabi");

pub mod bit_timing;
pub mod counts;
pub mod self_test;

#[macro_use]
mod log;

// `board` is set by the build script: the target has no operating system and one board is chosen.
#[cfg(board)]
pub mod app;
#[cfg(board)]
pub mod board;
#[cfg(board)]
pub mod can;
#[cfg(board)]
pub mod clock;
#[cfg(board)]
pub mod flash;
#[cfg(board)]
pub mod imu;
#[cfg(board)]
mod mem;
#[cfg(board)]
mod reset;
#[cfg(board)]
mod sleep;

/// The main function of a product: on a board it runs the node, on a PC it says where it belongs. An article has name and image of
/// its own; a product without articles names them here.
#[macro_export]
macro_rules! firmware {
    ($node:ty, $article:expr) => {
        $crate::firmware!($node, $article.name, $article.image, |node, now, boot| node
            .start($article, now, boot));
    };
    ($node:ty, $name:expr, $image:expr) => {
        $crate::firmware!($node, $name, $image, |node, now, boot| node
            .start(now, boot));
    };
    ($node:ty, $name:expr, $image:expr, |$it:ident, $now:ident, $boot:ident| $start:expr) => {
        #[cfg(target_os = "none")]
        const _: () = assert!(
            <$node>::FILTERS <= $crate::board::FILTER_BANKS as usize,
            "the controller has a bank for each filter"
        );

        #[cfg(target_os = "none")]
        #[cortex_m_rt::entry]
        fn main() -> ! {
            // In static memory, so that its size shows in the image and not on the stack; `entry` makes it safe to borrow.
            static mut NODE: $node = <$node>::INITIAL;
            static mut STORE: core::mem::MaybeUninit<
                $crate::app::ParameterStore<{ <$node>::STORE_BUFFER }>,
            > = core::mem::MaybeUninit::uninit();
            $crate::app::run(
                |serial| <$node>::owner($image, serial),
                STORE,
                NODE,
                |$it: &mut $node, $now, $boot: &_| $start,
            )
        }

        #[cfg(not(target_os = "none"))]
        fn main() {
            println!(
                "{} is firmware for a board ({} filters, {:?}): see the README",
                $name,
                <$node>::FILTERS,
                <$node>::owner($image, 0),
            );
        }
    };
}
