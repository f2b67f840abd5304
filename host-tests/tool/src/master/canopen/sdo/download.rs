//! The block download of an SDO client (CiA 301, 7.2.4.3.9).
//!
//! ```text
//!  request                                      answer
//!  C2h  index  sub  length                      A0h  index  sub  segments of a block
//!  n    seven bytes, n = 1 .. segments          A2h  last segment in order  segments of the next block
//!       80h + n for the last one of all
//!  C1h + 4 * unused bytes of the last one       A1h
//! ```

use super::{Answer, SAVED, Server, aborted, header};
use crate::error::Error;
use crate::link::{Link, stopped};
use adapter::AdapterError;
use plumbline::can::{CanId, Frame};
use plumbline::canopen::Abort;
use plumbline::time::{Duration, after, millis};

/// The bytes in a segment.
const SEGMENT: usize = 7;

/// The time that an adapter with a full queue gets.
const PAUSE: Duration = millis(1);

/// The number of times a block is sent.
const TRIES: u8 = 5;

impl Server {
    /// Writes an object by blocks, or in segments if the server has no block transfer. `progress` gets the number of bytes that have
    /// arrived.
    ///
    /// # Errors
    /// The adapter fails, or the user wants to stop.
    pub fn download(
        self,
        link: &mut Link,
        (index, sub): (u16, u8),
        data: &[u8],
        progress: &mut dyn FnMut(usize),
    ) -> Result<Answer<()>, Error> {
        const UNKNOWN_COMMAND: u32 = Abort::Command as u32;
        let mut request = header(0xC2, index, sub);
        request[4..].copy_from_slice(&(data.len() as u32).to_le_bytes());
        let Some(answer) = self.initiate(link, request)? else {
            return Ok(Answer::Silent);
        };
        match aborted(&answer) {
            Some(UNKNOWN_COMMAND) => return self.patient().write(link, index, sub, data),
            Some(code) => return Ok(Answer::Aborted(code)),
            None => {}
        }
        if answer[0] & 0xE3 != 0xA0 {
            return self.abort(link, index, sub);
        }
        let segments: Vec<&[u8]> = data.chunks(SEGMENT).collect();
        let (mut done, mut size, mut tries) = (0, usize::from(answer[4]), TRIES);
        while done < segments.len() {
            if !(1..=127).contains(&size) || tries == 0 {
                return self.abort(link, index, sub);
            }
            let block = &segments[done..segments.len().min(done + size)];
            let ends = done + block.len() == segments.len();
            let Some(answer) = self.block(link, block, ends)? else {
                return Ok(Answer::Silent);
            };
            if let Some(code) = aborted(&answer) {
                return Ok(Answer::Aborted(code));
            }
            let [0xA2, arrived, next, ..] = answer else {
                return self.abort(link, index, sub);
            };
            let arrived = usize::from(arrived);
            if arrived > block.len() {
                return self.abort(link, index, sub);
            }
            tries = if arrived == 0 { tries - 1 } else { TRIES };
            done += arrived;
            size = usize::from(next);
            progress(data.len().min(done * SEGMENT));
        }
        let unused = segments.last().map_or(0, |last| SEGMENT - last.len());
        let end = [0xC1 | (unused as u8) << 2, 0, 0, 0, 0, 0, 0, 0];
        let is_end = |answer: &[u8; 8]| matches!(answer[0], 0x80 | 0xA1);
        let Some(answer) = self.patient().ask(link, end, is_end)? else {
            return Ok(Answer::Silent);
        };
        Ok(match aborted(&answer) {
            Some(code) => Answer::Aborted(code),
            None => Answer::Done(()),
        })
    }

    /// Sends a block, and returns its answer.
    fn block(
        self,
        link: &mut Link,
        segments: &[&[u8]],
        ends: bool,
    ) -> Result<Option<[u8; 8]>, Error> {
        if link.is_stopped() {
            return Err(stopped());
        }
        let (id, is_answer) = self.identifiers(link)?;
        for (number, segment) in (1..).zip(segments) {
            let is_last = ends && usize::from(number) == segments.len();
            let mut bytes = [0; 8];
            bytes[0] = number | u8::from(is_last) << 7;
            bytes[1..=segment.len()].copy_from_slice(segment);
            send(link, id, bytes)?;
        }
        link.wait_for(SAVED, |frame| {
            let bytes = frame.bytes().try_into().ok();
            bytes.filter(|bytes: &[u8; 8]| is_answer(frame) && matches!(bytes[0], 0x80 | 0xA2))
        })
    }
}

/// Sends a segment. An adapter whose queue is full gets time to send the frames in it.
fn send(link: &mut Link, id: CanId, bytes: [u8; 8]) -> Result<(), Error> {
    let until = after(link.now(), SAVED);
    loop {
        match link.send(&Frame::of(id, bytes, 8)) {
            Err(Error::Adapter(AdapterError::QueueFull | AdapterError::FrameRefused(_)))
                if link.now() < until =>
            {
                let pause = after(link.now(), PAUSE);
                link.receive(pause)?;
            }
            sent => return sent,
        }
    }
}
