//! The log of a board, as a command prints it:
//!
//! ```text
//! 0.000010 [INFO ] measuring element adxl355 (firmware_stm32 ..)
//! 0.000012 [INFO ] serial number 305419896 (firmware_stm32 ..)
//! 0.062500 [DEBUG] acceleration 1234 -567 998765 ug, 2510 0.01 degC, rate 310 -20 5 mdps (firmware_stm32 ..)
//! ```
//!
//! The rate of a sensor without a gyroscope is 0. An older firmware prints neither it nor the measuring element, which is an ISM330DHCX.

use super::demo;
use crate::error::{CalibrationError, Error};
use host_tests::calibrate::Side;
use plumbline::calibration_line;
use plumbline::measure::calibration::Part;
use std::fmt::{self, Display, Formatter};
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

/// A raw acceleration and angular rate.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Sample {
    /// The acceleration in g.
    pub acceleration: [f64; 3],
    /// In deg/s; 0 without a gyroscope.
    pub rate: [f64; 3],
    /// The temperature in degC.
    pub temperature: f64,
}

/// A message that a calibration needs.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Message {
    /// The measuring element of the unit, at its start; None: one that this program does not know.
    Element(Option<Part>),
    /// The serial number of the unit, at its start.
    Serial(u32),
    /// A reading, one every 5 ms.
    Sample(Sample),
}

/// The formats of the lines, which the firmware has from the same place.
const ELEMENT: &str = calibration_line!(element, concat);
const SERIAL: &str = calibration_line!(serial, concat);
const READING: &str = calibration_line!(reading, concat);

/// A reading of the firmware before it had the angular rate.
const OLDER_READING: &str = "acceleration {=i32} {=i32} {=i32} ug, {=i16} 0.01 degC";

/// The message in a line of the log; None: the line has another one.
pub fn message(line: &str) -> Option<Message> {
    if let Some([name]) = fields(line, ELEMENT) {
        let known = Part::ALL.iter().find(|part| part.name() == name);
        return Some(Message::Element(known.copied()));
    }
    if let Some([serial]) = fields(line, SERIAL) {
        return Some(Message::Serial(serial.parse().ok()?));
    }
    let [x, y, z, temperature, gx, gy, gz] = fields(line, READING).or_else(|| {
        let [x, y, z, temperature] = fields(line, OLDER_READING)?;
        Some([x, y, z, temperature, "0", "0", "0"])
    })?;
    let number = |text: &str, unit: f64| Some(f64::from(text.parse::<i32>().ok()?) * unit);
    Some(Message::Sample(Sample {
        acceleration: [number(x, 1e-6)?, number(y, 1e-6)?, number(z, 1e-6)?],
        rate: [number(gx, 1e-3)?, number(gy, 1e-3)?, number(gz, 1e-3)?],
        temperature: number(temperature, 0.01)?,
    }))
}

/// The values in a line of this format, which is somewhere in the line; None: it has another format.
fn fields<'a, const N: usize>(line: &'a str, format: &str) -> Option<[&'a str; N]> {
    let mut parts = format.split("{=").map(|part| match part.split_once('}') {
        Some((_, text)) => text,
        None => part,
    });
    let (_, mut rest) = line.split_once(parts.next()?)?;
    let mut values = [""; N];
    for (value, text) in values.iter_mut().zip(parts) {
        let end = rest.find([' ', ',', '\r']).unwrap_or(rest.len());
        let (own, behind) = rest.split_at(end);
        rest = behind.strip_prefix(text)?;
        *value = own;
    }
    values
        .iter()
        .all(|value| !value.is_empty())
        .then_some(values)
}

/// Where the log comes from.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Source {
    /// A command that prints it.
    Command(Vec<String>),
    /// A virtual unit inside of the program.
    Demonstration,
}

impl Display for Source {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Command(words) => f.write_str(&words.join(" ")),
            Self::Demonstration => f.write_str("the demonstration"),
        }
    }
}

/// The log. A command that prints it ends with this.
pub struct Log {
    child: Option<Child>,
    /// Where the unit of the demonstration turns.
    turn: Option<Sender<Side>>,
    messages: Receiver<Message>,
}

impl Log {
    /// Starts the source. Images that it builds have a log with debug messages.
    ///
    /// # Errors
    /// It cannot be started.
    pub fn start(source: &Source) -> Result<Self, Error> {
        match source {
            Source::Command(words) => Self::command(words),
            Source::Demonstration => {
                let (turn, messages) = demo::start();
                Ok(Self {
                    child: None,
                    turn: Some(turn),
                    messages,
                })
            }
        }
    }

    fn command(command: &[String]) -> Result<Self, Error> {
        let shown = || command.join(" ");
        let (program, arguments) = command
            .split_first()
            .ok_or_else(|| CalibrationError::NoCommand(shown()))?;
        let mut child = Command::new(program)
            .args(arguments)
            .env("DEFMT_LOG", "debug")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| CalibrationError::LogUnstarted(shown(), error.to_string()))?;
        let output = child.stdout.take();
        let output = output.ok_or_else(|| CalibrationError::NoOutput(shown()))?;
        let (sender, messages) = channel();
        thread::spawn(move || {
            for line in lines(output) {
                if let Some(message) = message(&line)
                    && sender.send(message).is_err()
                {
                    break;
                }
            }
        });
        Ok(Self {
            child: Some(child),
            turn: None,
            messages,
        })
    }

    /// The next message; None: there is none in this time.
    ///
    /// # Errors
    /// The command has ended.
    pub fn next(&mut self, time: Duration) -> Result<Option<Message>, Error> {
        match self.messages.recv_timeout(time) {
            Ok(message) => Ok(Some(message)),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => Err(CalibrationError::LogEnded.into()),
        }
    }

    /// Turns the unit of the demonstration. The user turns a real one.
    pub fn turn(&mut self, side: Side) {
        if let Some(turn) = &self.turn {
            let _ = turn.send(side);
        }
    }

    /// Drops the samples that wait, and returns the other messages among them.
    pub fn drop_waiting(&mut self) -> Vec<Message> {
        let messages = self.messages.try_iter();
        let is_other = |message: &Message| !matches!(message, Message::Sample(_));
        messages.filter(is_other).collect()
    }
}

/// The lines of an output, also if they are not UTF-8. In UTF-16, which some shells write, each letter of ASCII has a zero beside it.
fn lines(output: impl Read) -> impl Iterator<Item = String> {
    let lines = BufReader::new(output).split(b'\n').map_while(Result::ok);
    lines.map(|mut line| {
        line.retain(|byte| *byte != 0);
        String::from_utf8_lossy(&line).into_owned()
    })
}

impl Drop for Log {
    fn drop(&mut self) {
        if let Some(child) = &mut self.child {
            // It can have ended by itself.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn acceleration_and_serial_number_are_found_in_a_line_of_the_log() {
        let sample = Sample {
            acceleration: [0.001234, -0.000567, 0.998765],
            rate: [0.31, -0.02, 0.005],
            temperature: 25.1,
        };
        for end in ["", "\r", " (firmware_stm32 firmware-stm32/src/app.rs:330)"] {
            let older = "0.0625 [DEBUG] acceleration 1234 -567 998765 ug, 2510 0.01 degC";
            let Some(Message::Sample(found)) = message(&format!("{older}{end}")) else {
                panic!("{older}{end}");
            };
            assert_eq!(found.rate, [0.0; 3]);
            let line = format!("{older}, rate 310 -20 5 mdps{end}");
            let Some(Message::Sample(found)) = message(&line) else {
                panic!("{line}");
            };
            let numbers = found.acceleration.iter().chain(&found.rate);
            let expected = sample.acceleration.into_iter().chain(sample.rate);
            for (found, expected) in numbers.zip(expected) {
                assert!((found - expected).abs() < 1e-9, "{line}");
            }
            assert!((found.temperature - sample.temperature).abs() < 1e-9);
            let line = format!("0.000012 [INFO ] serial number 4294967295{end}");
            assert_eq!(message(&line), Some(Message::Serial(u32::MAX)));
            for (name, part) in [("adxl355", Some(Part::Adxl355)), ("other", None)] {
                let line = format!("0.000010 [INFO ] measuring element {name}{end}");
                assert_eq!(message(&line), Some(Message::Element(part)));
            }
        }
    }

    #[test]
    fn log_in_utf_16_has_the_same_messages() {
        let text = "\u{FEFF}0.0 [INFO ] serial number 7\r\n0.1 [INFO ] serial number 8\r\n";
        for unit in [u16::to_le_bytes, u16::to_be_bytes] {
            let bytes: Vec<u8> = text.encode_utf16().flat_map(unit).collect();
            let messages: Vec<Message> = lines(&bytes[..])
                .filter_map(|line| message(&line))
                .collect();
            assert_eq!(messages, [Message::Serial(7), Message::Serial(8)]);
        }
    }

    /// A line that the firmware writes with these values.
    fn written(format: &str, values: &[&str]) -> String {
        let mut parts = format.split("{=");
        let mut line = format!("0.0625 [DEBUG] {}", parts.next().unwrap_or_default());
        for (part, value) in parts.zip(values) {
            let (_, text) = part.split_once('}').expect("a placeholder");
            line += &format!("{value}{text}");
        }
        line + " (firmware_stm32 firmware-stm32/src/app.rs:330)"
    }

    #[test]
    fn every_line_that_the_firmware_writes_is_read() {
        let element = written(ELEMENT, &["adxl355"]);
        let known = Message::Element(Some(Part::Adxl355));
        assert_eq!(message(&element), Some(known), "{element}");
        let serial = written(SERIAL, &["42"]);
        assert_eq!(message(&serial), Some(Message::Serial(42)), "{serial}");
        let reading = written(
            READING,
            &["1000000", "0", "-2000000", "2510", "1", "2", "-3"],
        );
        let Some(Message::Sample(sample)) = message(&reading) else {
            panic!("{reading}");
        };
        assert_eq!(sample.acceleration, [1.0, 0.0, -2.0]);
        assert_eq!(sample.rate, [0.001, 0.002, -0.003]);
    }

    #[test]
    fn other_lines_have_no_message() {
        for line in [
            "",
            "[INFO ] accelerometer found",
            "acceleration",
            "acceleration 1 2",
            "acceleration 1 2 3 ug,",
            "acceleration 1 2 3 mg, 2510 0.01 degC",
            "acceleration 1 2 99999999999 ug, 2510 0.01 degC",
            "serial number ",
            "serial number 4294967296",
        ] {
            assert_eq!(message(line), None, "{line}");
        }
    }
}
