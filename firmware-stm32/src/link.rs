//! The link of the node with the CAN controller, which the CAN interrupts and the main loop share.
//!
//! The receive interrupt passes a frame to the node and puts the answer into a mailbox at once, also while the main loop calculates or
//! reads the accelerometer. Interrupts are masked only while the link is in use, which is short.

use crate::can::Bus;
use crate::can::mailboxes::Mailboxes;
use crate::can::receive;
use crate::{board, clock, sleep};
use core::cell::Cell;
use cortex_m::peripheral::SCB;
use critical_section::{CriticalSection, Mutex};
use plumbline::node::driver::{self, Exchange, Line, Link};
use plumbline::node::{CommunicationOf, ProductNode};
use plumbline::time::Instant;

/// The parts of the link of node `N`.
type Parts<N> = (
    &'static mut CommunicationOf<N>,
    &'static mut Line<Mailboxes>,
);

/// The link of a product, in static memory.
pub struct Shared<N: ProductNode> {
    /// None before the start, and while the link is in use.
    parts: Mutex<Cell<Option<Parts<N>>>>,
    /// A check value of their addresses.
    check: Mutex<Cell<usize>>,
}

/// The check value of the addresses of these parts.
fn check<N: ProductNode>((node, line): &Parts<N>) -> usize {
    let [node, line] = [
        (&raw const **node).cast::<()>().addr(),
        (&raw const **line).addr(),
    ];
    !(node ^ line.rotate_left(16))
}

impl<N: ProductNode> Shared<N> {
    /// Before the start of the node.
    pub const fn empty() -> Self {
        Self {
            parts: Mutex::new(Cell::new(None)),
            check: Mutex::new(Cell::new(0)),
        }
    }

    /// Takes the communicating half of the node, and the mailboxes. The CAN interrupts must not be enabled yet.
    pub fn start(&self, node: &'static mut CommunicationOf<N>, line: &'static mut Line<Mailboxes>) {
        let parts = (node, line);
        critical_section::with(|cs| {
            self.check.borrow(cs).set(check::<N>(&parts));
            self.parts.borrow(cs).set(Some(parts));
        });
    }

    /// Restarts if a disturbance has changed an address of the parts, a checked value of the node, or whether there are single attempts.
    /// Returns whether the node takes part in the bus, in the mode of the controller and with its filters; true also while it cannot.
    pub fn inspect(&self, bus: &mut Bus) -> bool {
        let mode = bus.serving();
        critical_section::with(|cs| {
            let parts = self.take(cs);
            let is_same = check::<N>(&parts) == self.check.borrow(cs).get();
            let (node, line) = parts;
            if !is_same || !node.is_intact() {
                error!("restart: the node is disturbed");
                board::restart();
            }
            let mut link = Link::new(&mut *node, &mut *line);
            link.mailboxes().verify();
            let serves = match mode {
                Some(mode) => link.serves(mode) && bus.has_filters(|accept| node.filters(accept)),
                None => true,
            };
            self.parts.borrow(cs).set(Some((node, line)));
            serves
        })
    }

    #[inline(always)] // measured: without it, the slowest answer of the IMS360 takes longer
    fn take(&self, cs: CriticalSection<'_>) -> Parts<N> {
        match self.parts.borrow(cs).take() {
            Some(parts) => parts,
            // Not possible: uses are not nested, and the interrupts are enabled after the start.
            None => SCB::sys_reset(),
        }
    }

    /// The receive interrupt.
    ///
    /// # Safety
    /// Call it only in the receive interrupt. The interrupts that use the link, and SysTick, must have the same priority.
    pub unsafe fn on_received(&self) {
        // SAFETY: no other interrupt that uses a `Mutex` interrupts this one, and the main loop does not run.
        let cs = unsafe { CriticalSection::new() };
        let (node, line) = self.take(cs);
        let mut link = Link::new(&mut *node, &mut *line);
        while let Some(received) = receive::next() {
            if let Some(frame) = &received {
                link.receive(frame);
            }
        }
        self.parts.borrow(cs).set(Some((node, line)));
        sleep::wake();
    }

    /// The transmit interrupt: a mailbox has become free.
    ///
    /// # Safety
    /// Call it only in the transmit interrupt. The priorities must be as for [`on_received`](Self::on_received).
    pub unsafe fn on_transmitted(&self) {
        // SAFETY: as in `on_received`.
        let cs = unsafe { CriticalSection::new() };
        let (node, line) = self.take(cs);
        let mut link = Link::new(&mut *node, &mut *line);
        let unsent = if CommunicationOf::<N>::USES_SENT {
            link.mailboxes().complete()
        } else {
            crate::can::transmit::acknowledge();
            false
        };
        link.transmitted(unsent);
        self.parts.borrow(cs).set(Some((node, line)));
        sleep::wake();
    }
}

impl<N: ProductNode> driver::Shared for &'static Shared<N> {
    type Node = N;
    type Mailboxes = Mailboxes;

    /// Uses the link while the interrupts are masked.
    fn with<R>(&self, f: impl FnOnce(&mut driver::LinkOf<'_, N, Mailboxes>) -> R) -> R {
        critical_section::with(|cs| {
            let (node, line) = self.take(cs);
            let result = f(&mut Link::new(&mut *node, &mut *line));
            self.parts.borrow(cs).set(Some((node, line)));
            result
        })
    }

    fn now(&self) -> Instant {
        clock::now()
    }
}
