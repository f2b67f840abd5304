//! A readable comparison of the frames of a sensor with those of a trace.

use super::{Trace, What};
use plumbline::can::{Frame, Id};
use plumbline::time::Instant;
use std::fmt;

/// Number of lines shown before and after a line that differs.
const CONTEXT: usize = 2;

/// The cost of each kind of difference. The alignment with the lowest total cost is shown.
mod cost {
    /// The same frame outside the tolerance.
    pub const OTHER_TIME: u32 = 3;
    /// Another frame at the right time.
    pub const OTHER_FRAME: u32 = 3;
    /// A frame on one side only. Two of these cost less than another frame at another time.
    pub const ONE_SIDED: u32 = 2;
}

/// A frame and its time.
type Timed = (Instant, Frame);

/// An expected frame: its line, and the tolerance of its time in us.
type Expected = (usize, Timed, u64);

/// The expected frames beside the received frames; at least one differs.
#[derive(Clone, PartialEq, Debug)]
pub struct Difference {
    rows: Vec<Row>,
}

/// One line of the comparison.
#[derive(Clone, PartialEq, Debug)]
struct Row {
    /// The line number in the trace.
    line: Option<usize>,
    /// A frame of the tester, which is not compared.
    sent: Option<Timed>,
    expected: Option<Timed>,
    received: Option<Timed>,
    verdict: Verdict,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Verdict {
    Same,
    Wrong,
    Missing,
    Extra,
    /// Delay in microseconds; negative: too early.
    Late(i64),
}

impl Difference {
    /// Compares the frames of the sensor; None if they match the trace.
    pub(super) fn between(trace: &Trace, received: &[Timed]) -> Option<Self> {
        let mut tolerance = trace.tolerance.ticks();
        let mut expected: Vec<Expected> = Vec::new();
        for step in &trace.steps {
            match step.what {
                What::Expect(at, frame) => expected.push((step.line, (at, frame), tolerance)),
                What::Tolerance(new) => tolerance = new.ticks(),
                _ => {}
            }
        }
        let rows = align(&expected, received, trace.noise);
        if rows.iter().all(|row| row.verdict == Verdict::Same) {
            return None;
        }
        Some(Self {
            rows: with_sent(trace, rows),
        })
    }

    /// The number of lines that differ.
    pub fn count(&self) -> usize {
        let differs = |row: &&Row| row.verdict != Verdict::Same;
        self.rows.iter().filter(differs).count()
    }
}

/// The microseconds from one time to another.
fn late(expected: Instant, received: Instant) -> i64 {
    received.ticks() as i64 - expected.ticks() as i64
}

fn judge(expected: Timed, received: Timed, tolerance: u64, noise: u16) -> (u32, Verdict) {
    let late = late(expected.0, received.0);
    let in_time = late.unsigned_abs() <= tolerance;
    match (is_same(&expected.1, &received.1, noise), in_time) {
        (true, true) => (0, Verdict::Same),
        (true, false) => (cost::OTHER_TIME, Verdict::Late(late)),
        (false, true) => (cost::OTHER_FRAME, Verdict::Wrong),
        (false, false) => (2 * cost::OTHER_FRAME, Verdict::Wrong),
    }
}

/// Whether two frames are the same, if the angular rates in them, and the angles from them, may differ by `noise`.
fn is_same(expected: &Frame, received: &Frame, noise: u16) -> bool {
    if expected == received {
        return true;
    }
    let same_form = expected.id() == received.id() && expected.dlc() == received.dlc();
    let (values, length) = noisy(expected);
    let near = |place: usize| {
        let [one, other] = [expected, received].map(|frame| {
            let bytes = frame.bytes().iter().skip(place * length).take(length);
            let signed = bytes
                .rev()
                .fold(0, |value, byte| value << 8 | i64::from(*byte));
            // Negative objects of 32 bits are near to 0.
            if length == 4 {
                i64::from(signed as i32)
            } else {
                signed
            }
        });
        one.abs_diff(other) <= noise.into()
    };
    let rest = |frame: &Frame| {
        let mut bytes = frame.bytes().to_vec();
        bytes.drain(values.start * length..values.end * length);
        bytes
    };
    same_form && values.clone().all(near) && rest(expected) == rest(received)
}

/// The places of the values of a frame of the IMS360 that come from angular rates, and their length in bytes: PGN F029h, F013h and F02Ah, and
/// the replies with the objects 3021h to 3023h.
fn noisy(frame: &Frame) -> (std::ops::Range<usize>, usize) {
    let group = match frame.id() {
        Id::Extended(id) => id.as_raw() >> 8 & 0xFFFF,
        Id::Standard(_) => 0,
    };
    match (group, frame.bytes()) {
        (0xF029, _) => (0..2, 3),
        (0xF013 | 0xF02A, _) => (0..3, 2),
        (_, [0x43, 0x21..=0x23, 0x30, ..]) => (1..2, 4),
        _ => (0..0, 1),
    }
}

/// Aligns the two sides with the lowest cost (edit distance).
fn align(expected: &[Expected], received: &[Timed], noise: u16) -> Vec<Row> {
    let width = received.len() + 1;
    // best[e * width + c]: the lowest cost of the frames after the first e and c frames.
    let mut best = vec![0; (expected.len() + 1) * width];
    for e in (0..=expected.len()).rev() {
        for c in (0..=received.len()).rev() {
            let one_sided = |at: usize| best[at] + cost::ONE_SIDED;
            let options = [
                (e < expected.len()).then(|| one_sided((e + 1) * width + c)),
                (c < received.len()).then(|| one_sided(e * width + c + 1)),
                (e < expected.len() && c < received.len()).then(|| {
                    let (_, timed, tolerance) = expected[e];
                    let (cost, _) = judge(timed, received[c], tolerance, noise);
                    best[(e + 1) * width + c + 1] + cost
                }),
            ];
            best[e * width + c] = options.into_iter().flatten().min().unwrap_or(0);
        }
    }
    let mut rows = Vec::new();
    let (mut e, mut c) = (0, 0);
    while e < expected.len() || c < received.len() {
        let here = best[e * width + c];
        let (left, right) = (expected.get(e).copied(), received.get(c).copied());
        if let (Some((line, left, tolerance)), Some(right)) = (left, right) {
            let (cost, verdict) = judge(left, right, tolerance, noise);
            if here == best[(e + 1) * width + c + 1] + cost {
                rows.push(Row::new(Some(line), Some(left), Some(right), verdict));
                (e, c) = (e + 1, c + 1);
                continue;
            }
        }
        if let Some((line, left, _)) = left
            && here == best[(e + 1) * width + c] + cost::ONE_SIDED
        {
            rows.push(Row::new(Some(line), Some(left), None, Verdict::Missing));
            e += 1;
        } else {
            rows.push(Row::new(None, None, right, Verdict::Extra));
            c += 1;
        }
    }
    rows
}

/// Inserts the frames of the tester between the rows, by time.
fn with_sent(trace: &Trace, rows: Vec<Row>) -> Vec<Row> {
    let mut sent = trace
        .steps
        .iter()
        .filter_map(|step| match step.what {
            What::Send(at, frame) => Some((step.line, (at, frame))),
            _ => None,
        })
        .peekable();
    let mut all = Vec::new();
    for row in rows {
        let at = row.expected.or(row.received).map(|(at, _)| at);
        while let Some((line, timed)) = sent.next_if(|(_, timed)| Some(timed.0) <= at) {
            all.push(Row {
                sent: Some(timed),
                ..Row::new(Some(line), None, None, Verdict::Same)
            });
        }
        all.push(row);
    }
    all
}

impl Row {
    fn new(
        line: Option<usize>,
        expected: Option<Timed>,
        received: Option<Timed>,
        verdict: Verdict,
    ) -> Self {
        Self {
            line,
            sent: None,
            expected,
            received,
            verdict,
        }
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "  line  {:<38}  received", "expected")?;
        let mut skipped = false;
        for (index, row) in self.rows.iter().enumerate() {
            let near = index.saturating_sub(CONTEXT)..(index + CONTEXT + 1).min(self.rows.len());
            let shown = self.rows[near]
                .iter()
                .any(|row| row.verdict != Verdict::Same);
            if shown {
                row.fmt(f)?;
            } else if !skipped {
                writeln!(f, "   ...")?;
            }
            skipped = !shown;
        }
        Ok(())
    }
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = self.line.map_or(String::new(), |line| line.to_string());
        if let Some(sent) = self.sent {
            return writeln!(f, "  {line:>4}  {} (sent)", text(Some(sent)).trim_end());
        }
        let mark = if self.verdict == Verdict::Same {
            ' '
        } else {
            '!'
        };
        let (expected, received) = (text(self.expected), text(self.received));
        let verdict = match self.verdict {
            Verdict::Same => String::new(),
            Verdict::Wrong => "wrong".to_owned(),
            Verdict::Missing => "missing".to_owned(),
            Verdict::Extra => "not expected".to_owned(),
            Verdict::Late(us) if us > 0 => format!("{us} us late"),
            Verdict::Late(us) => format!("{} us early", -us),
        };
        let row = format!("{mark} {line:>4}  {expected:<38}  {received:<38}  {verdict}");
        writeln!(f, "{}", row.trim_end())
    }
}

/// A frame with its time, as candump writes it: `0.100672 301#FF03000300004403`.
fn text(timed: Option<Timed>) -> String {
    timed.map_or("-".to_owned(), |(at, frame)| {
        let us = at.ticks();
        format!("{:>4}.{:06} {frame:?}", us / 1_000_000, us % 1_000_000)
    })
}
