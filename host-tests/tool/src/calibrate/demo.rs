//! The log of a virtual unit, for the demonstration of the page: it turns to the position that is asked for, and rests there.

use super::log::{Message, Sample};
use host_tests::calibrate::Side;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

/// The serial number of the unit.
const SERIAL: u32 = 1;

/// The time until it begins to turn, and the time of the motion, in s.
const WAIT: f64 = 1.5;
const MOTION: f64 = 1.5;

/// The pause between two samples.
const PERIOD: Duration = Duration::from_millis(5);

/// The offset of its accelerometer in g.
const OFFSET: [f64; 3] = [0.012, -0.021, 0.034];

/// The noise of each acceleration in g.
const NOISE: f64 = 0.001;

/// The attitude of the unit.
#[derive(Clone, Copy, Debug)]
struct Attitude {
    /// The acceleration before and after the motion, in g.
    from: [f64; 3],
    to: [f64; 3],
    /// The time at which it was asked to turn, in s.
    asked: f64,
}

impl Attitude {
    fn turn(&mut self, side: Side, time: f64) {
        let sign = if side.up { 1.0 } else { -1.0 };
        self.from = self.to;
        self.to = std::array::from_fn(|axis| if axis == side.axis { sign } else { 0.0 });
        self.asked = time;
    }

    fn sample(&self, time: f64, count: u32) -> Sample {
        let passed = ((time - self.asked - WAIT) / MOTION).clamp(0.0, 1.0);
        let noise = if count.is_multiple_of(2) {
            NOISE
        } else {
            -NOISE
        };
        let (from, to) = (self.from, self.to);
        let acceleration = std::array::from_fn(|axis| {
            from[axis] * (1.0 - passed) + to[axis] * passed + OFFSET[axis] + noise
        });
        Sample {
            acceleration,
            rate: [0.0; 3],
            temperature: 25.0,
        }
    }
}

/// The channel that turns the unit, and the channel with its messages. The messages end when the receiver is dropped.
pub fn start() -> (Sender<Side>, Receiver<Message>) {
    let (turn, turns) = channel();
    let (sender, messages) = channel();
    thread::spawn(move || {
        let start = Instant::now();
        let level = [0.0, 0.0, 1.0];
        let mut attitude = Attitude {
            from: level,
            to: level,
            asked: 0.0,
        };
        let (mut next, mut count) = (Message::Serial(SERIAL), 0);
        while sender.send(next).is_ok() {
            thread::sleep((start + PERIOD * count).saturating_duration_since(Instant::now()));
            let time = start.elapsed().as_secs_f64();
            if let Ok(side) = turns.try_recv() {
                attitude.turn(side, time);
            }
            count += 1;
            next = Message::Sample(attitude.sample(time, count));
        }
    });
    (turn, messages)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::rest::{WINDOW, Window};

    #[test]
    fn unit_turns_to_each_side_and_rests_there() {
        let mut attitude = Attitude {
            from: [0.0; 3],
            to: [0.0, 0.0, 1.0],
            asked: 0.0,
        };
        for (axis, up) in [
            (2, true),
            (2, false),
            (0, true),
            (0, false),
            (1, true),
            (1, false),
        ] {
            let side = Side { axis, up };
            attitude.turn(side, 10.0);
            let average = |from: f64| {
                let mut window = Window::default();
                for count in 0..WINDOW as u32 {
                    window.push(attitude.sample(from + f64::from(count) * 0.005, count));
                }
                window.average().expect("a measurement")
            };
            let moving = average(10.0);
            assert!(
                attitude.from == attitude.to || !moving.is_at_rest(),
                "{side}: {moving}"
            );
            let still = average(10.0 + WAIT + MOTION);
            assert!(
                still.is_at_rest() && still.side() == Some(side),
                "{side}: {still}"
            );
        }
    }
}
