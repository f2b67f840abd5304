//! The saves of a DeviceNet sensor: each accepted set is stored within a second (T22 of the decisions), a power cut loses no other
//! parameter, and the erased pages are counted. The page of the TILTIX has the numbers.

use bench::{AdapterId, Bus, BusRate, Device, DeviceId, Flash, NodeType};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::measure::Reading;
use plumbline::time::{after, millis};

/// The MAC ID as delivered.
const MAC: u16 = 63;

/// A sensor with an explicit connection that does not time out, and its master.
struct Bench {
    bus: Bus,
    device: DeviceId,
    master: AdapterId,
    /// The MAC ID that the sensor has checked at its start.
    mac: u16,
}

impl Bench {
    fn new(name: &str, memory: Flash) -> Self {
        let node_type = NodeType::find(name).expect("a product");
        let mut bus = Bus::new(BusRate::Follow);
        let motion = Box::new(Reading::default());
        let device = bus.attach(Device::new(&node_type, 1, memory, motion));
        let master = bus.adapter();
        bus.open(master, None, false);
        let mut bench = Self {
            bus,
            device,
            master,
            mac: MAC,
        };
        bench.connect();
        bench
    }

    /// Waits until the sensor is on-line and allocates the explicit connection.
    fn connect(&mut self) {
        self.run(2200);
        let received = self.bus.take_received(self.master);
        let [(_, one), (_, other)] = &received[..] else {
            panic!("two requests of the duplicate MAC ID check: {received:?}")
        };
        assert_eq!(one, other);
        self.mac = (one.can_id().bits() >> 3 & 63) as u16;
        assert_eq!(self.ask(6, &[0x4B, 3, 1, 1, 0x0A]), [0xCB, 0]);
        assert_eq!(self.ask(4, &[0x10, 5, 1, 9, 0, 0]), [0x90, 0, 0]);
    }

    fn run(&mut self, ms: u32) {
        self.bus.run_until(after(self.bus.now(), millis(ms)));
    }

    /// The response to a request, without its header.
    fn ask(&mut self, message: u16, request: &[u8]) -> Vec<u8> {
        let bytes = [&[0x0A], request].concat();
        let id = standard(0x400 | self.mac << 3 | message);
        let frame = Frame::data(id, &bytes).expect("at most 8 bytes");
        self.bus.send(self.master, frame);
        self.run(5);
        let received = self.bus.take_received(self.master);
        let [(_, response)] = &received[..] else {
            panic!("{request:02X?} -> {received:?}")
        };
        response.bytes()[1..].to_vec()
    }

    /// Sets an attribute of the angle object.
    fn set(&mut self, attribute: u8, value: &[u8]) {
        let request = [&[0x10, 0x65, 1, attribute], value].concat();
        assert_eq!(self.ask(4, &request), [0x90]);
    }

    /// Reads an attribute of the angle object.
    fn get(&mut self, attribute: u8) -> Vec<u8> {
        let response = self.ask(4, &[0x0E, 0x65, 1, attribute]);
        let (service, value) = response.split_first().expect("a service");
        assert_eq!(*service, 0x8E);
        value.to_vec()
    }

    fn flash(&mut self) -> &mut Flash {
        self.bus.device_mut(self.device).flash()
    }

    /// Switches the sensor off and on.
    fn restart(&mut self) {
        self.flash().power_on();
        self.bus.power_cycle(self.device);
        self.connect();
    }
}

/// Sets a parameter of two bytes and waits until it is stored, with a power cut in each operation of the flash. 20 sets before it fill
/// different parts of the page, the last of them so much of it that the save erases a page.
#[test]
fn power_cut_in_any_operation_of_a_set_keeps_the_old_or_the_new_value() {
    for before in [0, 3, 22, 45] {
        let mut cuts = 0;
        loop {
            let mut bench = Bench::new("tiltix080", Flash::default());
            for number in 0..before {
                bench.set(0x85, &[number, 0]);
                bench.run(400);
            }
            bench.set(0x74, &[0x34, 0x12]);
            bench.run(1000);
            bench.flash().cut_in_operation_after(cuts, cuts);
            bench.set(0x85, &[0xE7, 0x03]);
            bench.run(1000);
            let is_cut = bench.flash().is_cut();
            bench.restart();
            let kept = bench.get(0x85);
            let old = before.checked_sub(1).map_or([0, 0], |number| [number, 0]);
            let new = [0xE7, 0x03];
            assert!(kept == new || is_cut && kept == old, "{cuts}: {kept:02X?}");
            assert_eq!(bench.get(0x74), [0x34, 0x12], "cut {cuts}");
            // The following sets are stored.
            bench.set(0x88, &[7]);
            bench.run(1000);
            bench.restart();
            assert_eq!(bench.get(0x88), [7], "cut {cuts}");
            assert_eq!(bench.get(0x85), kept, "cut {cuts}");
            if !is_cut {
                break;
            }
            cuts += 1;
        }
        assert!(cuts > 8, "{before} saves before: only {cuts} operations");
    }
}

/// Sets the MAC ID with a power cut in each operation of its save. The bit rate and other parameters are set before.
#[test]
fn power_cut_in_a_change_of_the_mac_id_keeps_the_old_or_the_new_one() {
    let mut kept = Vec::new();
    loop {
        let cuts = kept.len() as u64;
        let mut bench = Bench::new("tiltix080", Flash::default());
        assert_eq!(bench.ask(4, &[0x10, 3, 1, 2, 2]), [0x90]);
        bench.set(0x85, &[1, 0]);
        bench.run(1000);
        bench.flash().cut_in_operation_after(cuts, cuts);
        let set = Frame::data(standard(0x5FC), &[0x0A, 0x10, 3, 1, 1, 5]);
        bench.bus.send(bench.master, set.expect("6 bytes"));
        bench.run(3000);
        bench.bus.take_received(bench.master);
        let is_cut = bench.flash().is_cut();
        bench.restart();
        kept.push(bench.mac);
        assert!(bench.mac == 5 || is_cut && bench.mac == MAC, "cut {cuts}");
        let rate = bench.bus.device(bench.device).rate();
        assert_eq!(rate, Some(BitRate::K500), "cut {cuts}");
        assert_eq!(bench.get(0x85), [1, 0], "cut {cuts}");
        let stored = bench.ask(4, &[0x0E, 3, 1, 1]);
        assert_eq!(stored, [0x8E, bench.mac as u8], "cut {cuts}");
        if !is_cut {
            break;
        }
    }
    assert!(kept.len() > 8 && kept[0] == MAC, "{kept:?}");
}

#[test]
fn set_is_stored_within_a_second_after_the_answer() {
    let mut bench = Bench::new("tiltix360", Flash::default());
    for number in 1..60 {
        bench.set(0x74, &[number, 0]);
        bench.run(995);
        bench.restart();
        assert_eq!(bench.get(0x74), [number, 0]);
    }
}

#[test]
fn sets_that_follow_each_other_are_stored_together() {
    let mut bench = Bench::new("tiltix360", Flash::default());
    bench.set(0x84, &[1]);
    bench.run(1000);
    let record = bench.flash().programmed();
    assert!(record > 0);
    for number in 2..42 {
        bench.set(0x84, &[number]);
    }
    bench.run(1000);
    assert_eq!(bench.flash().programmed(), 2 * record);
    // The present value, and a parameter that is not stored.
    bench.set(0x84, &[41]);
    bench.set(0x7D, &[0]);
    bench.run(1000);
    assert_eq!(bench.flash().programmed(), 2 * record);
}

/// The endurance in the document: a page is erased once for 22 saves, each with a record of 44 bytes. The usage of the device, which was
/// kept after ten seconds, has one more in each page.
#[test]
fn page_is_erased_once_for_22_saves() {
    const PAGES: u64 = 10;
    const SAVES: u64 = 22 * PAGES;
    let mut bench = Bench::new("tiltix080", Flash::default());
    for number in 0..46 {
        bench.set(0x85, &[number, 1]);
        bench.run(500);
    }
    let (erased, programmed) = (bench.flash().erased(), bench.flash().programmed());
    for number in 0..SAVES {
        bench.set(0x85, &[number as u8, 0]);
        bench.run(500);
    }
    assert_eq!(
        bench.flash().programmed() - programmed,
        (SAVES + PAGES) * 44
    );
    assert_eq!(bench.flash().erased() - erased, PAGES);
}
