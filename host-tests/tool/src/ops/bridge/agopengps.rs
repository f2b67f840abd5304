//! The roll for AgOpenGPS over UDP.
//!
//! The messages are those of `FormGPS.ReceiveFromAgIO` (AgOpenGPS-Official/AgOpenGPS, `SourceCode/GPS/Forms/UDPComm.Designer.cs`, commit
//! 06a720be) and of `imuClose` in AgIO (`FormLoop`). All begin with 80h 81h, the source, the PGN and the length of the data, and end with the
//! sum of all bytes from the source on. Numbers are little endian.
//!
//! - PGN 211: heading, roll (both in 0.1 deg), angular velocity. It has no number for an unknown heading.
//! - PGN 212: the first byte is 1 if there is no heading and roll any more.
//! - PGN 253 of a steering module: steering angle, heading (9999: unknown), roll (8888: unknown), switches, power.

use crate::cli::bridge::Module;
use crate::error::{BrokerError, Error};
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};

/// The values of PGN 253 for no heading and for no roll.
const NO_HEADING: i16 = 9999;
const NO_ROLL: i16 = 8888;

/// The switches of a steering module that are open: work, steering.
const SWITCHES: u8 = 0b11;

/// The end of heading and roll.
const CLOSE: (u8, u8, [u8; 2]) = (0x7C, 212, [1, 0]);

/// The messages for a roll in degrees; None: the sensor has no valid roll, or does not answer.
pub fn messages(module: Module, roll: Option<f64>) -> Vec<Vec<u8>> {
    // Larger angles do not exist, and would be other numbers.
    let roll = roll.filter(|roll| roll.abs() <= 360.0);
    let tenths = roll.map(|roll| (roll * 10.0).round() as i16);
    match (module, tenths) {
        (_, None) => {
            let (source, pgn, data) = CLOSE;
            let mut all = vec![message(source, pgn, &data)];
            if module == Module::Steer {
                all.push(steer(NO_ROLL));
            }
            all
        }
        (Module::Imu, Some(roll)) => {
            let [low, high] = roll.to_le_bytes();
            vec![message(0x79, 211, &[0, 0, low, high, 0, 0, 0, 0])]
        }
        (Module::Steer, Some(roll)) => vec![steer(roll)],
    }
}

fn steer(roll: i16) -> Vec<u8> {
    let ([h0, h1], [low, high]) = (NO_HEADING.to_le_bytes(), roll.to_le_bytes());
    message(0x7E, 253, &[0, 0, h0, h1, low, high, SWITCHES, 0])
}

fn message(source: u8, pgn: u8, data: &[u8]) -> Vec<u8> {
    let mut message = vec![0x80, 0x81, source, pgn, data.len() as u8];
    message.extend(data);
    let sum = message[2..]
        .iter()
        .fold(0, |sum: u8, byte| sum.wrapping_add(*byte));
    message.push(sum);
    message
}

/// The socket for these messages.
pub struct AgOpenGps {
    socket: UdpSocket,
    to: SocketAddr,
    module: Module,
    /// The reason why the last message was not sent, which the user knows.
    failed: Option<String>,
}

impl AgOpenGps {
    /// A socket for messages to this address.
    ///
    /// # Errors
    /// The computer has none.
    pub fn new(to: SocketAddr, module: Module) -> Result<Self, Error> {
        let own: SocketAddr = match to {
            SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
            SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
        };
        let socket = UdpSocket::bind(own).and_then(|socket| {
            socket.set_broadcast(true)?;
            Ok(socket)
        });
        let socket = socket.map_err(|error| BrokerError::Socket(to.to_string(), error.to_string()));
        Ok(Self {
            socket: socket?,
            to,
            module,
            failed: None,
        })
    }

    /// Sends a roll. The cable can come back, so a failure ends nothing; the user is told each reason once.
    pub fn send(&mut self, roll: Option<f64>) -> Option<Error> {
        for message in messages(self.module, roll) {
            let reason = self
                .socket
                .send_to(&message, self.to)
                .err()
                .map(|own| own.to_string());
            if reason != self.failed {
                self.failed.clone_from(&reason);
                if let Some(reason) = reason {
                    return Some(BrokerError::Socket(self.to.to_string(), reason).into());
                }
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roll_is_sent_in_tenths_of_a_degree() {
        for (module, roll, bytes) in [
            (
                Module::Imu,
                0.0,
                "80 81 79 D3 08 00 00 00 00 00 00 00 00 54",
            ),
            (
                Module::Imu,
                12.34,
                "80 81 79 D3 08 00 00 7B 00 00 00 00 00 CF",
            ),
            (
                Module::Imu,
                -5.67,
                "80 81 79 D3 08 00 00 C7 FF 00 00 00 00 1A",
            ),
            (
                Module::Steer,
                -5.67,
                "80 81 7E FD 08 00 00 0F 27 C7 FF 03 00 82",
            ),
        ] {
            assert_eq!(shown(module, Some(roll)), [bytes], "{roll}");
        }
    }

    #[test]
    fn sensor_without_a_valid_roll_is_no_level_tractor() {
        const CLOSED: &str = "80 81 7C D4 02 01 00 53";
        const UNKNOWN: &str = "80 81 7E FD 08 00 00 0F 27 B8 22 03 00 96";
        for roll in [None, Some(f64::NAN), Some(360.1), Some(-4000.0)] {
            assert_eq!(shown(Module::Imu, roll), [CLOSED], "{roll:?}");
            assert_eq!(shown(Module::Steer, roll), [CLOSED, UNKNOWN], "{roll:?}");
        }
    }

    fn shown(module: Module, roll: Option<f64>) -> Vec<String> {
        let all = messages(module, roll).into_iter();
        all.map(|own| {
            own.iter()
                .map(|byte| format!("{byte:02X}"))
                .collect::<Vec<_>>()
                .join(" ")
        })
        .collect()
    }
}
