//! The usage of a sensor (`plumbline::diagnosis`): measured, stored, and read over the bus after power cuts.

use bench::scene::Scene;
use bench::script::frame;
use bench::{AdapterId, Bus, BusRate, Device, DeviceId, Flash, NodeType};
use plumbline::can::{BitRate, standard};
use plumbline::measure::Calibration;
use plumbline::model::catalog;
use plumbline::store::{Owner, Store};
use plumbline::time::{after, millis};

const SERIAL: u32 = 1;

/// A jn2101 (node-ID 10) and its tester.
struct Rig {
    bus: Bus,
    device: DeviceId,
    tester: AdapterId,
}

impl Rig {
    /// It lies level at -12.34 degC for 2 s, is accelerated by 6 g for 0.1 s, then lies level at 40 degC.
    fn new() -> Self {
        Self::with(Flash::default())
    }

    fn with(flash: Flash) -> Self {
        let scene = "t_s,ax_g,ay_g,az_g,temp_c\n0,0,0,1,-12.34\n2,0,0,1,-12.34\n2.1,0,0,6,-12.34\n2.2,0,0,6,40\n2.3,0,0,1,40\n";
        let node_type = NodeType::find("jn2101").expect("a product");
        let scene = Scene::recorded(scene).expect("a scene");
        let sensor = Device::new(&node_type, SERIAL, flash, Box::new(scene));
        let mut bus = Bus::new(BusRate::Fixed(BitRate::K125));
        let device = bus.attach(sensor);
        let tester = bus.adapter();
        bus.open(tester, None, false);
        Self {
            bus,
            device,
            tester,
        }
    }

    fn run(&mut self, ms: u32) {
        self.bus.run_until(after(self.bus.now(), millis(ms)));
    }

    /// The bytes that the device has programmed since its first start.
    fn programmed(&mut self) -> u64 {
        self.bus.device_mut(self.device).memory().programmed()
    }

    /// The value with this number, by an SDO upload of 5F00h.
    fn value(&mut self, number: u8) -> i32 {
        self.bus.take_received(self.tester);
        let request = [0x40, 0x00, 0x5F, number, 0, 0, 0, 0];
        self.bus.send(self.tester, frame(0x60A, &request));
        self.run(20);
        let received = self.bus.take_received(self.tester);
        let reply = received
            .iter()
            .find(|(_, frame)| frame.id() == standard(0x58A))
            .expect("a reply");
        let &[0x43, 0x00, 0x5F, sub, a, b, c, d] = reply.1.bytes() else {
            panic!("{reply:?}");
        };
        assert_eq!(sub, number);
        i32::from_le_bytes([a, b, c, d])
    }

    fn values<const N: usize>(&mut self, numbers: [u8; N]) -> [i32; N] {
        numbers.map(|number| self.value(number))
    }
}

#[test]
fn starts_time_temperatures_and_shock_are_read_after_a_power_cut() {
    let mut rig = Rig::new();
    // A start of less than 10 s is not kept.
    rig.run(9_000);
    assert_eq!(rig.value(2), 1);
    rig.bus.power_cycle(rig.device);
    rig.run(12_000);
    assert_eq!(rig.value(2), 1);
    rig.run(50_000);
    let [starts, minutes, coldest, warmest, shock] = rig.values([2, 3, 4, 5, 6]);
    assert_eq!((starts, minutes), (1, 1));
    assert_eq!((coldest, warmest), (4000, 4000), "the scene has ended");
    assert!((990..=1010).contains(&shock), "{shock} mg");
    // The minute since the record at 10 s is lost.
    rig.bus.power_cycle(rig.device);
    rig.run(1_000);
    assert_eq!(rig.values([2, 3]), [2, 0]);
}

#[test]
fn extremes_of_the_first_ten_seconds_are_kept() {
    let mut rig = Rig::new();
    rig.run(12_000);
    let told = rig.values([2, 4, 5]);
    assert_eq!(told, [1, -1234, 4000]);
    let shock = rig.value(6);
    assert!((5_950..=6_050).contains(&shock), "{shock} mg");
    rig.bus.power_cycle(rig.device);
    rig.run(1_000);
    assert_eq!(rig.values([2, 4, 5, 6]), [2, -1234, 4000, shock]);
}

#[test]
fn operating_time_is_kept_each_hour() {
    let mut rig = Rig::new();
    rig.run(3_600_000 + 2_000);
    rig.bus.power_cycle(rig.device);
    rig.run(1_000);
    assert_eq!(rig.values([2, 3]), [2, 60]);
    assert_eq!(rig.value(8), 0);
}

#[test]
fn usage_is_written_once_after_ten_seconds_and_once_an_hour() {
    const RECORD: u64 = 44;
    let mut rig = Rig::new();
    let mut writes = Vec::new();
    let mut before = 0;
    for second in 1..=3 * 3600 + 10 {
        rig.run(1000);
        let programmed = rig.programmed();
        if programmed > before {
            assert_eq!(programmed - before, RECORD, "{second} s");
            writes.push(second);
        }
        before = programmed;
    }
    // The readings begin some milliseconds after the start.
    assert_eq!(writes, [11, 3601, 7201, 10801]);
}

#[test]
fn value_9_is_1_with_a_calibration() {
    let value_9 = |flash: Flash| {
        let mut rig = Rig::with(flash);
        rig.run(1_000);
        rig.value(9)
    };
    assert_eq!(value_9(Flash::default()), 0);
    let product = catalog::find("jn2101").expect("a product");
    let owner = Owner {
        image: product.image,
        layout: product.layout,
        serial: SERIAL,
    };
    let calibration = Calibration::new([1000, 2000, 3000], [[0; 3]; 3], [0; 3]);
    let mut store = Store::<_, [u8; 512]>::open(Flash::default(), owner);
    store.calibrate(&calibration.expect("within the ranges"));
    while store.step().is_none() {}
    assert_eq!(value_9(store.into_memory()), 1);
}
