//! An IMS360 with its factory settings: node-ID 50, 125 kbit/s.

use super::{Rig, blank, data};
use bench::BusRate;
use bench::motion::Motion;
use plumbline::can::BitRate;

/// CAN identifiers of node 50.
pub const EMCY: u16 = 0x0B2;
pub const TPDO1: u16 = 0x1B2;
const SDO_REPLY: u16 = 0x5B2;
const SDO_REQUEST: u16 = 0x632;
pub const HEARTBEAT: u16 = 0x732;

/// The longest time of an SDO reply in ms. That to a save can take longer.
const REPLY_TIME: u64 = 20;

impl Rig {
    /// A sensor with this motion that has sent its boot-up message. It is pre-operational.
    pub fn ims360(motion: Box<dyn Motion>) -> Self {
        Self::ims360_with(motion, 0.0)
    }

    /// As [`ims360`](Self::ims360), with this clock error of accelerometer and gyroscope in percent.
    pub fn ims360_with(motion: Box<dyn Motion>, clock: f64) -> Self {
        let mut rig = Self::with("ims360", BusRate::Fixed(BitRate::K125), blank());
        rig.set_motion(motion);
        rig.io().0.imu.set_clock_deviation(0, clock);
        assert_eq!(rig.expect(HEARTBEAT, 200), data(HEARTBEAT, &[0]));
        rig
    }

    pub fn set_motion(&mut self, motion: Box<dyn Motion>) {
        self.bus.device_mut(self.sensor).set_motion(motion);
    }

    /// Sends an NMT command to the sensor.
    pub fn nmt(&mut self, command: u8) {
        self.bus.send(self.tester, data(0x000, &[command, 50]));
    }

    /// Sends an SDO request. Returns the reply, which must come within `limit` ms.
    #[track_caller]
    fn sdo(&mut self, request: [u8; 8], limit: u64) -> [u8; 8] {
        self.bus.send(self.tester, data(SDO_REQUEST, &request));
        let reply = self.expect(SDO_REPLY, limit);
        assert_eq!(reply.bytes()[1..4], request[1..4], "{reply:?}");
        reply.bytes().try_into().expect("eight bytes")
    }

    /// Reads an object of at most four bytes.
    #[track_caller]
    pub fn upload(&mut self, index: u16, sub: u8) -> u32 {
        let [low, high] = index.to_le_bytes();
        let reply = self.sdo([0x40, low, high, sub, 0, 0, 0, 0], REPLY_TIME);
        let [0x43 | 0x47 | 0x4B | 0x4F, _, _, _, number @ ..] = reply else {
            panic!("{reply:02X?}")
        };
        u32::from_le_bytes(number)
    }

    /// Writes these bytes to an object.
    #[track_caller]
    pub fn download<const N: usize>(&mut self, index: u16, sub: u8, value: [u8; N]) {
        self.download_within(REPLY_TIME, index, sub, value);
    }

    /// As [`download`](Self::download), with another limit of the time in ms.
    #[track_caller]
    pub fn download_within<const N: usize>(
        &mut self,
        limit: u64,
        index: u16,
        sub: u8,
        value: [u8; N],
    ) {
        let [low, high] = index.to_le_bytes();
        let mut request = [0x2F - 4 * (N as u8 - 1), low, high, sub, 0, 0, 0, 0];
        request[4..4 + N].copy_from_slice(&value);
        let reply = self.sdo(request, limit);
        assert_eq!(reply, [0x60, low, high, sub, 0, 0, 0, 0], "{reply:02X?}");
    }
}
