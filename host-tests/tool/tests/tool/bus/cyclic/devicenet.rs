//! DeviceNet: the poll connection is allocated and released. A slave of another master is only listened to.

use super::{lost, millis, recorded, send, texts};
use crate::bus::rig::Rig;
use plumbline::can::{Frame, standard};

/// Identifiers of MAC ID 63: requests to the unconnected port and on the explicit connection, polls.
const UNCONNECTED: u16 = 0x5FE;
const REQUEST: u16 = 0x5FC;
pub const POLL: u16 = 0x5FD;

/// The requests of the tool, which is master 62 (3Eh), to the unconnected port.
fn allocations(rig: &mut Rig) -> Vec<String> {
    let seen = texts(&rig.witnessed());
    let own = seen.iter().filter_map(|frame| frame.strip_prefix("5FE#3E"));
    own.map(str::to_owned).collect()
}

/// Another master allocates explicit and poll; the connections stay without a time-out.
pub fn own(rig: &mut Rig) {
    rig.witnessed();
    send(
        rig,
        &[
            (UNCONNECTED, &[0x0A, 0x4B, 3, 1, 3, 0x0A]),
            (REQUEST, &[0x0A, 0x10, 5, 1, 9, 0, 0]),
            (REQUEST, &[0x0A, 0x10, 5, 2, 9, 0, 0]),
        ],
    );
    let seen = texts(&rig.witnessed());
    assert!(seen.contains(&"5FB#0ACB00".to_owned()), "{seen:?}");
    assert!(seen.contains(&"5FB#0A900000".to_owned()), "{seen:?}");
}

#[test]
fn polls_at_1_khz_are_complete_and_the_connection_is_released() {
    for (product, columns) in [
        ("tiltix080", "time_s,slope-long16_deg,slope-lateral16_deg"),
        ("tiltix360", "time_s,slope-long16_deg"),
    ] {
        let mut rig = Rig::with(product);
        // A poll and its response take 1.1 ms at the factory rate of 125 kbit/s.
        send(&mut rig, &[]);
        rig.done("--mac 63 rate 500");
        let before = rig.done("--rate 500 --mac 63 get");
        rig.witnessed();
        let name = format!("cyclic-{product}.csv");
        let rows = recorded(&mut rig, &name, "--rate 500 --mac 63");
        assert_eq!(rows[0], columns);
        let seen = texts(&rig.witnessed());
        assert!(seen.iter().filter(|frame| *frame == "5FD#").count() >= 2990);
        // The time-out of the poll connection is 4 x 1000 ms.
        assert!(seen.contains(&"5FC#3E10050209E803".to_owned()), "{product}");
        let angle = rig.json("--rate 500 --mac 63 get slope-long16")["slope-long16"]["value"]
            .as_f64()
            .unwrap();
        let row: Vec<&str> = rows[1000].split(',').collect();
        assert_eq!(row[1].parse::<f64>().unwrap(), angle);
        assert!(angle.abs() > 1.0);
        assert_eq!(rig.done("--rate 500 --mac 63 get"), before);
        // Another master is served at once.
        own(&mut rig);
    }
}

#[test]
fn polls_that_are_too_fast_for_the_bus_are_counted() {
    let mut rig = Rig::with("tiltix080");
    rig.witnessed();
    let ended = rig.tool("--mac 63 watch --every 1 --cyclic --seconds 3");
    let [missing, all] = lost(&ended);
    assert!((2998..=3001).contains(&all), "{}", ended.notes);
    assert!(missing > 100, "{}", ended.notes);
    let seen = texts(&rig.witnessed());
    let answers = seen.iter().filter(|frame| frame.starts_with("3FF#"));
    // The last ones are on their way at the end.
    let late = answers.count() as u64 - (all - missing);
    assert!(late <= 8, "{late}");
}

#[test]
fn slow_polls_keep_the_connection() {
    let mut rig = Rig::with("tiltix080");
    let ended = rig.tool("--mac 63 watch --cyclic --every 15000 --seconds 100");
    assert_eq!(lost(&ended), [0, 7], "{ended:?}");
    own(&mut rig);
}

#[test]
fn connection_is_released_after_ctrl_c() {
    for looks in 1.. {
        let mut rig = Rig::with("tiltix080");
        rig.stop = Some(looks);
        let ended = rig.tool("--mac 63 watch --every 10 --cyclic --seconds 0.2");
        rig.stop = None;
        let requests = allocations(&mut rig);
        // Service, class and instance, choice.
        for choice in ["01", "02"] {
            let allocated = format!("4B0301{choice}3E");
            let released = format!("4C0301{choice}");
            let count = |wanted: &str| requests.iter().filter(|own| *own == wanted).count();
            assert_eq!(count(&allocated), count(&released), "{looks} {requests:?}");
        }
        own(&mut rig);
        if ended.out.lines().count() >= 18 {
            assert!(looks > 10, "{looks}");
            break;
        }
    }
}

#[test]
fn slave_releases_the_connection_itself_if_the_tool_is_cut_off() {
    let mut rig = Rig::with("tiltix080");
    rig.cut = Some(30);
    let ended = rig.tool("--mac 63 watch --every 10 --cyclic --seconds 5");
    assert_eq!(ended.code, 4, "{ended:?}");
    assert!(
        ended.notes.contains("releases the connection by itself"),
        "{ended:?}"
    );
    rig.cut = None;
    send(&mut rig, &[]);
    rig.run(11_000);
    own(&mut rig);
}

#[test]
fn connection_of_an_earlier_run_is_taken_over() {
    let mut rig = Rig::with("tiltix080");
    rig.cut = Some(30);
    rig.tool("--mac 63 watch --every 10 --cyclic --seconds 5");
    rig.cut = None;
    let ended = rig.tool("--mac 63 watch --every 10 --cyclic --seconds 1");
    assert_eq!(lost(&ended)[0], 0, "{ended:?}");
    own(&mut rig);
}

#[test]
fn response_with_one_angle_has_one_column() {
    let mut rig = Rig::with("tiltix080");
    rig.done("--mac 63 set polled-assembly-instance=raw:102");
    let out = rig.done("--json --mac 63 watch --cyclic --every 20 --seconds 1");
    let first = out.lines().next().unwrap();
    assert!(
        first.contains("slope-lateral16") && !first.contains("slope-long16"),
        "{first}"
    );
    let mut rig = Rig::with("tiltix360");
    rig.done("--mac 63 set polled-assembly-instance=raw:102");
    assert_eq!(
        rig.fails("--mac 63 watch --cyclic --seconds 1"),
        (1, "not-offered".to_owned())
    );
    own(&mut rig);
}

#[test]
fn polls_without_a_response_are_counted() {
    let mut rig = Rig::with("tiltix080");
    let now = rig.bus.borrow().now();
    rig.deaf = Some((now + millis(3000), now + millis(3600)));
    let ended = rig.tool("--mac 63 watch --every 20 --cyclic --seconds 4");
    let [missing, all] = lost(&ended);
    assert!((29..=31).contains(&missing), "{}", ended.notes);
    assert!((198..=201).contains(&all), "{}", ended.notes);
}

#[test]
fn slave_of_another_master_is_only_listened_to() {
    let mut rig = Rig::with("tiltix080");
    own(&mut rig);
    rig.cyclic = Some((20, Frame::data(standard(POLL), &[]).unwrap()));
    for options in ["--mac 63 --product tiltix080", "--product tiltix080"] {
        rig.witnessed();
        let ended = rig.tool(&format!("{options} watch --cyclic --seconds 2"));
        let [missing, all] = lost(&ended);
        assert!(missing == 0 && (95..=101).contains(&all), "{ended:?}");
        assert!(ended.notes.contains("nothing is sent"), "{ended:?}");
        assert!(ended.out.contains("slope-long16"), "{ended:?}");
        let seen = texts(&rig.witnessed());
        let is_foreign = |frame: &String| frame == "5FD#" || frame.starts_with("3FF#");
        assert!(seen.iter().all(is_foreign), "{seen:?}");
    }
    // The user must give the product, and polling by explicit messages is refused.
    rig.witnessed();
    for command in [
        "--mac 63 watch --cyclic",
        "--mac 63 --product tiltix080 watch",
    ] {
        assert_eq!(
            rig.fails(&format!("{command} --seconds 1")),
            (1, "owned".to_owned())
        );
    }
}

#[test]
fn cyclic_messages_to_another_master_are_listened_to() {
    let mut rig = Rig::with("tiltix080");
    // Explicit, and cyclic without acknowledgement, every 50 ms.
    send(
        &mut rig,
        &[
            (UNCONNECTED, &[0x0A, 0x4B, 3, 1, 0x61, 0x0A]),
            (REQUEST, &[0x0A, 0x10, 5, 1, 9, 0, 0]),
            (REQUEST, &[0x0A, 0x10, 5, 4, 9, 50, 0]),
        ],
    );
    rig.witnessed();
    let ended = rig.tool("--mac 63 --product tiltix080 watch --cyclic --seconds 2");
    let [missing, all] = lost(&ended);
    assert!(missing == 0 && (39..=41).contains(&all), "{ended:?}");
    // The same identifier can carry changes only, so it has no period.
    assert!(ended.notes.contains("come without a period"), "{ended:?}");
    let seen = texts(&rig.witnessed());
    assert!(
        seen.iter().all(|frame| frame.starts_with("37F#")),
        "{seen:?}"
    );
}

#[test]
fn silent_slave_of_another_master_is_refused() {
    let mut rig = Rig::with("tiltix080");
    own(&mut rig);
    assert_eq!(
        rig.fails("--mac 63 --product tiltix080 watch --cyclic --seconds 1"),
        (1, "owned".to_owned())
    );
    // It was asked for an allocation, once, and refused.
    assert_eq!(allocations(&mut rig), ["4B0301013E"]);
}
