//! `decode`: what the frames of a log are.

use super::rig::{Rig, file};
use plumbline::can::{CanId, Frame};
use plumbline::model::catalog::PRODUCTS;
use plumbline_tool::decode::Bus;
use plumbline_tool::master::Protocol;
use serde_json::Value;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

/// A log with these frames.
pub(super) fn log(name: &str, frames: impl IntoIterator<Item = Frame>) -> PathBuf {
    let path = file(&format!("{name}.log"));
    let lines = frames.into_iter().zip(0..);
    let lines = lines.map(|(frame, place)| format!("({place}.000000) can0 {frame:?}\n"));
    std::fs::write(&path, lines.collect::<String>()).unwrap();
    path
}

/// The documents of the frames of a log.
fn documents(rig: &mut Rig, path: &std::path::Path) -> Vec<Value> {
    let ended = rig.tool(&format!("--json decode {}", path.display()));
    assert_eq!(ended.code, 0, "{ended:?}");
    let lines = ended.out.lines();
    lines
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

/// What the frames with these texts are, without the frames.
fn decoded(options: &str, frames: &[&str]) -> Vec<String> {
    // Tests run at once, each with its own file.
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let name = format!("decoded-{}", NEXT.fetch_add(1, Ordering::Relaxed));
    let frames = frames.iter().map(|text| can_wire::text::frame(text));
    let path = log(&name, frames);
    let mut rig = Rig::with("is2");
    let lines = rig.done(&format!("{options} decode {}", path.display()));
    let behind = |line: &str| line.split_once("  ").map(|(_, text)| text.to_owned());
    lines
        .lines()
        .map(|line| behind(line).unwrap_or_default())
        .collect()
}

#[test]
fn frames_of_get_have_the_values_that_get_shows() {
    for product in PRODUCTS {
        let mut rig = Rig::with(product.name);
        let got = rig.json("get");
        let frames = rig.witnessed();
        let path = log(&format!("get-{}", product.name), frames);
        let documents = documents(&mut rig, &path);
        assert_eq!(documents[0]["time"], 0.0);
        let last = documents.last().unwrap();
        assert_eq!(last["protocol"], Protocol::of(product).name, "{last}");
        assert_eq!(last["product"], product.name, "{last}");
        for (name, value) in got.as_object().unwrap() {
            let mut values = documents.iter().map(|document| &document["values"][name]);
            assert!(
                values.any(|own| own["value"] == value["value"] && own["unit"] == value["unit"]),
                "{} {name}: {value}",
                product.name
            );
        }
    }
}

#[test]
fn messages_of_gemac_have_the_names_of_the_codes() {
    let lines = decoded(
        "--product is2",
        &[
            "301#FF03000300004403",
            "301#FF03000300004403",
            "300#253200",
            "301#2502",
            "301#0002E803F4010100",
        ],
    );
    let boot_up = "fsc 300h is2: boot-up, status = DefaultParam + AutobaudDetection, set-id = 300h, software-version = 3.44";
    let expected = [
        boot_up,
        boot_up,
        "fsc 300h is2: write Cyclic Time (25h), cyclic-time = 50 ms",
        "fsc 300h is2: reply Cyclic Time (25h), status = AutobaudDetection",
        "fsc 300h is2: reply Inclination (00h), status = AutobaudDetection, angle-x = 10.00 deg, angle-y = 5.00 deg, counter = 1",
    ];
    assert_eq!(lines, expected);
}

/// A code that the sensor does not have, and an update: the frames of its bootloader are full, and have no codes.
#[test]
fn sensor_is_known_after_a_refused_code_and_after_its_bootloader() {
    let frames = [
        "311#FF03100300004403",
        "311#FF03100300004403",
        "310#99",
        "311#9908",
        "310#60464C415348",
        "311#6000",
        "310#2F511F0103000000",
        "311#60511F0100000000",
        "310#0001020304050607",
        "311#FF03100300004403",
        "311#FF03100300004403",
        "310#60",
        "311#600001020304",
    ];
    let lines = decoded("", &frames);
    let boot_up = "fsc 310h: boot-up, status = DefaultParam + AutobaudDetection, set-id = 310h, software-version = 3.44";
    let expected = [
        boot_up,
        boot_up,
        "fsc 310h: request code 99h",
        "fsc 310h: reply code 99h, status = CmdParamError",
        "fsc 310h: request update (60h), data = 46 4C 41 53 48",
        "fsc 310h: reply update (60h), status = ok",
        "fsc 310h: bootloader request, data = 2F 51 1F 01 03 00 00 00",
        "fsc 310h: bootloader answer, data = 60 51 1F 01 00 00 00 00",
        "fsc 310h: bootloader request, data = 00 01 02 03 04 05 06 07",
        boot_up,
        boot_up,
        "fsc 310h: request update (60h)",
        "fsc 310h: reply update (60h), status = ok, data = 01 02 03 04",
    ];
    assert_eq!(lines, expected);
}

#[test]
fn messages_of_canopen_have_names_and_values() {
    let lines = decoded(
        "",
        &[
            "70A#00",
            "60A#4018100100000000",
            // The product is known from here on, and because of the first reading of the log in all frames.
            "58A#431810010069666D",
            "000#010A",
            "080#",
            "70A#05",
            "18A#E803F401",
            "60A#2F00100001000000",
            "58A#8000100002000106",
            "08A#0000000000000000",
            "7E5#0401000000000000",
        ],
    );
    let expected = [
        "canopen 10 jn2101: boot-up",
        "canopen 10 jn2101: SDO read 1018h:1 vendor-id",
        "canopen 10 jn2101: SDO answer 1018h:1 vendor-id, value = 6D666900h",
        "canopen 10: NMT start",
        "canopen: SYNC",
        "canopen 10 jn2101: heartbeat, operational",
        "canopen 10 jn2101: TPDO 1, slope-long16 = 10.00 deg, slope-lateral16 = 5.00 deg",
        "canopen 10 jn2101: SDO write 1000h:0 device-type, value = 01h",
        "canopen 10 jn2101: SDO abort 1000h:0 device-type, reason = the object can only be read (06010002h)",
        "canopen 10 jn2101: EMCY, error = no error (0000h), error-register = 00h, data = 00 00 00 00 00",
        "canopen: LSS switch state global, state = configuration",
    ];
    assert_eq!(lines, expected);
}

/// CiA 301, 7.2.4.3.8 to 7.2.4.3.16. A segment of the write is lost, so the next block has the rest.
#[test]
fn block_transfers_have_the_values_of_all_segments() {
    let lines = decoded(
        "--product ims360",
        &[
            "632#A40810007F000000",
            "5B2#C608100006000000",
            "632#A300000000000000",
            "5B2#81494D5333363000",
            "632#A2017F0000000000",
            "5B2#C592F90000000000",
            "632#A100000000000000",
            "632#C60A100009000000",
            "5B2#A40A10001F000000",
            "632#0141424344454647",
            "632#8348490000000000",
            "5B2#A2011F0000000000",
            "632#8148490000000000",
            "5B2#A2011F0000000000",
            "632#D534120000000000",
            "5B2#A100000000000000",
        ],
    );
    let expected = [
        "SDO block read 1008h:0 manufacturer-device-name, block-size = 127",
        "SDO block answer 1008h:0 manufacturer-device-name, in segments, size = 6",
        "SDO block read 1008h:0 manufacturer-device-name, start",
        "SDO block answer 1008h:0 manufacturer-device-name, segment 1, data = 49 4D 53 33 36 30 00",
        "SDO block read 1008h:0 manufacturer-device-name, segments accepted, segments = 1, block-size = 127",
        "SDO block answer 1008h:0 manufacturer-device-name, end of data, manufacturer-device-name = IMS360, crc = F992h",
        "SDO block read 1008h:0 manufacturer-device-name, end",
        "SDO block write 100Ah:0 manufacturer-software-version, size = 9",
        "SDO block write accepted 100Ah:0 manufacturer-software-version, block-size = 31",
        "SDO block write 100Ah:0 manufacturer-software-version, segment 1, data = 41 42 43 44 45 46 47",
        "SDO block write 100Ah:0 manufacturer-software-version, segment 3, data = 48 49 00 00 00 00 00",
        "SDO block write 100Ah:0 manufacturer-software-version, segments accepted, segments = 1, block-size = 31",
        "SDO block write 100Ah:0 manufacturer-software-version, segment 1, data = 48 49 00 00 00 00 00",
        "SDO block write 100Ah:0 manufacturer-software-version, segments accepted, segments = 1, block-size = 31",
        "SDO block write 100Ah:0 manufacturer-software-version, end of data, manufacturer-software-version = ABCDEFGHI, crc = 1234h",
        "SDO block write 100Ah:0 manufacturer-software-version, done",
    ];
    let start = "canopen 50 ims360: ";
    let lines: Vec<&str> = lines
        .iter()
        .map(|line| line.strip_prefix(start).unwrap_or(line))
        .collect();
    assert_eq!(lines, expected);
}

#[test]
fn messages_of_devicenet_have_the_names_of_their_objects() {
    let lines = decoded(
        "--product tiltix080",
        &[
            "5FF#00620101000000",
            "5FC#3E0E650171",
            "5FB#3E8E0A00",
            "5FC#3E0E650101",
            "5FB#3E9414FF",
            "5FD#",
            "3FF#E803F401",
        ],
    );
    let expected = [
        "devicenet 63 tiltix080: duplicate MAC ID check, request, vendor = 354, serial-number = 1",
        "devicenet 63 tiltix080: explicit request, get class 65h instance 1 attribute 113 resolution",
        "devicenet 63 tiltix080: explicit response, get class 65h instance 1 attribute 113 resolution, resolution = 0.01 deg",
        "devicenet 63 tiltix080: explicit request, get class 65h instance 1 attribute 1",
        "devicenet 63 tiltix080: explicit response, error, reason = there is no such attribute (14h, FFh)",
        "devicenet 63 tiltix080: poll",
        "devicenet 63 tiltix080: poll response (Slope long16, slope lateral16), slope-long16 = 10.00 deg, slope-lateral16 = 5.00 deg",
    ];
    assert_eq!(lines, expected);
}

#[test]
fn messages_of_j1939_have_groups_and_long_ones_their_content() {
    let lines = decoded(
        "",
        &[
            "18EAFFFE#00EE00",
            "18EEFF80#0100E0FF00810080",
            "0CF02980#852B8300807AFFFF",
            "18FECA80#04FF6F130201FFFF",
            "1CECFF80#200A0002FFEBFE00",
            "1CEBFF80#0141422A43444546",
            "1CEBFF80#02472A2AFFFFFFFF",
            "18EF8021#4018100100000000",
            "18EF2180#8018100111000906",
        ],
    );
    let expected = [
        "j1939 254: request, group = address claimed (EE00h)",
        "j1939 128: address claimed, arbitrary-address = 1, industry-group = 0, vehicle-system-instance = 0, vehicle-system = 0, function = 129, function-instance = 0, ecu-instance = 0, manufacturer = 2047, identity-number = 1",
        "j1939 128: SSI2 (F029h), PitchAngleExRange (SPN 4976) = 12.3400 deg, RollAngleExRange (SPN 4977) = -5.0000 deg, PitchAngleExRangeCompensation (SPN 4978) = not available, PitchAngleExRangeFigureOfMerit (SPN 4979) = not available, RollAngleExRangeCompensation (SPN 4980) = not available, RollAngleExRangeFigureOfMerit (SPN 4981) = not available, RollAndPitchExRangeLatency (SPN 4982) = not available",
        "j1939 128: DM1 (FECAh), lamps = 04h, SPN 4975 = FMI 2, 1 times",
        "j1939 128: TP.CM announcement, group = component identification (FEEBh), size = 10, packets = 2",
        "j1939 128: TP.DT packet 1, data = 41 42 2A 43 44 45 46",
        "j1939 128: TP.DT packet 2, end of component identification (FEEBh), text = AB*CDEFG**",
        "j1939 33: SDO read 1018h:1 vendor-id to 128",
        "j1939 128: SDO abort 1018h:1 vendor-id to 33, reason = there is no such sub-index (06090011h)",
    ];
    assert_eq!(lines, expected);
}

#[test]
fn node_of_one_protocol_does_not_get_the_frames_of_another_one() {
    // The response of MAC ID 63 has the identifier and the form of an SDO answer of node 123.
    let frames = [
        "70A#05",
        "5FF#00620101000000",
        "5FB#438E010203040506",
        "18A#E803F401",
    ];
    let lines = decoded("", &frames);
    let protocols = lines.iter().map(|line| line.split(' ').next().unwrap());
    let protocols: Vec<&str> = protocols.collect();
    assert_eq!(protocols, ["canopen", "devicenet", "devicenet", "canopen"]);
}

/// The pitch of SSI is not available, so the frame has the form of a boot-up message with the Set-Parameter-ID 01B6FFFFh.
#[test]
fn group_of_j1939_with_a_value_that_is_not_available_is_no_boot_up() {
    for line in decoded("", &["0CF01380#FFFFFFFFB681CFFF"; 3]) {
        assert!(line.starts_with("j1939 128: SSI (F013h)"), "{line}");
    }
}

/// Twice the same values of ACCS have the form of two boot-up messages.
#[test]
fn group_of_j1939_with_changing_values_is_no_boot_up() {
    let frames = [
        "0CF02D80#A87C627DD080C0FF",
        "0CF02D80#FF7C627DD080C0FF",
        "0CF02D80#FF7C627DD080C0FF",
        "0CF02D80#507DB77CCD80C0FF",
    ];
    for line in decoded("", &frames) {
        assert!(line.starts_with("j1939 128: ACCS (F02Dh)"), "{line}");
    }
}

#[test]
fn file_without_a_frame_is_refused_and_a_wrong_line_is_left_out() {
    let path = file("decode-lines.log");
    let mut rig = Rig::with("is2");
    let command = format!("decode {}", path.display());
    for text in [
        "",
        "can0 123#00\n",
        "(1.0) can0 12345#00\n",
        "(1.0) can0 123##0FF\n",
        "(1.0)\n",
    ] {
        std::fs::write(&path, text).unwrap();
        assert_eq!(rig.fails(&command), (2, "bad-file".to_owned()), "{text}");
    }
    std::fs::write(&path, b"\xFF\n\n(1.0) can0 123#00 R // text\n").unwrap();
    let ended = rig.tool(&command);
    assert_eq!((ended.code, &*ended.out), (0, "(1.0) can0 123#00\n"));
    assert!(
        ended.notes.contains("skipped: 1 line of the log"),
        "{ended:?}"
    );
    std::fs::remove_file(&path).unwrap();
    assert_eq!(rig.fails(&command), (4, "no-file".to_owned()));
}

#[test]
fn documents_of_a_log_are_read_as_a_log() {
    let path = log("documents", ["70A#05", "60A#R4"].map(can_wire::text::frame));
    let mut rig = Rig::with("is2");
    let text = rig.done(&format!("decode {}", path.display()));
    let documents = rig.tool(&format!("--json decode {}", path.display())).out;
    std::fs::write(&path, documents).unwrap();
    assert_eq!(rig.done(&format!("decode {}", path.display())), text);
    for text in [
        "{",
        "{}",
        "{\"time\":-1.0,\"frame\":\"70A#05\"}",
        "{\"time\":\"1\",\"frame\":\"70A#05\"}",
        "{\"time\":1.0,\"frame\":\"70A\"}",
    ] {
        std::fs::write(&path, text).unwrap();
        let failed = rig.fails(&format!("decode {}", path.display()));
        assert_eq!(failed, (2, "bad-file".to_owned()), "{text}");
    }
}

#[test]
fn log_decodes_what_it_hears() {
    let mut rig = Rig::with("jn2101");
    let first = rig.first();
    let at = rig.later(100);
    rig.power_cycle_at(at, first);
    let path = file("decoded-live.log");
    rig.done(&format!("log {} --decode --seconds 5", path.display()));
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(
        text.contains(" can0 70A#00  canopen 10: boot-up\n"),
        "{text}"
    );
    // The tool reads its own lines.
    let again = rig.done(&format!("decode {}", path.display()));
    assert_eq!(again.lines().count(), text.lines().count());
}

/// Random frames, of which half have the identifier or the beginning of a request that a protocol knows.
#[test]
fn random_frames_of_all_lengths_are_decoded_without_a_panic() {
    const IDS: [u32; 16] = [
        0x000, 0x080, 0x08A, 0x18A, 0x28A, 0x300, 0x301, 0x3F7, 0x3FF, 0x41F, 0x58A, 0x60A, 0x70A,
        0x7E4, 0x7E5, 0x7FF,
    ];
    const GROUPS: [u32; 8] = [
        0x18EA_FF21,
        0x18EE_FF80,
        0x18EF_8021,
        0x18EF_2180,
        0x18EC_FF80,
        0x18EB_FF80,
        0x0CF0_2980,
        0x18FE_CA80,
    ];
    const BEGINS: [u8; 16] = [
        0x00, 0x0A, 0x0E, 0x10, 0x20, 0x21, 0x23, 0x40, 0x43, 0x4B, 0x60, 0x80, 0x8E, 0xA0, 0xC0,
        0xFF,
    ];
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut random = move |below: u32| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 32) as u32 % below
    };
    let mut bus = Bus::new();
    let mut known = 0;
    for _ in 0..100_000 {
        let id = match random(4) {
            0 => CanId::standard(random(0x800) as u16),
            1 => CanId::standard(IDS[random(16) as usize] as u16),
            2 => CanId::extended(random(0x2000_0000)),
            _ => CanId::extended(GROUPS[random(8) as usize]),
        };
        let mut bytes: [u8; 8] = std::array::from_fn(|_| random(256) as u8);
        if random(2) == 0 {
            bytes[0] = BEGINS[random(16) as usize];
        }
        let frame = Frame::of(id, bytes, random(9) as u8);
        if let Some(decoded) = bus.decode(&frame) {
            known += 1;
            let _ = (decoded.to_string(), decoded.json());
        }
    }
    assert!(known > 10_000, "{known}");
}

/// The first reading would take what is in a pipe, and the second one would wait without end.
#[cfg(unix)]
#[test]
fn log_that_is_no_regular_file_is_refused_at_once() {
    let pipe = file("pipe.log");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.unwrap().success());
    let pipe = pipe.display().to_string();
    for path in ["/dev/zero", &pipe] {
        for command in ["decode", "replay"] {
            let ended = Rig::with("is2").tool(&format!("{command} {path}"));
            let refused = ended.notes.contains("not a regular file");
            assert!(ended.code == 4 && refused, "{command} {path}: {ended:?}");
        }
    }
}
