//! The start of a node: it is not on the bus before the first reading, and begins with it, at the latest after 100 ms. So no frame
//! has an angle that was not measured.

use crate::tester::Tester;
use crate::tester::fsc::FscTester;
use crate::tester::j1939::{CLAIM, select};
use crate::tester::{canopen, ims360, leds};
use plumbline::can::BitRate;
use plumbline::fsc::{Article, FscNode, Product};
use plumbline::measure::ONE_G;
use plumbline::model::gemac::is1::{self, OneAxis};
use plumbline::model::gemac::is2::{self, TwoAxes};
use plumbline::model::ims360::Ims360;
use plumbline::model::jn2101::Jn2101;
use plumbline::model::tiltix::tiltix080::Tiltix080;
use plumbline::node::{Action, BitTime, Boot, BusEvent, BusMode, BusState, Leds, Node};

/// The time of the first reading in ms.
const FIRST: u64 = 57;
/// The time at which a node starts without a reading: a board needs the rest of 100 ms before the start of the node.
const LIMIT: u64 = 89;

/// Sine of 30 deg.
const HALF_G: i32 = ONE_G / 2;
/// Cosine of 30 deg, in 1 g.
const COSINE: i32 = (ONE_G as f64 * 0.866_025_403_784) as i32;

/// The boot-up messages of a GEMAC sensor with a fixed bit rate.
const BOOT_UP: &str = "301#FF00000300004403";

/// A node before its first reading.
fn jn2101() -> Tester<Jn2101> {
    Tester::switch_on(Boot::default(), Jn2101::new)
}

fn ims360() -> Tester<Ims360> {
    let mut tester = Tester::switch_on(Boot::default(), Ims360::new);
    tester.node_id = 50;
    tester
}

fn j1939() -> Tester<Ims360> {
    let mut tester = ims360::booted();
    select(&mut tester);
    tester.switch_on_again();
    tester
}

fn tiltix() -> Tester<Tiltix080> {
    Tester::switch_on(Boot::default(), Tiltix080::new)
}

/// A GEMAC sensor with these settings: the requests of their writes.
fn gemac<P: Product>(article: &'static Article, settings: &[&str]) -> FscTester<P> {
    let node = move |now, boot: &Boot| FscNode::<P>::new(article, now, boot);
    let mut tester = Tester::power_up(Boot::default(), node);
    tester.send("7FF#");
    tester.sent();
    for request in settings {
        tester.send(request);
    }
    tester.send("300#5053415645");
    tester.sent();
    tester.switch_on_again();
    tester
}

/// 500 kbit/s, without bit rate detection.
const FIXED: &str = "300#2307";
/// Cyclic time 100 ms, and cyclic mode on.
const CYCLIC: [&str; 2] = ["300#256400", "300#2601"];

/// What a node does in the time before its first reading, although requests come.
fn is_off_the_bus<N: Node>(tester: &mut Tester<N>, requests: &[&str]) {
    for _ in 0..FIRST {
        for request in requests {
            tester.send(request);
        }
        tester.bus(BusEvent::Overrun);
        tester.bus(BusEvent::State(BusState::Active));
        tester.node.supply(tester.now, 24_000);
        assert_eq!(tester.wait_text(1), []);
    }
    let is_on = |action: &Action| matches!(action, Action::Bus(BusMode::Normal, _) | Action::Save);
    assert!(!tester.actions.iter().any(is_on), "{:?}", tester.actions);
}

#[test]
fn gemac_sensor_is_off_the_bus_until_first_reading() {
    let mut t = gemac::<TwoAxes>(&is2::BP_CL, &[FIXED]);
    is_off_the_bus(&mut t, &["300#00", "100#", "300#28"]);
    t.begin();
    assert_eq!(t.sent_text(), [BOOT_UP; 2]);
    assert!(
        t.actions
            .contains(&Action::Bus(BusMode::Normal, BitRate::K500))
    );
    assert_eq!(t.exchange("300#18"), ["301#18000000"]);
}

#[test]
fn jn2101_is_off_the_bus_until_first_reading() {
    let mut t = jn2101();
    is_off_the_bus(
        &mut t,
        &["60A#4000100000000000", "000#010A", "000#8100", "080#"],
    );
    t.begin();
    assert_eq!(t.sent_text(), ["70A#00"]);
    assert!(
        t.actions
            .contains(&Action::Bus(BusMode::Normal, BitRate::K125))
    );
    // It did not receive the command that starts it.
    assert_eq!(t.exchange("080#"), [""; 0]);
    assert_eq!(t.wait_text(1000), []);
}

#[test]
fn ims360_is_off_the_bus_until_first_reading() {
    let mut t = ims360();
    is_off_the_bus(&mut t, &["632#4000100000000000", "000#0132", "080#"]);
    t.begin();
    assert_eq!(t.sent_text(), ["732#00"]);
    assert_eq!(t.exchange("080#"), [""; 0]);
    let mut t = j1939();
    is_off_the_bus(&mut t, &["18EAFF21#00EE00", "18EEFF80#0000000000000000"]);
    t.begin();
    assert_eq!(t.sent_text(), [CLAIM]);
    assert_eq!(t.wait_text(249), []);
}

#[test]
fn tiltix_is_off_the_bus_until_first_reading() {
    let mut t = tiltix();
    // A check request and a response of another node with the same MAC ID.
    is_off_the_bus(
        &mut t,
        &[
            "5FF#00620102020304",
            "5FF#80620102020304",
            "5FE#0A4B0301030A",
        ],
    );
    t.begin();
    let sent = t.sent_text();
    assert!(
        matches!(&sent[..], [check] if check.starts_with("5FF#00")),
        "{sent:?}"
    );
    assert_eq!(t.wait_text(2000).len(), 1);
    assert_eq!(t.exchange("5FE#0A4B0301030A"), ["5FB#0ACB00"]);
}

#[test]
fn bit_rate_is_detected_before_first_reading() {
    let node = |now, boot: &Boot| FscNode::<TwoAxes>::new(&is2::BP_CL, now, boot);
    let mut t = Tester::switch_on(Boot::default(), node);
    assert_eq!(t.wait_text(10), []);
    t.bus(BusEvent::Error);
    t.bus(BusEvent::BitTime(BitTime::of(BitRate::K500)));
    is_off_the_bus(&mut t, &["300#00", "100#", "300#28"]);
    assert_eq!(
        t.actions,
        [BitRate::K250, BitRate::K500].map(|rate| Action::Bus(BusMode::Listen, rate))
    );
    t.begin();
    assert_eq!(t.sent_text(), ["301#FF03000300004403"; 2]);
    assert!(
        t.actions
            .contains(&Action::Bus(BusMode::Normal, BitRate::K500))
    );
    assert_eq!(t.leds, leds(true, false));
}

#[test]
fn bit_rate_before_error_is_not_used_at_first_reading() {
    let node = |now, boot: &Boot| FscNode::<TwoAxes>::new(&is2::BP_CL, now, boot);
    let mut t = Tester::switch_on(Boot::default(), node);
    t.wait_text(1);
    t.send("7FF#");
    t.bus(BusEvent::Error);
    t.bus(BusEvent::BitTime(BitTime::of(BitRate::K500)));
    t.begin();
    assert_eq!(t.sent_text(), [""; 0]);
    t.send("7FF#");
    assert_eq!(t.sent_text().len(), 2);
    assert_eq!(
        t.actions.last(),
        Some(&Action::Bus(BusMode::Normal, BitRate::K500))
    );
}

/// Reproduced: a zero point set behind the second boot-up message was 0, and the master had no error.
#[test]
fn zero_point_set_after_boot_up_is_measured_position() {
    let mut t = gemac::<TwoAxes>(&is2::BP_CL, &[FIXED]);
    t.force = [-HALF_G, 0, COSINE];
    t.wait(FIRST);
    t.begin();
    assert_eq!(t.exchange("300#28"), [BOOT_UP, BOOT_UP, "301#2800"]);
    assert_eq!(t.exchange("300#00"), ["301#000000000000"]);
    assert_ne!(t.exchange("300#18"), ["301#18000000"]);
}

#[test]
fn first_cyclic_frame_has_measured_angle() {
    let mut t = gemac::<OneAxis>(&is1::BP_CL, &[FIXED, CYCLIC[0], CYCLIC[1]]);
    t.force = [HALF_G, COSINE, 0];
    t.wait(FIRST);
    t.begin();
    assert_eq!(t.sent_text(), [BOOT_UP; 2]);
    // 30.00 deg, and the counter.
    assert_eq!(t.wait_text(100), [(100, "301#0000B80B0100".to_string())]);
}

/// Tables 14 and 15: SensorError (bit 4), or SensorErrorX and SensorErrorY (bits 4 and 5).
#[test]
fn gemac_sensor_without_readings_boots_with_sensor_error() {
    let mut t = gemac::<TwoAxes>(&is2::BP_CL, &[FIXED]);
    let boot_up = (LIMIT, "301#FF30000300004403".to_string());
    assert_eq!(t.wait_text(1000), [boot_up.clone(), boot_up]);
    assert_eq!(t.exchange("300#02"), ["301#0230"]);
    let mut t = gemac::<OneAxis>(&is1::BP_CL, &[FIXED]);
    let boot_up = (LIMIT, "301#FF10000300004403".to_string());
    assert_eq!(t.wait_text(1000), [boot_up.clone(), boot_up]);
    // A sensor that detects the bit rate.
    let node = |now, boot: &Boot| FscNode::<TwoAxes>::new(&is2::BP_CL, now, boot);
    let mut t = Tester::switch_on(Boot::default(), node);
    t.wait_text(1);
    t.send("7FF#");
    let boot_up = (LIMIT - 1, "301#FF33000300004403".to_string());
    assert_eq!(t.wait_text(1000), [boot_up.clone(), boot_up]);
    t.begin();
    assert_eq!(t.exchange("300#02"), ["301#0203"]);
}

#[test]
fn canopen_sensor_without_readings_boots_with_emergency() {
    let mut t = jn2101();
    let expected = ["70A#00", "08A#0010010100000000"];
    assert_eq!(
        t.wait_text(1000),
        expected.map(|text| (LIMIT, text.to_string()))
    );
    t.begin();
    assert_eq!(t.sent_text(), ["08A#0000000000000000"]);
    let mut t = ims360();
    let expected = ["732#00", "0B2#01FF810000000000", "0B2#02FF810000000000"];
    assert_eq!(
        t.wait_text(1000),
        expected.map(|text| (LIMIT, text.to_string()))
    );
    t.begin();
    assert_eq!(
        t.sent_text(),
        ["0B2#0000810000000000", "0B2#0000000000000000"]
    );
}

/// Pitch and roll defective (FMI 12) in DM1. The bytes FEh of SSI2 are the error indicator.
#[test]
fn j1939_sensor_without_readings_claims_and_sends_no_values() {
    let mut t = j1939();
    let sent = t.wait_text(500);
    assert_eq!(sent[0], (LIMIT, CLAIM.to_string()));
    assert_eq!(
        sent[1],
        (LIMIT + 250, "1CECFF80#200A0002FFCAFE00".to_string())
    );
    let text = |start: &str| {
        sent.iter()
            .filter(|(_, text)| text.starts_with(start))
            .count()
    };
    assert_eq!(text("1CEBFF80#0104FF70130C0171"), 1);
    assert_eq!(text("1CEBFF80#02130C01"), 1);
    assert_eq!(text("0CF02980#FEFEFEFEFEFEBBFF"), sent.len() - 4);
}

/// The module LED flashes red, and bit 10 of the status (Identity) is set.
#[test]
fn tiltix_without_readings_checks_its_mac_id_and_has_fault() {
    let mut t = tiltix();
    let sent = t.wait_text(2500);
    assert!(
        matches!(&sent[..], [(LIMIT, check), (1089, _)] if check.starts_with("5FF#00")),
        "{sent:?}"
    );
    t.actions.clear();
    t.wait(1000);
    let lit = |is_lit: fn(&Leds) -> bool| {
        let shows = |action: &Action| matches!(action, Action::Leds(leds) if is_lit(leds));
        t.actions.iter().any(shows)
    };
    assert!(lit(|leds| leds.module_red) && !lit(|leds| leds.module_green));
    assert_eq!(t.exchange("5FE#0A4B0301030A"), ["5FB#0ACB00"]);
    assert_eq!(t.exchange("5FC#0A0E010105"), ["5FB#0A8E0104"]);
    t.begin();
    assert_eq!(t.exchange("5FC#0A0E010105"), ["5FB#0A8E0100"]);
}

/// Zero point, teach-in and preset need a measured angle. Until the first reading, there is none.
#[test]
fn position_is_not_taken_before_first_reading() {
    const REFUSED: Result<(), u32> = Err(0x0800_0022);
    let mut t = gemac::<TwoAxes>(&is2::BP_CL, &[FIXED]);
    t.wait(LIMIT);
    t.sent();
    // Bit 3: CmdParamError.
    assert_eq!(t.exchange("300#28"), ["301#2838"]);
    assert_eq!(t.exchange("300#29"), ["301#2938"]);
    let mut t = jn2101();
    t.wait(LIMIT);
    for object in [0x2042, 0x2046] {
        assert_eq!(t.write(object, 0, 1, 1), REFUSED, "{object:04X}h");
        assert_eq!(t.read(object, 0), Ok(2));
    }
    let mut t = ims360();
    t.wait(LIMIT);
    for axes in 1..=3 {
        assert_eq!(t.write(0x3200, 0, 1, axes), REFUSED, "{axes}");
    }
    let mut t = j1939();
    t.wait(LIMIT + 250);
    t.sent();
    assert_eq!(t.parameter("2F00320003000000"), "8000320022000008");
    let mut t = tiltix();
    t.wait(2500);
    assert_eq!(t.exchange("5FE#0A4B0301030A"), ["5FB#0ACB00"]);
    for enable in ["75", "7D"] {
        let sent = t.exchange(&format!("5FC#0A106501{enable}01"));
        assert_eq!(sent, ["5FB#0A940CFF"]);
    }
}

#[test]
fn reset_of_communication_does_not_wait_for_reading() {
    let mut t = canopen::booted();
    t.sampled = false;
    t.wait(50);
    for reset in ["000#820A", "000#810A"] {
        assert_eq!(t.exchange(reset), ["70A#00"]);
    }
    let mut t = ims360::booted();
    t.sampled = false;
    t.wait(50);
    for reset in ["000#8232", "000#8132"] {
        assert_eq!(t.exchange(reset), ["732#00"]);
    }
}
