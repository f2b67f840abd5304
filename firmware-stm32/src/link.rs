//! The link of the node with the CAN controller, which the CAN interrupts and the main loop share.
//!
//! The receive interrupt passes a frame to the node and puts the answer into a mailbox at once, also while the main loop calculates or
//! reads the accelerometer. Interrupts are masked only while the link is in use, which is short.

use crate::can::mailboxes::Mailboxes;
use crate::can::receive;
use crate::{clock, sleep};
use core::cell::Cell;
use cortex_m::peripheral::SCB;
use critical_section::{CriticalSection, Mutex};
use plumbline::node::driver::{self, Exchange, Line, Link};
use plumbline::node::{CommunicationOf, ProductNode};
use plumbline::time::Instant;

/// The link of node `N`.
type LinkOf<N> = driver::LinkOf<'static, N, Mailboxes>;

/// The link of a product, in static memory. It is None before the start, and while it is in use.
pub struct Shared<N: ProductNode>(Mutex<Cell<Option<LinkOf<N>>>>);

impl<N: ProductNode> Shared<N> {
    /// Before the start of the node.
    pub const fn empty() -> Self {
        Self(Mutex::new(Cell::new(None)))
    }

    /// Takes the communicating half of the node, and the mailboxes. The CAN interrupts must not be enabled yet.
    pub fn start(&self, node: &'static mut CommunicationOf<N>, line: &'static mut Line<Mailboxes>) {
        let link = Link::new(node, line);
        critical_section::with(|cs| self.0.borrow(cs).set(Some(link)));
    }

    #[inline(always)] // measured: without it, the slowest answer of the IMS360 takes longer
    fn take(&self, cs: CriticalSection<'_>) -> LinkOf<N> {
        match self.0.borrow(cs).take() {
            Some(link) => link,
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
        let mut link = self.take(cs);
        while let Some(received) = receive::next() {
            if let Some(frame) = &received {
                link.receive(frame);
            }
        }
        self.0.borrow(cs).set(Some(link));
        sleep::wake();
    }

    /// The transmit interrupt: a mailbox has become free.
    ///
    /// # Safety
    /// Call it only in the transmit interrupt. The priorities must be as for [`on_received`](Self::on_received).
    pub unsafe fn on_transmitted(&self) {
        // SAFETY: as in `on_received`.
        let cs = unsafe { CriticalSection::new() };
        let mut link = self.take(cs);
        let unsent = if CommunicationOf::<N>::USES_SENT {
            link.mailboxes().complete()
        } else {
            crate::can::transmit::acknowledge();
            false
        };
        link.transmitted(unsent);
        self.0.borrow(cs).set(Some(link));
        sleep::wake();
    }
}

impl<N: ProductNode> driver::Shared for &'static Shared<N> {
    type Node = N;
    type Mailboxes = Mailboxes;

    /// Uses the link while the interrupts are masked.
    fn with<R>(&self, f: impl FnOnce(&mut driver::LinkOf<'_, N, Mailboxes>) -> R) -> R {
        critical_section::with(|cs| {
            let mut link = self.take(cs);
            let result = f(&mut link);
            self.0.borrow(cs).set(Some(link));
            result
        })
    }

    fn now(&self) -> Instant {
        clock::now()
    }
}
