//! Tests of the protocol against ISO 11898-1, on a small wire.

mod errors;
mod frames;
mod sharing;

use super::*;
use plumbline::can::standard;
use std::collections::VecDeque;

/// The length of a bit at 250 kbit/s.
const BIT: Picoseconds = 4_000_000;

/// The bits that a controller needs to join.
const JOIN: Picoseconds = 11;

#[derive(Default)]
struct Station {
    protocol: Protocol,
    queue: VecDeque<Frame>,
    events: Vec<(Picoseconds, Event)>,
}

/// Controllers on a wire, which the test can force to a level.
#[derive(Default)]
struct Wire {
    stations: Vec<Station>,
    dominant: bool,
    /// Levels that the test forces: start, end, dominant.
    forced: Vec<(Picoseconds, Picoseconds, bool)>,
    /// The time of each change of level.
    changes: Vec<(Picoseconds, bool)>,
    now: Picoseconds,
}

impl Wire {
    /// A wire with this number of controllers at 250 kbit/s, all of which have just joined.
    fn joined(count: usize) -> Self {
        let mut wire = Self::default();
        for _ in 0..count {
            wire.add(BitTiming::of(BitRate::K250), false);
        }
        wire.run(JOIN * BIT);
        wire.forget();
        wire
    }

    fn add(&mut self, timing: BitTiming, silent: bool) -> usize {
        let mut station = Station::default();
        station.protocol.join(self.now, timing, silent);
        self.stations.push(station);
        self.stations.len() - 1
    }

    fn send(&mut self, station: usize, frame: Frame) {
        self.stations[station].queue.push_back(frame);
    }

    /// Forces the wire to a level for `count` bits, starting at bit `first` from now.
    fn force(&mut self, first: u64, count: u64, dominant: bool) {
        let from = self.now + first * BIT;
        self.forced.push((from, from + count * BIT, dominant));
    }

    fn forget(&mut self) {
        self.changes.clear();
        self.stations.iter_mut().for_each(|s| s.events.clear());
    }

    fn next(&self) -> Option<Picoseconds> {
        let forced = self.forced.iter().flat_map(|(from, to, _)| [*from, *to]);
        let stations = self
            .stations
            .iter()
            .filter_map(|s| s.protocol.next_event(!s.queue.is_empty()))
            .map(|at| at.max(self.now));
        stations.chain(forced.filter(|at| *at > self.now)).min()
    }

    fn run(&mut self, time: Picoseconds) {
        let end = self.now + time;
        self.settle();
        while let Some(at) = self.next().filter(|at| *at < end) {
            self.now = at;
            for station in &mut self.stations {
                let offered = station.queue.front().copied();
                let due = station.protocol.next_event(offered.is_some());
                if due.is_none_or(|due| due > at) {
                    continue;
                }
                if let Some(event) = station.protocol.step(at, self.dominant, offered) {
                    if event == Event::Transmitted {
                        station.queue.pop_front();
                    }
                    station.events.push((at, event));
                }
            }
            self.settle();
        }
        self.now = end;
    }

    fn settle(&mut self) {
        let now = self.now;
        let forced = self
            .forced
            .iter()
            .find(|(from, to, _)| *from <= now && now < *to);
        let dominant = match forced {
            Some((_, _, level)) => *level,
            None => self.stations.iter().any(|s| s.protocol.is_dominant()),
        };
        if dominant == self.dominant {
            return;
        }
        self.dominant = dominant;
        self.changes.push((now, dominant));
        if dominant {
            self.stations.iter_mut().for_each(|s| s.protocol.edge(now));
        }
    }

    /// The levels on the wire for `count` bits starting at `from`, as the standard writes them: dominant is 0.
    fn bits(&self, from: Picoseconds, count: u64) -> String {
        let level = |at: Picoseconds| {
            let before = self.changes.iter().rev().find(|(time, _)| *time <= at);
            before.is_some_and(|(_, dominant)| *dominant)
        };
        (0..count)
            .map(|bit| {
                if level(from + bit * BIT + BIT / 2) {
                    '0'
                } else {
                    '1'
                }
            })
            .collect()
    }

    fn counters(&self, station: usize) -> (u16, u16) {
        let protocol = &self.stations[station].protocol;
        (protocol.transmit_errors(), protocol.receive_errors())
    }

    fn state(&self, station: usize) -> BusState {
        self.stations[station].protocol.state()
    }

    fn events(&self, station: usize) -> Vec<Event> {
        self.stations[station]
            .events
            .iter()
            .map(|(_, event)| *event)
            .collect()
    }

    fn received(&self, station: usize) -> Vec<Frame> {
        let frame = |event| match event {
            Event::Received(frame) => Some(frame),
            _ => None,
        };
        self.events(station).into_iter().filter_map(frame).collect()
    }

    /// The first error that a controller has seen.
    fn error(&self, station: usize) -> Option<(ErrorCode, bool)> {
        self.events(station)
            .into_iter()
            .find_map(|event| match event {
                Event::Error { code, transmitting } => Some((code, transmitting)),
                _ => None,
            })
    }

    fn count(&self, station: usize, event: Event) -> usize {
        self.events(station)
            .into_iter()
            .filter(|one| *one == event)
            .count()
    }
}

fn data(id: u16, bytes: &[u8]) -> Frame {
    Frame::data(standard(id), bytes).unwrap()
}
