//! An accelerometer that measures nothing valid, with an image of each family of products: the fault of its protocol, and no zero point.
//! The wire tests of core have all conditions and times.

use crate::rig::{blank, fixed, part, tilt};
use bench::{AdapterId, Bus, BusRate, DeviceId, Flash, Sensor};
use can_wire::text::frame;
use plumbline::can::BitRate;
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::time::{after, millis};
use stm32_sim::Microcontroller;
use stm32_sim::ism330dhcx::{Fault, Sibling};

/// A frame of the tester and the frame that answers it. A dot is any digit.
type Exchange = (&'static str, &'static str);

/// A product, and what it sends.
struct Product {
    name: &'static str,
    rate: BitRate,
    memory: fn() -> Flash,
    /// The start with a dead accelerometer, in ms, and the frames in this time.
    start: u32,
    dead_at_start: &'static [&'static str],
    /// The frames of another start in this time.
    started: &'static [&'static str],
    /// Requests after the start that configure the sensor.
    prepare: &'static [Exchange],
    /// The frames at the begin of a fault, at the begin of clipping, and at the end of both.
    defect: &'static [&'static str],
    clipping: &'static [&'static str],
    ended: &'static [&'static str],
    /// A request whose answer has the fault: the answers without it, with it, and while the accelerometer clips.
    read: &'static str,
    answers: [&'static str; 3],
    /// The requests for a zero point, refused, with reads of what they do not change.
    refused: &'static [Exchange],
    /// A request for a zero point that is served.
    served: Exchange,
}

const PRODUCTS: [Product; 4] = [
    Product {
        name: "is2",
        rate: BitRate::K500,
        memory: || fixed("is2", BitRate::K500),
        start: 200,
        dead_at_start: &["301#FF30............", "301#FF30............"],
        started: &["301#FF00............", "301#FF00............"],
        prepare: &[],
        defect: &[],
        clipping: &[],
        ended: &[],
        // SensorErrorX and SensorErrorY
        read: "300#00",
        answers: ["301#0000........", "301#0030........", "301#0030........"],
        // CmdParamError, until the status is read
        refused: &[
            ("300#28", "301#2838"),
            ("300#02", "301#0238"),
            ("300#18", "301#18300000"),
            ("300#29", "301#2938"),
            ("300#02", "301#0238"),
            ("300#19", "301#19300000"),
        ],
        served: ("300#28", "301#2800"),
    },
    Product {
        name: "jn2101",
        rate: BitRate::K125,
        memory: blank,
        start: 200,
        dead_at_start: &["70A#00", "08A#0010010100000000"],
        started: &["70A#00"],
        prepare: &[],
        // Defective element
        defect: &["08A#0010010100000000"],
        clipping: &["08A#0010010100000000"],
        ended: &["08A#0000000000000000"],
        // Error register
        read: "60A#4001100000000000",
        answers: [
            "58A#4F01100000000000",
            "58A#4F01100001000000",
            "58A#4F01100001000000",
        ],
        refused: &[
            ("60A#2F42200001000000", "58A#8042200022000008"),
            ("60A#4042200000000000", "58A#4F42200002000000"),
            ("60A#2F46200001000000", "58A#8046200022000008"),
            ("60A#4046200000000000", "58A#4F46200002000000"),
        ],
        served: ("60A#2F46200001000000", "58A#6046200000000000"),
    },
    Product {
        name: "ims360",
        rate: BitRate::K125,
        memory: blank,
        start: 200,
        dead_at_start: &["732#00", "0B2#01FF810000000000", "0B2#02FF810000000000"],
        started: &["732#00"],
        prepare: &[],
        // Axis X and Y defective, or out of range
        defect: &["0B2#01FF810000000000", "0B2#02FF810000000000"],
        clipping: &["0B2#1050810000000000", "0B2#2050810000000000"],
        ended: &["0B2#0000810000000000", "0B2#0000000000000000"],
        // Error register
        read: "632#4001100000000000",
        answers: [
            "5B2#4F01100000000000",
            "5B2#4F01100081000000",
            "5B2#4F01100081000000",
        ],
        refused: &[
            ("632#2F00320001000000", "5B2#8000320022000008"),
            ("632#2F00320002000000", "5B2#8000320022000008"),
            ("632#2F00320003000000", "5B2#8000320022000008"),
            ("632#4010320000000000", "5B2#4310320000000000"),
            ("632#4020320000000000", "5B2#4320320000000000"),
        ],
        served: ("632#2F00320003000000", "5B2#6000320000000000"),
    },
    Product {
        name: "tiltix080",
        rate: BitRate::K125,
        memory: blank,
        start: 2200,
        dead_at_start: &["5FF#00620101000000", "5FF#00620101000000"],
        started: &["5FF#00620101000000", "5FF#00620101000000"],
        // An explicit connection without a limit of time
        prepare: &[
            ("5FE#0A4B0301010A", "5FB#0ACB00"),
            ("5FC#0A100501090000", "5FB#0A900000"),
        ],
        defect: &[],
        clipping: &[],
        ended: &[],
        // Status of the identity: owned, bit 10. It has no message for clipping.
        read: "5FC#0A0E010105",
        answers: ["5FB#0A8E0100", "5FB#0A8E0104", "5FB#0A8E0100"],
        // 0Ch: object state conflict
        refused: &[
            ("5FC#0A1065017501", "5FB#0A940CFF"),
            ("5FC#0A0E650175", "5FB#0A8E00"),
            ("5FC#0A0E650176", "5FB#0A8E0000"),
            ("5FC#0A1065017D01", "5FB#0A940CFF"),
            ("5FC#0A0E65017D", "5FB#0A8E00"),
            ("5FC#0A0E65017E", "5FB#0A8E0000"),
        ],
        served: ("5FC#0A1065017501", "5FB#0A90"),
    },
];

/// An accelerometer whose mass does not move any more.
const DEAD: Reading = Reading {
    acceleration: I32x3 { x: 0, y: 0, z: 0 },
    angular_rate: I32x3 { x: 0, y: 0, z: 0 },
    temperature: 25_00,
    clipped: false,
};

/// At the end of the range.
const CLIPPED: Reading = Reading {
    acceleration: I32x3 {
        x: 0,
        y: 0,
        z: 9 * ONE_G,
    },
    clipped: true,
    ..DEAD
};

/// Asserts that the frames are these. A dot is any digit.
#[track_caller]
fn assert_frames(frames: &[String], expected: &[&str], when: &str) {
    let same = |(frame, expected): (&String, &&str)| {
        let digits = || frame.bytes().zip(expected.bytes());
        frame.len() == expected.len() && digits().all(|(is, should)| should == b'.' || is == should)
    };
    let all = frames.len() == expected.len() && frames.iter().zip(expected).all(same);
    assert!(all, "{when}: {frames:?}, not {expected:?}");
}

/// A sensor of a product with a master.
struct Bench {
    product: &'static Product,
    bus: Bus,
    sensor: DeviceId,
    tester: AdapterId,
}

impl Bench {
    fn new(product: &'static Product) -> Self {
        let mut bus = Bus::new(BusRate::Fixed(product.rate));
        let motion = tilt(product.name, 10.0, 5.0);
        let sensor = bus.attach(part(product.name, 1, (product.memory)(), motion));
        let tester = bus.adapter();
        bus.open(tester, None, false);
        Self {
            product,
            bus,
            sensor,
            tester,
        }
    }

    /// The frames that the sensor sends within this many milliseconds.
    fn wait(&mut self, ms: u32) -> Vec<String> {
        self.bus.run_until(after(self.bus.now(), millis(ms)));
        let frames = self.bus.take_received(self.tester).into_iter();
        frames.map(|(_, frame)| format!("{frame:?}")).collect()
    }

    #[track_caller]
    fn exchange(&mut self, exchanges: &[Exchange], when: &str) {
        for (request, answer) in exchanges {
            self.bus.send(self.tester, frame(request));
            let when = format!("{}, {when}, {request}", self.product.name);
            assert_frames(&self.wait(20), &[answer], &when);
        }
    }

    fn chip(&mut self) -> &mut Microcontroller {
        Microcontroller::of_mut(self.bus.device_mut(self.sensor))
            .expect("a simulated microcontroller")
    }

    fn set_fault(&mut self, fault: Fault) {
        let now = self.bus.now().ticks() * 1_000_000;
        self.chip().io_mut().imu.set_fault(now, fault);
    }

    /// Wrong parity of each tag of the accelerometer's FIFO, or no more.
    fn set_line_errors(&mut self, on: bool) {
        let imu = &mut self.chip().io_mut().imu;
        imu.spoil(0x78, 1, if on { u32::MAX } else { 0 });
    }

    fn measure(&mut self, reading: Reading) {
        self.chip().set_motion(Box::new(reading));
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            crate::rig::check(self.chip());
        }
    }
}

/// How the accelerometer fails: with the time in ms until it is told.
type Failure = (&'static str, u32, fn(&mut Bench));

#[test]
fn nothing_valid_is_told_and_is_no_zero_point() {
    let failures: [Failure; 4] = [
        ("silent", 200, |bench| bench.set_fault(Fault::Silent(0xFF))),
        ("bit errors", 200, |bench| bench.set_line_errors(true)),
        // For less than 0.5 s: then it is a wrong accelerometer.
        ("clips", 150, |bench| bench.measure(CLIPPED)),
        ("dead", 800, |bench| bench.measure(DEAD)),
    ];
    for product in &PRODUCTS {
        for (failure, time, fail) in failures {
            let when = &format!("{}, {failure}", product.name);
            let mut bench = Bench::new(product);
            assert_frames(&bench.wait(product.start), product.started, when);
            bench.exchange(product.prepare, when);
            let [good, defect, clips] = product.answers;
            let (told, answer) = match failure {
                "clips" => (product.clipping, clips),
                _ => (product.defect, defect),
            };
            assert_frames(&bench.wait(1500), &[], when);
            bench.exchange(&[(product.read, good)], when);
            fail(&mut bench);
            assert_frames(&bench.wait(time), told, when);
            bench.exchange(&[(product.read, answer)], when);
            bench.exchange(product.refused, when);
            bench.set_fault(Fault::None);
            bench.set_line_errors(false);
            bench.chip().set_motion(tilt(product.name, 10.0, 5.0));
            assert_frames(&bench.wait(3000), product.ended, when);
            bench.exchange(&[(product.read, good), product.served], when);
        }
    }
}

/// Causes a fault.
type Fail = fn(&mut Bench);

/// It never looks level.
#[test]
fn dead_or_wrong_accelerometer_is_told_at_power_up() {
    let failures: [(&str, Fail); 2] = [
        ("dead", |bench| bench.measure(DEAD)),
        ("IIS2ICLX", |bench| {
            let imu = &mut bench.chip().io_mut().imu;
            imu.set_sibling(Sibling::Iis2iclx);
        }),
    ];
    for product in &PRODUCTS {
        for (failure, fail) in failures {
            let when = &format!("{}, {failure} at power-up", product.name);
            let mut bench = Bench::new(product);
            fail(&mut bench);
            let frames = bench.wait(product.start);
            assert_frames(&frames, product.dead_at_start, when);
            bench.exchange(product.prepare, when);
            let [_, defect, _] = product.answers;
            bench.exchange(&[(product.read, defect)], when);
        }
    }
}
