//! Reads a stream of bytes in a thread of its own.
//!
//! The time-out of a socket or a serial port is rounded up to the timer of the operating system: a wait of 1 ms can take 10 ms, in which
//! the tool sends no poll. The wait for this thread is exact.

use super::slcan::Stream;
use super::tcp::is_timeout;
use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// The wait of the thread for bytes, between two checks whether it must end.
pub const SLICE: Duration = Duration::from_millis(50);

/// The wait for the end of the thread. A read of a driver that never returns must not hold the program.
const ENDING: Duration = Duration::from_secs(1);

/// The pieces that the thread reads ahead. The operating system keeps what comes after them.
const AHEAD: usize = 64;

/// The length of the longest piece.
const PIECE: usize = 4096;

type Piece = io::Result<Vec<u8>>;

/// A stream whose bytes are read in a thread.
pub struct Background<W> {
    writer: W,
    /// None: the thread has ended.
    pieces: Option<Receiver<Piece>>,
    /// What is left of a piece.
    rest: Vec<u8>,
    is_ending: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    /// Its sender is dropped when the thread ends.
    ended: Receiver<()>,
}

impl<W: Write> Background<W> {
    /// Reads with `read`, which waits at most [`SLICE`] and then returns the error of a time-out.
    ///
    /// # Errors
    /// There is no thread.
    pub fn start(
        writer: W,
        mut read: impl FnMut(&mut [u8]) -> io::Result<usize> + Send + 'static,
    ) -> io::Result<Self> {
        let (sender, pieces) = sync_channel(AHEAD);
        let is_ending = Arc::new(AtomicBool::new(false));
        let ends = is_ending.clone();
        let (is_running, ended) = sync_channel(0);
        let run = move || {
            let _is_running = is_running;
            while !ends.load(Ordering::Relaxed) && next(&mut read, &sender) {}
        };
        let thread = thread::Builder::new()
            .name("adapter".to_owned())
            .spawn(run)?;
        Ok(Self {
            writer,
            pieces: Some(pieces),
            rest: Vec::new(),
            is_ending,
            thread: Some(thread),
            ended,
        })
    }
}

/// Reads a piece and hands it over. False: the stream has ended, or nobody takes its pieces.
fn next(read: &mut impl FnMut(&mut [u8]) -> io::Result<usize>, sender: &SyncSender<Piece>) -> bool {
    let mut bytes = [0; PIECE];
    match read(&mut bytes) {
        Ok(0) => {
            let error = io::Error::new(io::ErrorKind::UnexpectedEof, "the connection was closed");
            // The program can have ended.
            let _ = sender.send(Err(error));
            false
        }
        Ok(count) => sender.send(Ok(bytes[..count].to_vec())).is_ok(),
        Err(error) if is_timeout(&error) => true,
        Err(error) => {
            let _ = sender.send(Err(error));
            false
        }
    }
}

impl<W: Write> Stream for Background<W> {
    fn read(&mut self, bytes: &mut [u8], timeout: Duration) -> io::Result<usize> {
        if self.rest.is_empty() {
            let ended = || io::Error::new(io::ErrorKind::BrokenPipe, "the connection has ended");
            let pieces = self.pieces.as_ref().ok_or_else(ended)?;
            match pieces.recv_timeout(timeout) {
                Ok(piece) => self.rest = piece?,
                Err(RecvTimeoutError::Timeout) => return Ok(0),
                Err(RecvTimeoutError::Disconnected) => return Err(ended()),
            }
        }
        let count = self.rest.len().min(bytes.len());
        let (taken, rest) = self.rest.split_at(count);
        bytes[..count].copy_from_slice(taken);
        self.rest = rest.to_vec();
        Ok(count)
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.writer.write_all(bytes)
    }
}

impl<W> Drop for Background<W> {
    fn drop(&mut self) {
        self.is_ending.store(true, Ordering::Relaxed);
        // A thread that waits for room ends too.
        self.pieces = None;
        let has_ended = self.ended.recv_timeout(ENDING) == Err(RecvTimeoutError::Disconnected);
        if let Some(thread) = self.thread.take().filter(|_| has_ended) {
            // The port is closed when the thread has ended, so that it can be opened again.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stream on which these pieces come, and then nothing.
    fn stream(pieces: Vec<Piece>) -> Background<io::Sink> {
        let mut pieces = pieces.into_iter();
        let read = move |bytes: &mut [u8]| match pieces.next() {
            Some(piece) => piece.map(|piece| {
                bytes[..piece.len()].copy_from_slice(&piece);
                piece.len()
            }),
            None => {
                thread::sleep(Duration::from_millis(5));
                Err(io::ErrorKind::WouldBlock.into())
            }
        };
        Background::start(io::sink(), read).unwrap()
    }

    #[test]
    fn pieces_are_read_in_order_and_in_parts() {
        let mut stream = stream(vec![Ok(b"abc".to_vec()), Ok(b"d".to_vec())]);
        let mut read = Vec::new();
        let mut bytes = [0; 2];
        while read.len() < 4 {
            let count = stream.read(&mut bytes, Duration::from_secs(10)).unwrap();
            read.extend_from_slice(&bytes[..count]);
        }
        assert_eq!(read, b"abcd");
        assert_eq!(stream.read(&mut bytes, Duration::ZERO).unwrap(), 0);
    }

    #[test]
    fn end_and_error_of_a_stream_are_errors() {
        let lost = || Err(io::Error::other("unplugged"));
        for pieces in [vec![lost()], vec![Ok(Vec::new())]] {
            let mut stream = stream(pieces);
            for _ in 0..2 {
                assert!(stream.read(&mut [0; 8], Duration::from_secs(10)).is_err());
            }
        }
    }

    #[test]
    fn stream_that_nobody_reads_ends() {
        let pieces = std::iter::repeat_with(|| Ok(vec![0; PIECE])).take(10 * AHEAD);
        drop(stream(pieces.collect()));
    }

    /// The read returns only after the stream is dropped: a wait for it would not end.
    #[test]
    fn stream_whose_read_does_not_return_ends() {
        let (begins, begun) = sync_channel(1);
        let (end, ended) = sync_channel::<()>(0);
        let read = move |_: &mut [u8]| {
            let _ = begins.send(());
            match ended.recv() {
                Ok(()) => Ok(1),
                Err(_) => Err(io::ErrorKind::WouldBlock.into()),
            }
        };
        let stream = Background::start(io::sink(), read).unwrap();
        begun.recv().unwrap();
        drop(stream);
        drop(end);
    }

    /// The read of the thread, which can be longer than a wait, does not return before the wait has ended.
    #[test]
    fn wait_does_not_last_until_the_read_of_the_thread_returns() {
        let (end, ended) = sync_channel::<()>(0);
        let read = move |_: &mut [u8]| match ended.recv_timeout(Duration::from_secs(60)) {
            Err(RecvTimeoutError::Timeout) => Ok(1),
            _ => Err(io::ErrorKind::WouldBlock.into()),
        };
        let mut stream = Background::start(io::sink(), read).unwrap();
        let wait = Duration::from_millis(1);
        assert_eq!(stream.read(&mut [0; 8], wait).unwrap(), 0);
        drop(end);
    }
}
