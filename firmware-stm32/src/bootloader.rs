//! The bootloader: starts the program in its slot, or takes another one over CAN ([`plumbline::update`]).
//!
//! ```text
//!  Blue Pill              Nucleo-F103RB          Nucleo-F446RE
//!  0800_0000   8 KiB      0800_0000   8 KiB      0800_0000   16 KiB   bootloader, write-protected by its option bytes
//!  0800_2000  53 KiB      0800_2000  58 KiB      0802_0000  128 KiB   program: vectors, header (byte 512), code
//!                         0801_0800  58 KiB      0804_0000  128 KiB   download
//!  0800_F400   1 KiB      0801_F000   1 KiB      0806_0000    1 KiB   boot record
//!  0800_F800   2 KiB      0801_F800   2 KiB      0800_8000   32 KiB   parameters and calibration, which an update does not change
//! ```
//!
//! All three have one bank of flash: while it is erased or programmed, no code runs. The bootloader answers afterwards.
//!
//! After a reset it compares the CRC of the program, with the clock of the reset, and jumps to it. The program finds all registers as after a
//! reset. If there is no complete program, or if the program has asked for an update in the [`mailbox`], the bootloader starts the clocks and
//! the CAN controller and waits for a client. It leaves this mode by a reset only.
//!
//! It answers with the identifiers and the bit rate of the mailbox, otherwise with those of the boot record. Without both it listens at each
//! bit rate in turn until it receives a valid frame, and answers as node 127: request 67Fh, reply 5FFh. It sends a message at its start only if
//! it knows its identifiers: the boot-up message of CANopen if that is its identifier, otherwise 60h "BOOT".

mod can;
pub mod pages;

use crate::board::{Basis, LAYOUT};
use crate::mailbox;
use can::{Can, Request};
use core::arch::asm;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{SCB, SYST};
use pages::{DOWNLOAD, Download, PROGRAM, Running};
use plumbline::can::{BitRate, CanId};
use plumbline::node::Leds;
use plumbline::time::{Instant, after, millis};
use plumbline::update::{Device, Program, Record, Update, UpdateServer, install};

/// The identifiers without a boot record: those of node 127.
const REQUEST: CanId = CanId::standard(0x67F);
const REPLY: CanId = CanId::standard(0x5FF);

/// The milliseconds in which it listens at a bit rate: ten frames at 10 kbit/s.
const LISTENING: u32 = 150;

/// Starts the program, or updates it.
///
/// # Safety
/// Call it only once: it takes all peripherals.
pub unsafe fn run() -> ! {
    let asked = mailbox::take(pages::crc);
    // SAFETY: the caller owns all peripherals.
    let (mut running, mut download) = unsafe { (Running::take(), Download::take()) };
    let mut program = Program::of(&running);
    let has_download = DOWNLOAD != PROGRAM && !matches!(Program::of(&download), Program::None);
    if let (None, Program::Complete(_), false) = (&asked, &program, has_download) {
        start();
    }
    // SAFETY: as above. An operation of the flash needs the voltage detector.
    let mut board = unsafe { Basis::take() };
    if has_download {
        // If the flash fails, it waits for a client. The next start tries it again.
        if install(&mut running, &mut download, || board.watchdog.feed()).is_ok() {
            SCB::sys_reset();
        }
        program = Program::None;
    }
    let program = program.committed(&mut running);
    if let (None, Program::Complete(_)) = (&asked, &program) {
        // The program starts with the registers of a reset.
        SCB::sys_reset();
    }
    if let Some(record) = &asked {
        // Before the flash of the program changes: afterwards nobody else knows it. If it fails, the mailbox is sufficient for this start.
        let _ = download.keep(record);
    }
    let record = asked.or_else(|| download.newest_record());
    update(board, download, program, record)
}

/// Updates the program. Ends by a reset.
fn update(mut board: Basis, slot: Download, program: Program, record: Option<Record>) -> ! {
    let device = Device {
        product: record.map(|record| record.product()),
        board: LAYOUT.board,
        layout: LAYOUT.number,
    };
    let (request, reply) =
        record.map_or((REQUEST, REPLY), |known| (known.request(), known.reply()));
    let mut update = Update::new(slot, program, device, record);
    let mut server = UpdateServer::new();
    start_timer(&mut board.systick);
    let mut now = Instant::from_ticks(0);
    let mut can = Can(board.can);
    let mut search = match record {
        Some(record) => {
            can.join(record.rate(), Some(request));
            can.send_boot_up(record.boot_up());
            None
        }
        None => Some(Search::start(&mut can)),
    };
    loop {
        // Until the next frame or millisecond nothing changes.
        let has_ticked = loop {
            let has_ticked = board.systick.has_wrapped();
            if has_ticked | can.has_received() {
                break has_ticked;
            }
        };
        board.watchdog.feed();
        // Before the next answer: after it, a client that sends requests without a pause would delay the restart.
        if can.is_idle() && update.take_restart() {
            SCB::sys_reset();
        }
        if has_ticked {
            now = after(now, millis(1));
            if let Some(search) = &mut search {
                search.tick(&mut can);
            }
        }
        let received = can.receive();
        if received.is_some()
            && let Some(search) = search.take()
        {
            can.join(search.rate(), Some(request));
        }
        let answer = match received {
            Some(Request { id, data }) if id == request => server.serve(&mut update, now, data),
            _ => server.poll(now),
        };
        if let Some(bytes) = answer {
            can.send(reply, bytes, 8);
        }
        board.leds.show(Leds {
            run: true,
            error: update.program().header().is_none(),
            ..Leds::default()
        });
    }
}

/// Jumps to the program, as a reset does.
fn start() -> ! {
    const VTOR: *mut u32 = 0xE000_ED08 as *mut u32;
    let program = pages::PROGRAM as *const u32;
    // SAFETY: the program is complete: it begins with its stack pointer and its entry. All interrupts are disabled in the NVIC.
    unsafe {
        VTOR.write_volatile(pages::PROGRAM as u32);
        let (stack, entry) = (program.read_volatile(), program.add(1).read_volatile());
        asm!("msr msp, {}", "bx {}", in(reg) stack, in(reg) entry, options(noreturn));
    }
}

/// The search for the bit rate: a silent controller at each one in turn.
struct Search {
    place: usize,
    /// The milliseconds that are left at this bit rate.
    left: u32,
}

impl Search {
    fn start(can: &mut Can) -> Self {
        let search = Self {
            place: 0,
            left: LISTENING,
        };
        can.listen(search.rate());
        search
    }

    fn rate(&self) -> BitRate {
        *BitRate::ALL.get(self.place).unwrap_or(&BitRate::K250)
    }

    /// Selects the next bit rate at the end of the time. Call it each millisecond.
    fn tick(&mut self, can: &mut Can) {
        self.left -= 1;
        if self.left == 0 {
            self.place = (self.place + 1) % BitRate::ALL.len();
            self.left = LISTENING;
            can.listen(self.rate());
        }
    }
}

/// Starts the timer of the milliseconds. Milliseconds during an operation of the flash are not counted.
fn start_timer(timer: &mut SYST) {
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(crate::board::CORE_CLOCK / 1000 - 1);
    timer.clear_current();
    timer.enable_counter();
}
