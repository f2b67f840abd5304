//! The JN2101's image for the Blue Pill, run by the simulated microcontroller.

use bench::NodeType;
use bench::motion::Motion;
use bench::{AdapterId, Bus, BusRate, DeviceId, Flash, Sensor};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::time::{Instant, after, millis};
use std::rc::Rc;
use std::sync::OnceLock;
use stm32_sim::Microcontroller;
use stm32_sim::elf::Image;
use stm32_sim::firmware;

fn elf() -> &'static [u8] {
    static ELF: OnceLock<Vec<u8>> = OnceLock::new();
    ELF.get_or_init(|| {
        let images = firmware::build().expect("the firmware builds");
        std::fs::read(&images["jn2101"]).expect("the image can be read")
    })
}

fn node_type() -> NodeType {
    NodeType::find("jn2101").expect("a product")
}

/// At rest on a table, as warm as this in 0.01 degC.
fn table(temperature: i16) -> Box<Reading> {
    Box::new(Reading {
        acceleration: I32x3 {
            x: 0,
            y: 0,
            z: ONE_G,
        },
        angular_rate: I32x3 { x: 0, y: 0, z: 0 },
        temperature,
        clipped: false,
    })
}

fn microcontroller(serial: u32, motion: Box<dyn Motion>) -> Microcontroller {
    let image = Image::parse(elf()).expect("the image is one");
    Microcontroller::new("jn2101", Rc::new(image), serial, Flash::default(), motion)
}

/// A sensor on a bus of 125 kbit/s, and a tester.
struct Desk {
    bus: Bus,
    sensor: DeviceId,
    tester: AdapterId,
}

impl Desk {
    /// Switched on; its boot-up message has come.
    fn new(motion: Box<dyn Motion>) -> Self {
        let mut bus = Bus::new(BusRate::Fixed(BitRate::K125));
        let sensor = bus.attach(microcontroller(1, motion));
        let tester = bus.adapter();
        bus.open(tester, None, false);
        let mut desk = Self {
            bus,
            sensor,
            tester,
        };
        assert_eq!(desk.wait(200), ["70A#00"]);
        desk
    }

    /// What the sensor sends in so many milliseconds.
    fn wait(&mut self, ms: u32) -> Vec<String> {
        self.bus.run_until(after(self.bus.now(), millis(ms)));
        let frames = self.bus.take_received(self.tester).into_iter();
        frames.map(|(_, frame)| format!("{frame:?}")).collect()
    }

    /// Sends a frame; what comes within 10 ms.
    fn exchange(&mut self, text: &str) -> Vec<String> {
        self.bus.send(self.tester, frame(text));
        self.wait(10)
    }

    fn chip(&self) -> &Microcontroller {
        Microcontroller::of(self.bus.device(self.sensor)).expect("it is one")
    }

    fn chip_mut(&mut self) -> &mut Microcontroller {
        Microcontroller::of_mut(self.bus.device_mut(self.sensor)).expect("it is one")
    }

    /// The number in an object of four bytes at most.
    fn upload(&mut self, index: u16, sub: u8) -> u32 {
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
    fn download<const N: usize>(&mut self, index: u16, sub: u8, value: [u8; N]) {
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

impl Drop for Desk {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            assert_eq!(self.chip().violations(), [""; 0]);
        }
    }
}

/// The frame that a text like `60A#4000100000000000` stands for.
fn frame(text: &str) -> Frame {
    let (id, data) = text.split_once('#').expect("an identifier and data");
    let byte = |at: usize| u8::from_str_radix(&data[at..at + 2], 16).expect("hexadecimal");
    let bytes: Vec<u8> = (0..data.len()).step_by(2).map(byte).collect();
    let id = u16::from_str_radix(id, 16).expect("hexadecimal");
    Frame::data(standard(id), &bytes).expect("8 bytes at most")
}

/// The request, the data of the reply.
const DEVICE_TYPE: (&str, &str) = ("60A#4000100000000000", "58A#430010009A010400");

#[test]
fn sdo_nmt_sync_and_heartbeat() {
    let mut desk = Desk::new(table(25_00));
    assert_eq!(desk.exchange(DEVICE_TYPE.0), [DEVICE_TYPE.1]);
    assert_eq!(desk.exchange("080#"), [""; 0], "not operational");
    assert_eq!(desk.exchange("000#010A"), [""; 0]);
    let level = ["18A#00000000", "28A#0000000000000000"];
    assert_eq!(desk.exchange("080#"), level);
    desk.download(0x1017, 0, 50_u16.to_le_bytes());
    assert_eq!(desk.wait(150), ["70A#05"; 3]);
    desk.download(0x1017, 0, [0, 0]);
    assert_eq!(desk.exchange("000#8200"), ["70A#00"], "reset communication");
    assert_eq!(desk.exchange("000#8100"), ["70A#00"], "reset node");
    assert_eq!(desk.chip().boots(), 1);
    desk.bus.send(desk.tester, frame("60A#2F02200001000000"));
    assert_eq!(
        desk.wait(300),
        ["58A#6002200000000000", "70A#00"],
        "2002h restarts"
    );
    assert_eq!(desk.chip().boots(), 2);
}

/// What is answered before the controller changes its filters is not lost on the way.
#[test]
fn another_sync_identifier_is_confirmed_and_in_force() {
    let mut desk = Desk::new(table(25_00));
    desk.exchange("000#010A");
    desk.download(0x1005, 0, 0x0A0_u32.to_le_bytes());
    assert_eq!(desk.exchange("080#"), [""; 0]);
    assert_eq!(desk.exchange("0A0#").len(), 2);
}

#[test]
fn what_is_stored_outlasts_the_power() {
    let mut desk = Desk::new(table(25_00));
    desk.download(0x2000, 0, [11]);
    desk.bus.send(desk.tester, frame("60A#2310100173617665"));
    assert_eq!(desk.wait(200), ["58A#6010100100000000"]);
    desk.bus.power_cycle(desk.sensor);
    assert_eq!(desk.wait(200), ["70B#00"]);
}

#[test]
fn the_self_test_tells_which_axes_work() {
    for (works, register) in [(true, 0b110), (false, 0)] {
        let mut desk = Desk::new(table(25_00));
        desk.chip_mut().io_mut().imu.set_self_test_works(works);
        desk.exchange("000#010A");
        desk.download(0x4004, 1, [1]);
        for _ in 0..7 {
            assert_eq!(desk.upload(0x4004, 1), 1, "under way");
            assert_eq!(desk.exchange("080#")[0], "18A#00000000", "the angle holds");
            desk.wait(200);
        }
        let alarms = desk.wait(1000);
        assert_eq!(desk.upload(0x4004, 1), 0);
        assert_eq!(desk.upload(0x4004, 2), register);
        let silent: [&str; 0] = [];
        if works {
            assert_eq!(alarms, silent);
        } else {
            assert_eq!(alarms, ["08A#0010010100000000"]);
        }
        assert_eq!(
            desk.exchange("080#")[0],
            "18A#00000000",
            "it measures again"
        );
        if works {
            let mut shaken = table(25_00);
            shaken.acceleration.z = 3 * ONE_G;
            desk.chip_mut().set_motion(shaken);
            let clipped = "08A#0010010100000000";
            assert_eq!(desk.wait(200), [clipped], "at +-2 g");
        }
    }
}

#[test]
fn a_missing_accelerometer_fails_the_self_test() {
    let mut desk = Desk::new(table(25_00));
    desk.chip_mut().io_mut().imu.unmount();
    assert_eq!(desk.wait(500), ["08A#0010010100000000"]);
    desk.download(0x4004, 1, [1]);
    desk.wait(100);
    assert_eq!(desk.upload(0x4004, 1), 0);
    assert_eq!(desk.upload(0x4004, 2), 0);
}

#[test]
fn the_terminating_resistor_is_switched_and_off_without_power() {
    let mut desk = Desk::new(table(25_00));
    assert!(desk.chip().terminated(), "as delivered");
    desk.download(0x2045, 0, [0]);
    assert!(!desk.chip().terminated());
    desk.download(0x2045, 0, [1]);
    assert!(desk.chip().terminated());
    let now = desk.bus.now();
    desk.bus.device_mut(desk.sensor).power_off(now);
    assert!(!desk.chip().terminated());
}

#[test]
fn the_heater_heats_as_the_temperature_asks_for() {
    let mut desk = Desk::new(table(20_00));
    desk.download(0x2041, 0, [1]);
    desk.wait(500);
    assert_eq!(desk.chip().heater(), 1000, "30 K below its set point");
    let clock = desk.chip().io().rcc.timer_clock();
    assert_eq!(desk.chip().io().tim3.frequency(clock), Some(1000.0));
    desk.chip_mut().set_motion(table(60_00));
    desk.wait(4000);
    assert_eq!(desk.chip().heater(), 0, "10 K above it");
    desk.chip_mut().set_motion(table(40_00));
    desk.wait(4000);
    let duty = desk.chip().heater();
    assert!((400..=700).contains(&duty), "{duty}");
    assert_eq!(
        desk.upload(0x4081, 0),
        u32::from(duty) * 1500 / 1000,
        "in mW"
    );
    desk.download(0x2041, 0, [0]);
    assert_eq!(desk.chip().heater(), 0, "switched off");
}

/// A restart must not leave the heater on for the time that it takes.
#[test]
fn a_restart_switches_the_heater_off() {
    let mut desk = Desk::new(table(20_00));
    desk.download(0x2041, 0, [1]);
    desk.wait(500);
    assert_eq!(desk.chip().heater(), 1000);
    desk.bus.send(desk.tester, frame("60A#2F02200001000000"));
    let mut last = 1000;
    while desk.chip().boots() == 1 {
        last = desk.chip().heater();
        let soon = Instant::from_ticks(desk.bus.now().ticks() + 50);
        desk.bus.run_until(soon);
    }
    assert_eq!(last, 0, "off before the reset");
    assert_eq!(desk.chip().heater(), 0, "and after it");
}

/// The time of the boot-up message in us.
#[cfg(target_os = "linux")]
fn boot_up(sensor: impl Sensor) -> u64 {
    let mut bus = Bus::new(BusRate::Fixed(BitRate::K125));
    bus.attach(sensor);
    let tester = bus.adapter();
    bus.open(tester, None, false);
    bus.run_until(Instant::from_ticks(500_000));
    let frames = bus.take_received(tester);
    frames.first().expect("the boot-up message").0.ticks()
}

#[cfg(target_os = "linux")]
fn built_for_the_pc() -> bench::Device {
    bench::Device::new(&node_type(), 1, Flash::default(), table(25_00))
}

/// A trace with everything later by so many us: the board takes its time to boot.
#[cfg(target_os = "linux")]
fn later(trace: &str, delay: u64) -> String {
    let line = |line: &str| {
        let timed = line.strip_prefix('(').and_then(|rest| rest.split_once(')'));
        let Some((time, rest)) = timed else {
            return format!("{line}\n");
        };
        let (seconds, micros) = time.split_once('.').expect("a time");
        let number = |text: &str| text.parse::<u64>().expect("a time");
        let time = number(seconds) * 1_000_000 + number(micros) + delay;
        format!("({}.{:06}){rest}\n", time / 1_000_000, time % 1_000_000)
    };
    trace.lines().map(line).collect()
}

/// Byte for byte what the sensor built for the PC sends.
#[cfg(target_os = "linux")]
#[test]
fn it_replays_its_traces() {
    use host_tests::trace::Trace;
    use virtual_sensor::scene::{Axes, Scene, SceneArgument};
    let scene = |node_type: &NodeType, text: &str| -> Result<Box<dyn Motion>, String> {
        let argument: SceneArgument = text.parse().map_err(|error| format!("{error}"))?;
        let scene = Scene::open(Some(&argument), Axes::of(node_type));
        Ok(Box::new(scene.map_err(|error| error.to_string())?))
    };
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("traces");
    let delay = boot_up(microcontroller(1, table(25_00))) - boot_up(built_for_the_pc());
    let mut replayed = 0;
    for entry in folder.read_dir().expect("the traces") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if !name.starts_with("jn2101-") || !name.ends_with(".log") {
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("the trace can be read");
        let trace: Trace = later(&text, delay).parse().expect("it is a trace");
        let booted = millis(0);
        let result = trace.replay_on(&node_type(), &scene, booted, &|_, serial, motion| {
            Box::new(microcontroller(serial, motion))
        });
        if let Err(failure) = result {
            panic!("{name}: {failure}");
        }
        replayed += 1;
    }
    assert!(replayed > 0);
}

#[test]
fn flash_and_memory_suffice() {
    let mut desk = Desk::new(table(25_00));
    desk.exchange("000#010A");
    desk.exchange("080#");
    desk.download(0x4004, 1, [1]);
    desk.wait(2500);
    desk.bus.send(desk.tester, frame("60A#2310100173617665"));
    desk.wait(200);
    let size = stm32_sim::image::Size::of(elf()).expect("the image is one");
    let stack = desk.chip().peak_stack();
    assert!(size.flash <= 30 * 1024, "{} bytes of flash", size.flash);
    assert!(stack <= 2 * 1024, "{stack} bytes of stack");
    assert!(size.ram + u64::from(stack) <= 8 * 1024);
}
