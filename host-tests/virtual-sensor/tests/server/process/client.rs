//! A raw slcan client that sends bytes and receives lines.

use super::sensor::{PATIENCE, Sensor};
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

/// A poll of the angles, and the start of its reply.
pub const POLL: &str = "t300100";
pub const REPLY: &str = "t301600";

/// A request for the cyclic time, and the start of its reply. The sensor answers in order: this reply comes after all that was due.
const LAST: &str = "t300115";
const LAST_REPLY: &str = "t301415";

/// The start of a boot-up message.
pub const BOOT_UP: &str = "t3018FF";

/// A line that was refused.
pub const BEL: &str = "\x07";

/// Time in which an unexpected line would arrive.
pub const QUIET: Duration = Duration::from_millis(200);

/// A client on a stream with a read timeout.
pub struct Client<S> {
    pub stream: S,
    buffer: Vec<u8>,
}

impl Client<TcpStream> {
    /// A client on TCP; its channel is closed.
    pub fn connect(sensor: &Sensor) -> Self {
        Self::on(sensor.connect())
    }

    /// A client on TCP with an open channel.
    pub fn open(sensor: &Sensor) -> Self {
        let mut client = Self::connect(sensor);
        client.expect("O", "");
        client
    }

    /// A client on a bus with a sensor that has detected the bit rate and sends no more frames without a request.
    pub fn awake(sensor: &Sensor) -> Self {
        let mut client = Self::open(sensor);
        client.wake();
        client
    }
}

impl<S: Read + Write> Client<S> {
    pub fn on(stream: S) -> Self {
        Self {
            stream,
            buffer: Vec::new(),
        }
    }

    /// Sends a line of slcan, with the carriage return at its end.
    pub fn say(&mut self, line: &str) {
        self.stream
            .write_all(format!("{line}\r").as_bytes())
            .expect("the server accepts it");
    }

    /// Sends one line and expects this answer, without its CR, before any other line.
    #[track_caller]
    pub fn expect(&mut self, line: &str, answer: &str) {
        self.say(line);
        assert_eq!(self.next().as_deref(), Some(answer), "{line}");
    }

    /// The next line without its CR, or the text of a BEL; None after a long silence or at the end of the connection.
    pub fn next(&mut self) -> Option<String> {
        self.next_within(PATIENCE)
    }

    /// The next line within this time.
    pub fn next_within(&mut self, time: Duration) -> Option<String> {
        let end = Instant::now() + time;
        loop {
            let at = self.buffer.iter().position(|b| matches!(b, b'\r' | 7));
            if let Some(at) = at {
                let mut line: Vec<u8> = self.buffer.drain(..=at).collect();
                if line.ends_with(b"\r") {
                    line.pop();
                }
                return Some(String::from_utf8(line).expect("ASCII"));
            }
            // It reads at least once, also if the computer was busy until now.
            let late = Instant::now() > end;
            let mut buffer = [0; 4096];
            match self.stream.read(&mut buffer) {
                Ok(0) => return None,
                Ok(length) => self.buffer.extend_from_slice(&buffer[..length]),
                Err(_) if late => return None,
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    std::thread::sleep(Duration::from_micros(200));
                }
                // Interrupted: the computer has stopped this program for some time.
                Err(error)
                    if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
                Err(_) => return None,
            }
        }
    }

    /// The next line that starts with this text; skips others.
    #[track_caller]
    pub fn find(&mut self, beginning: &str) -> String {
        let start = Instant::now();
        let mut others = Vec::new();
        while start.elapsed() < PATIENCE {
            match self.next() {
                Some(line) if line.starts_with(beginning) => return line,
                Some(line) => others.push(line),
                None => break,
            }
        }
        let last = &others[others.len().saturating_sub(20)..];
        let time = start.elapsed();
        panic!("no line starts with {beginning} within {time:?}, the last others are {last:?}");
    }

    /// Sends a last request and reads until its reply; returns the lines before it.
    #[track_caller]
    pub fn settle(&mut self) -> Vec<String> {
        self.say(LAST);
        let mut lines = Vec::new();
        loop {
            match self.next().expect("a reply") {
                line if line.starts_with(LAST_REPLY) => return lines,
                line => lines.push(line),
            }
        }
    }

    /// Asserts that nothing comes: not before the reply to a last request.
    #[track_caller]
    pub fn expect_nothing(&mut self) {
        assert_eq!(self.settle(), ["z"]);
    }

    /// Reads until the reply to the last request of another client.
    #[track_caller]
    pub fn catch_up(&mut self) {
        self.find(LAST_REPLY);
    }

    /// Polls the angles and returns them in 0.01 deg.
    #[track_caller]
    pub fn poll(&mut self) -> (i16, i16) {
        self.say(POLL);
        let line = self.find(REPLY);
        let value = |at: usize| {
            let byte = |at| u8::from_str_radix(&line[at..at + 2], 16).expect("hexadecimal");
            i16::from_le_bytes([byte(at), byte(at + 2)])
        };
        (value(9), value(13))
    }
}

impl Client<TcpStream> {
    /// Sends nothing more, and waits until the server has noticed it.
    pub fn leave(mut self) {
        self.stream.shutdown(Shutdown::Write).expect("a socket");
        while self.next().is_some() {}
    }

    /// Shortens the read timeout, to detect silence in time.
    pub fn impatient(&self) {
        let timeout = Some(Duration::from_millis(20));
        self.stream.set_read_timeout(timeout).expect("a socket");
    }

    /// Sends until the sensor, which detects the bit rate, has sent its two boot-up messages.
    #[track_caller]
    pub fn wake(&mut self) {
        self.impatient();
        let end = Instant::now() + PATIENCE;
        let mut heard = 0;
        while heard < 2 {
            assert!(Instant::now() < end, "the sensor does not wake up");
            if heard == 0 {
                self.say(POLL);
            }
            while let Some(line) = self.next_within(Duration::from_millis(100)) {
                heard += u32::from(line.starts_with(BOOT_UP));
                if heard == 2 {
                    break;
                }
            }
        }
        self.settle();
        self.stream
            .set_read_timeout(Some(PATIENCE))
            .expect("a socket");
    }
}

/// Advances the time by at most this span in us; returns the lines before the answer, and the time in us.
pub fn advance(client: &mut Client<TcpStream>, span: u64) -> (Vec<String>, u64) {
    client.say(&format!("@{span:X}"));
    let mut lines = Vec::new();
    loop {
        let line = client.next().expect("an answer");
        match line.strip_prefix('@') {
            Some(time) => return (lines, u64::from_str_radix(time, 16).expect("a time")),
            None => lines.push(line),
        }
    }
}
