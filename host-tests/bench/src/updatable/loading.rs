//! The bootloader while it waits for a client.

use super::pages::Pages;
use crate::bus::instant;
use crate::controller::{Controller, Interrupt};
use crate::device::{ERASE_TIME, PROGRAM_TIME};
use crate::flash::Flash;
use can_wire::protocol::{Event, Picoseconds};
use plumbline::can::{CanId, Filter, Frame};
use plumbline::node::driver::{Controller as _, Mailboxes};
use plumbline::node::{BusEvent, BusMode, BusState, Leds};
use plumbline::time::{Duration, Instant, after, millis, reached};
use plumbline::update::layout::BLUEPILL;
use plumbline::update::{Device, Program, Record, Update, UpdateServer};

/// The pause between two checks for a transfer that has timed out.
const TICK: Duration = millis(100);

/// The bootloader.
pub(super) struct Loading {
    update: Update<Pages>,
    server: UpdateServer,
    pub(super) controller: Controller,
    request: CanId,
    reply: CanId,
    tick: Instant,
    /// The processor is stalled until then, because flash is programmed or erased. Then it sends this answer.
    stalled: Option<(Instant, Option<[u8; 8]>)>,
}

impl Loading {
    /// It sends its message at the start.
    pub(super) fn start(now: Instant, pages: Pages, program: Program, record: Record) -> Self {
        let device = Device {
            product: Some(record.product()),
            board: BLUEPILL.board,
            layout: BLUEPILL.number,
        };
        let mut controller = Controller::new(now);
        let filter = Filter::exact(record.request());
        controller.begin(BusMode::Normal, record.rate(), vec![filter]);
        let boot_up = record.boot_up();
        let data: &[u8] = match boot_up.bits() {
            0x701..=0x77F => &[0],
            _ => b"\x60BOOT",
        };
        let mut loading = Self {
            update: Update::new(pages, program, device, Some(record)),
            server: UpdateServer::new(),
            controller,
            request: record.request(),
            reply: record.reply(),
            tick: after(now, TICK),
            stalled: None,
        };
        loading.send(boot_up, data);
        loading
    }

    pub(super) fn into_pages(self) -> Pages {
        self.update.into_slot()
    }

    pub(super) fn flash(&mut self) -> &mut Flash {
        &mut self.update.slot_mut().0
    }

    /// Whether it restarts now: the client has commanded it, and the reply was sent.
    pub(super) fn takes_restart(&mut self) -> bool {
        self.stalled.is_none() && self.controller.is_idle() && self.update.take_restart()
    }

    pub(super) fn leds(&self) -> Leds {
        Leds {
            run: true,
            error: self.update.program().header().is_none(),
            ..Leds::default()
        }
    }

    pub(super) fn next_event(&self) -> Instant {
        self.stalled.map_or(self.tick, |(until, _)| until)
    }

    pub(super) fn advance(&mut self, now: Instant) {
        self.controller.set_time(now);
        if let Some((until, answer)) = self.stalled {
            if !reached(now, until) {
                return;
            }
            self.stalled = None;
            if let Some(answer) = answer {
                self.send(self.reply, &answer);
            }
        }
        if reached(now, self.tick) {
            self.tick = after(now, TICK);
            if let Some(abort) = self.server.poll(now) {
                self.send(self.reply, &abort);
            }
        }
        self.service(now);
    }

    pub(super) fn step(&mut self, now: Picoseconds, dominant: bool) -> Option<Event> {
        let stalled = self.stalled.is_some();
        let event = self.controller.step(now, dominant, stalled)?;
        self.controller.set_time(instant(now));
        while let Some(event) = self.controller.event() {
            if event == BusEvent::State(BusState::BusOff) {
                self.controller.recover();
            }
        }
        self.service(instant(now));
        Some(event)
    }

    /// Handles the received frames.
    fn service(&mut self, now: Instant) {
        while self.stalled.is_none()
            && let Some(interrupt) = self.controller.take_interrupt()
        {
            let Interrupt::Received(frame) = interrupt else {
                continue;
            };
            let Ok(data) = frame.bytes().try_into() else {
                continue;
            };
            if frame.can_id() != self.request {
                continue;
            }
            let before = self.work();
            let answer = self.server.serve(&mut self.update, now, data);
            let (programmed, erased) = self.work();
            let half_words = (programmed - before.0).div_ceil(2);
            let ticks =
                half_words * PROGRAM_TIME.ticks() + (erased - before.1) * ERASE_TIME.ticks();
            if ticks > 0 {
                self.stalled = Some((after(now, Duration::from_ticks(ticks)), answer));
            } else if let Some(answer) = answer {
                self.send(self.reply, &answer);
            }
        }
    }

    /// Bytes programmed and pages erased so far.
    fn work(&self) -> (u64, u64) {
        let flash = &self.update.slot().0;
        (flash.programmed(), flash.erased())
    }

    /// Sends a frame. If the one before it waits for a free bus, it is not sent: the client repeats its request.
    fn send(&mut self, id: CanId, data: &[u8]) {
        if self.controller.is_idle()
            && let Some(frame) = Frame::data(id.into(), data)
        {
            self.controller.put(&frame, false);
        }
    }
}
