//! A disturbance can also change a variable. Then the node could be mute although its program runs and all registers are right. So the
//! firmware checks ten times a second that the node takes part in the bus, and restarts if it does not.
//!
//! The interrupts answer frames meanwhile, so the link is used for a few instructions at a time. A comparison in one use would delay an answer.

use crate::board;
use crate::can::Bus;
use crate::can::mailboxes::Mailboxes;
use plumbline::node::driver::{Line, Shared};
use plumbline::node::{CommunicationOf, ProductNode};
use plumbline::time::{Duration, Instant, after, millis, reached};

/// The longest time in which the node takes no frame although the bus works. A restart takes 0.35 s; the clock stands during an erase.
const SERVING_LIMIT: Duration = millis(1000);

/// The longest time between two checks. The clock stands during an erase.
const CHECK_LIMIT: Duration = millis(1000);

/// What the node must not change alone.
pub struct Guard {
    /// The addresses of the node and of its line.
    places: [usize; 2],
    /// The address of the node in the network, and the check value of the filters for it.
    address: Option<(u32, u32)>,
    /// The time of the last check.
    checked: Instant,
    /// The last time at which the node took part in the bus, or could not.
    served: Instant,
}

impl Guard {
    /// Before the start of the node.
    pub fn new<N: ProductNode>(
        node: &CommunicationOf<N>,
        line: &Line<Mailboxes>,
        now: Instant,
    ) -> Self {
        Self {
            places: [address_of(node), address_of(line)],
            address: None,
            checked: now,
            served: now,
        }
    }

    /// Restarts if a disturbance has changed where the node is, its address, or whether it takes part in the bus.
    #[cold]
    #[inline(never)] // measured: in the main loop, it makes the slowest answers longer
    pub fn check<S: Shared<Mailboxes = Mailboxes>>(
        &mut self,
        link: &S,
        bus: &mut Bus,
        now: Instant,
    ) {
        if !reached(now, self.checked) || reached(now, after(self.checked, CHECK_LIMIT)) {
            restart("the time");
        }
        self.checked = now;
        let places = link.with(|link| {
            let (node, line) = link.parts();
            [address_of(node), address_of(line)]
        });
        if places != self.places {
            restart("the link");
        }
        if let Some(new) = link.with(|link| link.parts().0.address()) {
            let after = bus.check_value();
            if self
                .address
                .is_some_and(|(old, before)| old != new && before == after)
            {
                restart("the address");
            }
            self.address = Some((new, after));
        }
        let serves = match bus.serving() {
            Some(mode) => link.with(|link| link.serves(mode)),
            None => true,
        };
        if serves {
            self.served = now;
        } else if reached(now, after(self.served, SERVING_LIMIT)) {
            restart("the state");
        }
    }
}

fn address_of<T>(value: &T) -> usize {
    (&raw const *value).addr()
}

fn restart(disturbed: &str) -> ! {
    error!("restart: {} of the node is disturbed", disturbed);
    board::restart()
}
