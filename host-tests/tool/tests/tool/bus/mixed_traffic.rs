//! Mixed traffic of all four protocols on one bus, by sensors and their masters: the values that `decode` shows are those of cantools
//! with the databases of this project, and those of the dissectors of Wireshark.

use super::rig::{Rig, file};
use bench::scene::{Axes, Scene};
use bench::{AdapterId, BusRate, Device, Flash, Geometry, NodeType};
use host_tests::{effort, python};
use plumbline::can::BitRate;
use plumbline::model::catalog;
use std::io::{Write, stderr};
use std::process::Command;
use std::time::Duration;

/// The simulated time in s: at least one round, and ten minutes.
const SHORT: u64 = 1;
const LONG: u64 = 600;

/// The pause behind a frame of the other masters, in ms.
const PAUSE: u32 = 15;

/// A round: commands of the tool, and then frames of other masters, one in each pause. `-` is a pause without a frame.
const ROUND: [(&[&str], &str); 5] = [
    (
        &[
            "--id 300 get",
            "--id 300 set cut-off=5Hz filter-type=butterworth zero-x=1.25deg cyclic-time=40ms",
            "--id 300 set cyclic-mode=on",
        ],
        "000#0100 080#01 080#02 100# 080# 300#02 300#03 300#04 300#2500 300#77 300#29 300#40 100#",
    ),
    (
        &[
            "--node 10 get",
            "--node 10 set heartbeat-interval-time=300ms filter=1Hz tpdo1-event-timer=100ms tpdo2-event-timer=200ms",
            "--node 10 restart",
            "--node 50 get",
            "--node 50 set producer-heartbeat-time=700ms",
        ],
        "60A#4000100055000000 60A#4000990000000000 60A#2F00100001000000 60A#4010600000000000
        632#A40810007F000000 632#A300000000000000 632#A2017F0000000000 632#A100000000000000
        632#C617100002000000 632#81F4010000000000 632#D525CF0000000000
        632#C617100002000000 632#81F4010000000000 632#D524CF0000000000
        632#2310320010270000 - - - - 632#4010610000000000 632#4001100000000000 632#4003100100000000
        632#2310320000000000 -
        7E5#4095010000000000 7E5#419F860100000000 7E5#4200000000000000 7E5#4301000000000000
        7E5#5A00000000000000 7E5#5B00000000000000 7E5#5C00000000000000 7E5#5D00000000000000
        7E5#5E00000000000000 7E5#117F000000000000 7E5#1300080000000000 7E5#1132000000000000
        7E5#1700000000000000 7E5#0400000000000000 7E5#5100000000800000",
    ),
    (
        &[
            "--mac 63 --product tiltix080 get",
            "--mac 63 --product tiltix080 set resolution=0.1deg polled-assembly-instance=raw:101",
            "--mac 63 --product tiltix080 watch --cyclic --every 50 --seconds 1",
            "--mac 63 --product tiltix080 set resolution=0.01deg polled-assembly-instance=raw:103",
            "--mac 63 --product tiltix080 watch --cyclic --every 20 --seconds 1",
        ],
        "5FF#00620199000000 5FE#0A4B0301010A 5FC#0A100501090000 5FC#0A0E010101 5FC#0A0E010107 5FC#0AC0 5FC#8AC0
        5FC#0A0E010106 5FC#0A0E650171 5FC#0A0E650163 5FC#0A106501717777 5FC#0A0E640102
        5FC#8A00106501 5FC#8A41710A 5FC#8A8200
        5FE#0A4B0301120A 5FC#0A10050209E803 5FD# 5FC#0A100504090000 5FC#0A1065017302 5FA#
        5FE#0A4C030113",
    ),
    (
        &[
            "--address 128 get",
            "--address 128 set transmission-rate-ssi2=100ms transmission-rate-ssi=200ms",
            "--address 128 set transmission-rate-ari=250ms transmission-rate-accs=300ms",
        ],
        "18EAFF21#00EE00 18EA8021#29F000 18EA8021#DAFE00 18EA8021#CAFE00 18EA8021#FEFE00
        18EEFF21#0203E0FF0081A0B0 18EA8021#EBFE00 1CEC8021#110301FFFFEBFE00 - - 1CEC8021#13140003FFEBFE00
        18EAFF21#EBFE00 - - - - - - - - - - - - - -
        18EF8021#4018100100000000 18EF8021#4000990000000000 18EF8021#2310320010270000
        18EF8021#23203200E4DAFFFF - - - - - - - - - - - - - - -
        18EF8021#2310320000000000 18EF8021#2320320000000000
        18E8FF21#02FFFFFF80EBFE00 18E8FF21#03FFFFFF80EBFE00",
    ),
    (&["scan"], ""),
];

/// Sensors of all four protocols that are on-line, and the adapter of the other masters.
fn sensors() -> (Rig, AdapterId) {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K125));
    rig.rate = Some("125");
    rig.says_yes = true;
    let master = rig.bus.borrow_mut().adapter();
    rig.bus
        .borrow_mut()
        .open(master, Some(BitRate::K125), false);
    let attach = |rig: &mut Rig, product: &str, serial| {
        let node_type = NodeType::find(product).expect("a product");
        let motion = Box::new(Scene::sway(Axes::of(&node_type)));
        let flash = Flash::blank(Geometry::STM32F103);
        rig.attach_sensor(Device::new(&node_type, serial, flash, motion));
        rig.run(2500);
    };
    attach(&mut rig, "ims360", 2);
    for command in ["raw 3100:1=01", "save", "restart"] {
        rig.done(&format!("--node 50 {command}"));
    }
    for product in ["is2", "jn2101", "ims360", "tiltix080"] {
        attach(&mut rig, product, 1);
    }
    (rig, master)
}

/// The frames of the round, and of the next ones until this simulated time in s.
fn traffic(seconds: u64) -> String {
    let (mut rig, master) = sensors();
    rig.bus.borrow_mut().take_log();
    let end = rig.bus.borrow().now().ticks() + seconds * 1_000_000;
    let mut log = String::new();
    while rig.bus.borrow().now().ticks() < end {
        for (commands, frames) in ROUND {
            for command in commands {
                let ended = rig.tool(command);
                assert_eq!(ended.code, 0, "{command}: {ended:?}");
            }
            for text in frames.split_whitespace() {
                if text != "-" {
                    let frame = can_wire::text::frame(text);
                    rig.bus.borrow_mut().send(master, frame);
                }
                rig.run(PAUSE);
            }
        }
        for logged in rig.bus.borrow_mut().take_log() {
            let time = Duration::from_micros(logged.at.ticks());
            log += &can_wire::text::log_line(time, "can0", &logged.frame);
            log.push('\n');
        }
    }
    log
}

#[test]
fn values_of_mixed_traffic_are_those_of_cantools_and_wireshark() {
    let log = traffic(effort::choose(SHORT, LONG));
    let path = file("mixed.log");
    std::fs::write(&path, log).expect("a file");
    let ended = Rig::with("is2").tool(&format!("--json decode {}", path.display()));
    assert_eq!(ended.code, 0, "{}", ended.notes);
    let decoded = file("mixed.json");
    std::fs::write(&decoded, ended.out).expect("a file");
    for product in ["is2", "ims360"] {
        let product = catalog::find(product).expect("a product");
        for sheet in descriptors::describe_all(product) {
            std::fs::write(file(&sheet.name), sheet.text).expect("a file");
        }
    }
    let installed = Command::new("tshark").arg("--version").output().is_ok();
    if !installed && std::env::var_os("CI").is_none() {
        // Written directly to standard error, which the test harness does not capture.
        let _ = writeln!(stderr(), "skipped: decode_check.py: no tshark");
        return;
    }
    let folder = path.parent().expect("a folder").display().to_string();
    python::run("decode_check.py", &["cantools"], &["--folder", &folder]);
}
