//! Measures short instruction sequences with DWT CYCCNT, at 0 and 2 wait states of the flash. This is not a sensor.
//!
//! The simulator charges cycles by the timing table of the Technical Reference Manual. If the manuals give a range, it uses the maximum
//! (`host-tests/stm32-sim/src/cortex_m/timing.rs`). The figures of a board are the cycles of the chip. The same image runs in the
//! simulator, which prints its figures beside the names:
//!
//! ```sh
//! cargo bluepill cyccnt                                          # on a Blue Pill with a probe, figures in the log (RTT)
//! cargo nucleo cyccnt                                            # on a Nucleo-F446RE
//! cargo test -p stm32-sim --test images cyccnt -- --nocapture    # in the simulator
//! ```
//!
//! A figure is the difference of two reads of CYCCNT around the sequence; the row `empty` has no instruction in between. The
//! processor runs on HSI, so that 0 wait states are permitted, and the clock of APB1 is half of HCLK. The Nucleo runs without the
//! caches of its flash accelerator.
//!
//! Without the feature `defmt` the figures are only in the static `CYCCNT_RESULTS`, for a debugger:
//!
//! | word | |
//! |---|---|
//! | 0 | 43594343h when all sequences are measured |
//! | 1 | the number of sequences |
//! | 2 | address of the sequences: address and length of the name, address of the code |
//! | 3.. | two figures for each sequence: at 0 and 2 wait states |
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod measure;
#[cfg(target_os = "none")]
mod sequences;

/// On a PC there is nothing to measure.
#[cfg(not(target_os = "none"))]
fn main() {
    println!("cyccnt is a program for a board: cargo bluepill cyccnt");
}
