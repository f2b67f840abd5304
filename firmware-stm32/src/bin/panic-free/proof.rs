//! The program for the target.

use core::hint::black_box;
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use plumbline::can::{Frame, extended, standard};
use plumbline::measure::fusion::{Fusion, Noise};
use plumbline::measure::self_test::Working;
use plumbline::measure::{I32x3, Reading, mean_rate};
use plumbline::model::gemac::is1::{self, Is1};
use plumbline::model::gemac::is2::{self, Is2};
use plumbline::model::gemac::is2tk::{self, Is2tk};
use plumbline::model::jn2101::Jn2101;
use plumbline::model::tiltix::tiltix360::Tiltix360;
use plumbline::node::{BitTime, BusEvent, ProductNode, StoreOf};
use plumbline::store::StoreError;
use plumbline::time::Instant;

// Only for the transport of defmt and the vector table.
#[cfg(feature = "defmt")]
use defmt_rtt as _;
#[cfg(feature = "nucleo-f446re")]
use stm32f4xx_hal as _;

/// The linker script expects a vector table.
// SAFETY: nobody runs this program.
#[cfg(feature = "stm32f103")]
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [usize; 1] = [0];

#[cortex_m_rt::entry]
fn main() -> ! {
    exercise::<Is1>(black_box(&is1::BP_CL));
    exercise::<Is2>(black_box(&is2::BP_CL));
    exercise::<Is2tk>(black_box(&is2tk::METAL));
    exercise::<Jn2101>(&());
    exercise::<Tiltix360>(&());
    exercise_fusion();
    loop {
        cortex_m::asm::wfi();
    }
}

/// Runs a store and a node with opaque inputs, with the calls in any order.
fn exercise<N: ProductNode>(article: &N::Article) {
    let mut store = StoreOf::<N, _>::open(Memory, black_box(N::owner(article, 1)));
    let mut node = N::INITIAL;
    node.start(article, now(), &store.boot());
    while black_box(true) {
        match black_box(0) {
            0 => {
                black_box(node.ready());
            }
            1 => node.receive(now(), &frame()),
            2 => node.sample(now(), &reading()),
            3 => node.bus(now(), black_box(BusEvent::BitTime(BitTime(1)))),
            4 => node.stored(now(), black_box(Err(StoreError))),
            5 => {
                black_box(node.poll(now()));
            }
            6 => {
                black_box(node.transmit(now()));
            }
            7 => {
                black_box(node.deadline());
            }
            8 => node.filters(&mut |filter| {
                black_box(filter);
            }),
            9 => {
                black_box(node.image(&mut black_box([0; 100])));
            }
            10 => {
                black_box(node.readout());
            }
            11 => {
                let [x, y, z] = black_box([false; 3]);
                node.tested(now(), Working { x, y, z });
            }
            14 => node.sent(now()),
            15 => store.prepare(),
            12 => store.save(|buffer| node.image(buffer)),
            13 => {
                black_box(store.busy());
            }
            _ => {
                black_box(store.step());
            }
        }
    }
}

/// Runs the fusion with opaque inputs.
fn exercise_fusion() {
    let mut fusion = Fusion::<{ mean_rate::ACCELERATION_AGE }>::new();
    let noise = || Noise::new(black_box(0), black_box(0));
    while black_box(true) {
        match black_box(0) {
            0 => fusion.tune(noise(), noise()),
            1 => fusion.skip(),
            2 => fusion.settle(reading().acceleration),
            _ => {
                let Reading {
                    acceleration,
                    angular_rate,
                    ..
                } = reading();
                black_box(fusion.step(acceleration, angular_rate, true));
            }
        }
    }
}

fn now() -> Instant {
    Instant::from_ticks(black_box(0))
}

fn frame() -> Frame {
    let id = if black_box(false) {
        extended(black_box(0))
    } else {
        standard(black_box(0))
    };
    let frame = if black_box(false) {
        Frame::remote(id, black_box(0))
    } else {
        Frame::data(id, &black_box([0; 8])[..black_box(0_usize).min(8)])
    };
    loop {
        if let Some(frame) = frame {
            return frame;
        }
    }
}

fn reading() -> Reading {
    let vector = || I32x3 {
        x: black_box(0),
        y: black_box(0),
        z: black_box(0),
    };
    Reading {
        acceleration: vector(),
        angular_rate: vector(),
        temperature: black_box(0),
        clipped: black_box(false),
    }
}

/// A flash with opaque contents and the geometry of the Blue Pill.
struct Memory;

impl ErrorType for Memory {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Memory {
    const READ_SIZE: usize = 1;

    fn read(&mut self, _offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        bytes.fill(black_box(0));
        black_box(Ok(()))
    }

    fn capacity(&self) -> usize {
        2048
    }
}

impl NorFlash for Memory {
    const WRITE_SIZE: usize = 2;
    const ERASE_SIZE: usize = 1024;

    fn erase(&mut self, _from: u32, _to: u32) -> Result<(), Self::Error> {
        black_box(Ok(()))
    }

    fn write(&mut self, _offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        black_box(bytes);
        black_box(Ok(()))
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    #[cfg(not(any(debug_assertions, feature = "defmt")))]
    {
        unsafe extern "C" {
            fn panic_path_in_core() -> !;
        }
        // SAFETY: the function does not exist, so a program in which this line is reachable does not link.
        unsafe { panic_path_in_core() }
    }
    #[cfg(any(debug_assertions, feature = "defmt"))]
    loop {
        cortex_m::asm::wfi();
    }
}
