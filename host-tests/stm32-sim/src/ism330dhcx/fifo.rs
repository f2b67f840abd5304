//! The FIFO of the ISM330DHCX in bypass, FIFO and continuous mode, without compression and timestamps.
//!
//! A word is a tag and six data bytes. The tag has the sensor in bits 3 to 7, a counter in bits 1 and 2 and an even parity in bit
//! 0 (AN5398, "FIFO").

use std::collections::VecDeque;

/// The number of words (datasheet: 3 kbyte of data).
const CAPACITY: usize = 512;

/// The sensor of a word.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Sensor {
    Gyroscope = 1,
    Accelerometer = 2,
    Thermometer = 3,
}

/// The batch data rate of the temperature, by ODR_T_BATCH, as divisor of the rate of the thermometer: off, 1.6, 12.5 and 52 Hz.
const TEMPERATURE_DIVISORS: [u64; 4] = [0, 32, 4, 1];

#[derive(Clone, Debug, Default)]
pub(super) struct Fifo {
    words: VecDeque<[u8; 7]>,
    /// FIFO_CTRL3: batch data rates of gyroscope and accelerometer.
    rates: u8,
    /// FIFO_CTRL4: mode, and batch data rate of the temperature.
    control: u8,
    /// The number of the batch, for the counter in the tag, and the sensors in it. The words of a batch have the same number.
    batch: u8,
    batched: [bool; 2],
    overrun: bool,
}

impl Fifo {
    /// FIFO_CTRL3 and FIFO_CTRL4. Returns false if a setting is not modelled.
    pub(super) fn set_up(&mut self, rates: u8, control: u8) -> bool {
        self.rates = rates;
        self.control = control;
        if control & 0b111 == 0 {
            self.words.clear();
            self.overrun = false;
        }
        let timestamps = control & 0b1100_0000;
        matches!(control & 0b111, 0 | 1 | 6) && timestamps == 0
    }

    /// Whether the batch data rates are those at which the sensors run, or off; other ratios are not modelled.
    pub(super) fn matches(&self, accelerometer: u8, gyroscope: u8) -> bool {
        let matches = |batch: u8, rate: u8| batch == 0 || rate == 0 || batch == rate;
        matches(self.rates & 0x0F, accelerometer >> 4) && matches(self.rates >> 4, gyroscope >> 4)
    }

    /// A new sample of a sensor; `number` counts its samples.
    pub(super) fn push(&mut self, sensor: Sensor, number: u64, counts: [i16; 3]) {
        let batched = match sensor {
            Sensor::Gyroscope => self.rates >> 4 != 0,
            Sensor::Accelerometer => self.rates & 0x0F != 0,
            Sensor::Thermometer => {
                let divisor = TEMPERATURE_DIVISORS[usize::from(self.control >> 4 & 0b11)];
                divisor != 0 && number.is_multiple_of(divisor)
            }
        };
        let mode = self.control & 0b111;
        if !batched || mode == 0 {
            return;
        }
        if self.words.len() == CAPACITY {
            self.overrun = true;
            if mode == 1 {
                return;
            }
            self.words.pop_front();
        }
        let place = match sensor {
            Sensor::Gyroscope => Some(0),
            Sensor::Accelerometer => Some(1),
            Sensor::Thermometer => None,
        };
        if let Some(place) = place {
            if self.batched[place] || self.batched == [false; 2] {
                self.batch = (self.batch + 1) & 0b11;
                self.batched = [false; 2];
            }
            self.batched[place] = true;
        }
        let tag = (sensor as u8) << 3 | self.batch << 1;
        let parity = (tag.count_ones() & 1) as u8;
        let [x, y, z] = counts.map(i16::to_le_bytes);
        self.words
            .push_back([tag | parity, x[0], x[1], y[0], y[1], z[0], z[1]]);
    }

    /// Loses the oldest words.
    pub(super) fn lose(&mut self, words: usize) {
        self.words.drain(..words.min(self.words.len()));
    }

    /// FIFO_STATUS1 and FIFO_STATUS2.
    pub(super) fn status(&self) -> [u8; 2] {
        let words = self.words.len() as u16;
        let full = u8::from(self.words.len() == CAPACITY) << 5;
        let overrun = u8::from(self.overrun) << 6 | u8::from(self.overrun) << 3;
        let [low, high] = words.to_le_bytes();
        [low, high | full | overrun]
    }

    /// Reads byte 0 (the tag) to 6 of the oldest word; 0 if there is none. After byte 6 the word is removed.
    pub(super) fn read(&mut self, byte: u8) -> u8 {
        let value = self.words.front().map_or(0, |word| word[usize::from(byte)]);
        if byte == 6 {
            self.words.pop_front();
            self.overrun = false;
        }
        value
    }
}
