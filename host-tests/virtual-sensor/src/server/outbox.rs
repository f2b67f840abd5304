//! Data waiting to be written to a client, so that a slow client never blocks the sensor.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Bytes that a client may leave unread, in addition to the buffers of the operating system: half a minute of a fully loaded bus
/// at 1 Mbit/s.
const LIMIT: usize = 8 << 20;

/// Bytes from the server for the thread that writes them to one client.
#[derive(Debug, Default)]
pub(super) struct Outbox {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    bytes: Vec<u8>,
    closed: bool,
}

impl Outbox {
    /// Adds bytes without waiting. False when the client has left too much unread, or the outbox is closed; then the bytes are
    /// dropped.
    pub(super) fn push(&self, bytes: &[u8]) -> bool {
        let mut state = self.lock();
        if state.closed || state.bytes.len() + bytes.len() > LIMIT {
            return false;
        }
        state.bytes.extend_from_slice(bytes);
        self.changed.notify_one();
        true
    }

    /// Closes the outbox for new bytes; its content can still be taken.
    pub(super) fn close(&self) {
        self.lock().closed = true;
        self.changed.notify_one();
    }

    /// Waits for bytes and takes all of them; None when the outbox is closed and empty.
    pub(super) fn take(&self) -> Option<Vec<u8>> {
        let waits = |state: &mut State| state.bytes.is_empty() && !state.closed;
        let mut state = self
            .changed
            .wait_while(self.lock(), waits)
            .unwrap_or_else(PoisonError::into_inner);
        let bytes = std::mem::take(&mut state.bytes);
        (!bytes.is_empty()).then_some(bytes)
    }

    /// Every change of the state is complete, so a thread that panicked leaves a consistent state.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn take_returns_all_bytes_in_order() {
        let outbox = Outbox::default();
        assert!(outbox.push(b"ab"));
        assert!(outbox.push(b"c"));
        assert_eq!(outbox.take(), Some(b"abc".to_vec()));
        assert!(outbox.push(b"d"));
        outbox.close();
        assert!(!outbox.push(b"e"));
        assert_eq!(outbox.take(), Some(b"d".to_vec()));
        assert_eq!(outbox.take(), None);
    }

    #[test]
    fn push_fails_when_outbox_is_full() {
        let outbox = Outbox::default();
        assert!(outbox.push(&vec![0; LIMIT]));
        assert!(!outbox.push(&[0]));
        assert_eq!(outbox.take().map(|bytes| bytes.len()), Some(LIMIT));
        assert!(outbox.push(&[0]));
    }

    #[test]
    fn close_wakes_writer() {
        let outbox = Outbox::default();
        std::thread::scope(|scope| {
            let writer = scope.spawn(|| outbox.take());
            std::thread::sleep(std::time::Duration::from_millis(20));
            outbox.close();
            assert_eq!(writer.join().ok(), Some(None));
        });
    }
}
