//! The image of the JN2101.

use crate::rig::{blank, part, silicon};
use bench::motion::Motion;
use bench::script::LEVEL;
use bench::{AdapterId, Bus, BusRate, DeviceId, Sensor};
use can_wire::text::frame;
use plumbline::can::BitRate;
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::time::{Duration, after, millis};
use stm32_sim::{Microcontroller, bxcan};

/// In level position at rest, with this temperature in 0.01 degC.
fn level(temperature: i16) -> Box<Reading> {
    Box::new(Reading {
        temperature,
        ..LEVEL
    })
}

fn microcontroller(serial: u32, motion: Box<dyn Motion>) -> Microcontroller {
    part("jn2101", serial, blank(), motion)
}

/// A sensor and a tester on a bus with 125 kbit/s.
pub struct Bench {
    bus: Bus,
    sensor: DeviceId,
    tester: AdapterId,
}

impl Bench {
    /// A sensor after power-up and its boot-up message.
    fn new(motion: Box<dyn Motion>) -> Self {
        Self::of(microcontroller(1, motion))
    }

    /// This sensor after power-up and its boot-up message.
    pub fn of(sensor: Microcontroller) -> Self {
        let mut bus = Bus::new(BusRate::Fixed(BitRate::K125));
        let sensor = bus.attach(sensor);
        let tester = bus.adapter();
        bus.open(tester, None, false);
        let mut bench = Self {
            bus,
            sensor,
            tester,
        };
        assert_eq!(bench.wait(200), ["70A#00"]);
        bench
    }

    /// The frames that the sensor sends within this many milliseconds.
    pub fn wait(&mut self, ms: u32) -> Vec<String> {
        self.bus.run_until(after(self.bus.now(), millis(ms)));
        let frames = self.bus.take_received(self.tester).into_iter();
        frames.map(|(_, frame)| format!("{frame:?}")).collect()
    }

    /// Sends a frame; returns the frames received within 10 ms.
    pub fn exchange(&mut self, text: &str) -> Vec<String> {
        self.bus.send(self.tester, frame(text));
        self.wait(10)
    }

    fn chip(&self) -> &Microcontroller {
        Microcontroller::of(self.bus.device(self.sensor)).expect("a simulated microcontroller")
    }

    pub fn chip_mut(&mut self) -> &mut Microcontroller {
        Microcontroller::of_mut(self.bus.device_mut(self.sensor))
            .expect("a simulated microcontroller")
    }

    /// Reads a number from an object of at most four bytes.
    pub fn upload(&mut self, index: u16, sub: u8) -> u32 {
        let [low, high] = index.to_le_bytes();
        let replies = self.exchange(&format!("60A#40{low:02X}{high:02X}{sub:02X}00000000"));
        let [reply] = replies.as_slice() else {
            panic!("{replies:?}")
        };
        let bytes = frame(reply);
        let [_, _, _, _, data @ ..] = bytes.bytes() else {
            panic!("{reply}")
        };
        u32::from_le_bytes(data.try_into().expect("four bytes"))
    }

    /// Writes these bytes to an object.
    pub fn download<const N: usize>(&mut self, index: u16, sub: u8, value: [u8; N]) {
        let [low, high] = index.to_le_bytes();
        let command = 0x2F - 4 * (N as u8 - 1);
        let mut data = [0; 4];
        data[..N].copy_from_slice(&value);
        let data = u32::from_be_bytes(data);
        let request = format!("60A#{command:02X}{low:02X}{high:02X}{sub:02X}{data:08X}");
        let reply = format!("58A#60{low:02X}{high:02X}{sub:02X}00000000");
        let frames = self.exchange(&request);
        assert_eq!(frames.first(), Some(&reply), "{request}");
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            assert_eq!(self.chip().violations(), [""; 0]);
        }
    }
}

/// ISO 11898-1 permits these codes in data frames and remote frames.
#[test]
fn data_length_code_of_9_to_15_means_8_bytes() {
    let mut bench = Bench::new(level(25_00));
    for long_length in 9..=15 {
        bench.chip_mut().io_mut().can.set_silicon(bxcan::Silicon {
            long_length,
            ..silicon().can
        });
        let read = bench.exchange("60A#4001100000000000");
        assert_eq!(read, ["58A#4F01100000000000"], "{long_length}");
        let [guarded] = bench.exchange("70A#R8").try_into().expect("one answer");
        assert!(
            ["70A#7F", "70A#FF"].contains(&guarded.as_str()),
            "{guarded}"
        );
    }
}

/// Also if the receive interrupt reads the clock while the interrupt of the clock waits: the requests come at each us of its period.
#[test]
fn polled_tpdo_keeps_its_inhibit_time() {
    let mut bench = Bench::new(level(25_00));
    bench.download(0x1800, 2, [254]);
    bench.download(0x1800, 3, [40, 0]);
    bench.download(0x1800, 5, [0, 0]);
    bench.exchange("000#010A");
    let mut times = Vec::new();
    for _ in 0..1000 {
        for wait in [3_500, 6_501] {
            bench.bus.send(bench.tester, frame("18A#R"));
            let end = after(bench.bus.now(), Duration::micros(wait));
            bench.bus.run_until(end);
            let frames = bench.bus.take_received(bench.tester).into_iter();
            times.extend(frames.map(|(time, _)| time));
        }
    }
    assert_eq!(times.len(), 2000, "each request has an answer");
    let pairs = times
        .windows(2)
        .map(|pair| pair[1].ticks() - pair[0].ticks());
    assert_eq!(
        pairs.min().map(|least| least / 100),
        Some(40),
        "the shortest interval in 0.1 ms"
    );
}

/// The change of the filters discards what is still in the mailboxes of the controller.
#[test]
fn sensor_reset_is_answered_and_keeps_the_unsaved_node_id() {
    let mut bench = Bench::new(level(25_00));
    bench.download(0x2000, 0, [11]);
    bench.download(0x6000, 0, [100, 0]);
    bench.bus.send(bench.tester, frame("60A#2F02200001000000"));
    assert_eq!(bench.wait(300), ["58A#6002200000000000", "70B#00"]);
    assert_eq!(
        bench.exchange("60B#4000600000000000"),
        ["58B#4B0060000A000000"]
    );
    bench.bus.power_cycle(bench.sensor);
    assert_eq!(bench.wait(200), ["70A#00"]);
}

/// A reply that is sent before the CAN controller changes its filters is not lost. The sensor sends both replies one after the other, so
/// two mailboxes have a frame.
#[test]
pub fn sync_is_answered_with_both_tpdos() {
    let mut bench = Bench::new(level(2500));
    bench.exchange("000#010A");
    let own = silicon().can;
    for mailbox_code in [own.mailbox_code, Some(0), Some(1), Some(2), Some(3)] {
        let silicon = bxcan::Silicon {
            mailbox_code,
            ..own
        };
        bench.chip_mut().io_mut().can.set_silicon(silicon);
        for _ in 0..10 {
            let frames = bench.exchange("080#");
            let identifiers: Vec<_> = frames.iter().map(|frame| &frame[..3]).collect();
            assert_eq!(identifiers, ["18A", "28A"], "{mailbox_code:?}");
        }
    }
}

#[test]
fn new_sync_identifier_is_confirmed_and_in_force() {
    let mut bench = Bench::new(level(25_00));
    bench.exchange("000#010A");
    bench.download(0x1005, 0, 0x0A0_u32.to_le_bytes());
    assert_eq!(bench.exchange("080#"), [""; 0]);
    assert_eq!(bench.exchange("0A0#").len(), 2);
}

/// The boot-up message has a lower priority than the emergency message of the tilted sensor, which starts by itself (1F80h = 8).
#[test]
fn boot_up_message_is_the_first_frame_also_on_a_busy_bus() {
    let tilted = Reading {
        acceleration: I32x3 {
            x: -ONE_G / 8 * 7,
            y: 0,
            z: ONE_G / 2,
        },
        ..*level(25_00)
    };
    let mut bench = Bench::new(level(25_00));
    bench.download(0x1F80, 0, [8, 0, 0, 0]);
    bench.bus.send(bench.tester, frame("60A#2310100173617665"));
    bench.wait(200);
    let device = bench.bus.device_mut(bench.sensor);
    device.set_motion(Box::new(tilted));
    let rival = bench.bus.adapter();
    bench.bus.open(rival, None, false);
    for start in [0, 100, 230, 470] {
        bench.bus.power_cycle(bench.sensor);
        bench.wait(3);
        bench
            .bus
            .run_until(after(bench.bus.now(), Duration::from_ticks(start)));
        // Frames with a high priority, until the accelerometer has measured.
        for _ in 0..120 {
            bench.bus.send(rival, frame("001#0011223344556677"));
        }
        let frames = bench.wait(150);
        let own: Vec<_> = frames
            .iter()
            .filter(|text| !text.starts_with("001"))
            .collect();
        assert_eq!(own[0], "70A#00", "{own:?}");
        assert_eq!(own[1], "08A#0090010200000000");
    }
}

#[test]
fn self_test_reports_the_working_axes() {
    for (works, register) in [(true, 0b110), (false, 0)] {
        let mut bench = Bench::new(level(25_00));
        bench.chip_mut().io_mut().imu.set_self_test_works(works);
        bench.exchange("000#010A");
        bench.download(0x4004, 1, [1]);
        for _ in 0..7 {
            assert_eq!(bench.upload(0x4004, 1), 1, "the self-test runs");
            assert_eq!(
                bench.exchange("080#")[0],
                "18A#00000000",
                "the angle is held"
            );
            for object in ["4220", "4620"] {
                let refused = format!("58A#80{object}0022000008");
                let request = format!("60A#2F{object}0001000000");
                assert_eq!(bench.exchange(&request), [refused]);
            }
            bench.wait(200);
        }
        let emergencies = bench.wait(1000);
        assert_eq!(bench.upload(0x4004, 1), 0);
        assert_eq!(bench.upload(0x4004, 2), register);
        let none: [&str; 0] = [];
        if works {
            assert_eq!(emergencies, none);
        } else {
            assert_eq!(emergencies, ["08A#0010010100000000"]);
        }
        assert_eq!(
            bench.exchange("080#")[0],
            "18A#00000000",
            "the sensor measures again"
        );
        if works {
            let mut shaken = level(25_00);
            shaken.acceleration.z = 9 * ONE_G;
            bench.chip_mut().set_motion(shaken);
            let clipped = "08A#0010010100000000";
            assert_eq!(bench.wait(200), [clipped], "at +-8 g");
        }
    }
}

#[test]
fn self_test_fails_without_an_accelerometer() {
    let mut bench = Bench::new(level(25_00));
    bench.chip_mut().io_mut().imu.unmount();
    assert_eq!(bench.wait(500), ["08A#0010010100000000"]);
    bench.download(0x4004, 1, [1]);
    bench.wait(100);
    assert_eq!(bench.upload(0x4004, 1), 0);
    assert_eq!(bench.upload(0x4004, 2), 0);
}

#[test]
pub fn supply_below_its_limit_is_reported() {
    let mut bench = Bench::new(level(25_00));
    let at = |millivolts: u16| Box::new((*level(25_00), millivolts));
    bench.chip_mut().set_motion(at(7_500));
    assert_eq!(bench.wait(500), ["08A#0031051000000000"]);
    bench.chip_mut().set_motion(at(24_000));
    assert_eq!(bench.wait(500), ["08A#0000000000000000"]);
}

#[test]
pub fn terminating_resistor_is_switched_and_is_off_without_power() {
    let mut bench = Bench::new(level(25_00));
    assert!(bench.chip().terminated(), "on at the factory");
    bench.download(0x2045, 0, [0]);
    assert!(!bench.chip().terminated());
    bench.download(0x2045, 0, [1]);
    assert!(bench.chip().terminated());
    let now = bench.bus.now();
    bench.bus.device_mut(bench.sensor).power_off(now);
    assert!(!bench.chip().terminated());
}

#[test]
pub fn heating_power_depends_on_the_temperature() {
    let mut bench = Bench::new(level(20_00));
    bench.download(0x2041, 0, [1]);
    bench.wait(500);
    assert_eq!(bench.chip().heater(), 1000, "30 K below its set point");
    let clock = bench.chip().io().rcc.timer_clock();
    assert_eq!(bench.chip().io().tim3.frequency(clock), Some(1000.0));
    bench.chip_mut().set_motion(level(60_00));
    bench.wait(4000);
    assert_eq!(bench.chip().heater(), 0, "10 K above it");
    bench.chip_mut().set_motion(level(40_00));
    bench.wait(4000);
    let duty = bench.chip().heater();
    assert!((400..=700).contains(&duty), "{duty}");
    assert_eq!(
        bench.upload(0x4081, 0),
        u32::from(duty) * 1500 / 1000,
        "in mW"
    );
    bench.download(0x2041, 0, [0]);
    assert_eq!(bench.chip().heater(), 0, "switched off");
}
