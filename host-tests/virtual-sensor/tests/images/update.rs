//! An update of a sensor with `--bootloader` and `--key`.

use crate::process::client::{Client, advance};
use crate::process::sensor::Sensor;
use crate::process::{assert_fails, new_path, text};
use host_tests::python;
use plumbline::model::catalog::find;
use std::fs;
use std::net::TcpStream;
use stm32_sim::board::Board;
use stm32_sim::{firmware, image_file};

/// A version above that of the programs here.
const NEWER: u32 = 0xFFFF_0000;

/// A jn2101 behind a bootloader, with the time of its client. The node-ID is that as delivered.
struct Updated {
    _sensor: Sensor,
    client: Client<TcpStream>,
}

impl Updated {
    fn start(options: &[&str]) -> Self {
        let own = [
            "--model",
            "jn2101",
            "--bus-rate",
            "125",
            "--clock",
            "client",
        ];
        let sensor = Sensor::start(&[&own[..], options].concat());
        let client = Client::open(&sensor);
        let mut own = Self {
            _sensor: sensor,
            client,
        };
        own.wait("t70A");
        own
    }

    /// Advances the time until a frame with this beginning.
    #[track_caller]
    fn wait(&mut self, beginning: &str) -> String {
        for _ in 0..2000 {
            let (lines, _) = advance(&mut self.client, 1000);
            let mut lines = lines.into_iter();
            if let Some(line) = lines.find(|line| line.starts_with(beginning)) {
                return line;
            }
        }
        panic!("no line starts with {beginning}");
    }

    /// Sends a request of SDO, and returns the reply.
    #[track_caller]
    fn ask(&mut self, request: &[u8]) -> String {
        let hex: String = request.iter().map(|byte| format!("{byte:02X}")).collect();
        self.client.expect(&format!("t60A8{hex:0<16}"), "z");
        self.wait("t58A8")[5..21].to_owned()
    }

    /// Writes 1F51h:01.
    #[track_caller]
    fn control(&mut self, value: u8) {
        let reply = self.ask(&[0x2F, 0x51, 0x1F, 1, value]);
        assert_eq!(reply, "60511F0100000000");
    }

    /// Restarts the program into the bootloader.
    fn enter(&mut self) {
        self.control(0);
        self.wait("t70A");
        self.control(3);
    }

    /// Starts the program, which has the profile CiA 410.
    #[track_caller]
    fn starts(&mut self) {
        self.control(1);
        self.wait("t70A");
        let device_type = self.ask(&[0x40, 0x00, 0x10]);
        assert_eq!(&device_type[..12], "430010009A01");
    }

    /// Sends a file in segments; returns the abort of the bootloader.
    fn download(&mut self, file: &[u8]) -> Result<(), String> {
        let length = (file.len() as u32).to_le_bytes();
        let first = [&[0x21, 0x50, 0x1F, 1], &length[..]].concat();
        let mut reply = self.ask(&first);
        let pieces = file.chunks(7);
        let last = pieces.len() - 1;
        for (number, piece) in pieces.enumerate() {
            if reply.starts_with("80") {
                return Err(reply);
            }
            let toggle = (number % 2) as u8 * 0x10;
            let end = (7 - piece.len() as u8) << 1 | u8::from(number == last);
            reply = self.ask(&[&[toggle | end], piece].concat());
        }
        assert!(matches!(&reply[..1], "2" | "3"), "{reply}");
        Ok(())
    }
}

/// The program runs after each refused file: nothing was erased.
#[test]
fn sensor_with_a_key_takes_only_a_program_with_its_signature() {
    let mut built = firmware::build_with_signatures(Board::BluePill, &["bootloader"]).unwrap();
    let program = firmware::build_behind_bootloader(Board::BluePill, &["jn2101"]);
    built.extend(program.expect("it builds"));
    let unsigned = image_file::small(find("jn2101").unwrap(), NEWER).unwrap();
    let (signed, key) = image_file::sign(&unsigned, &[1; 16]).unwrap();
    let (foreign, _) = image_file::sign(&unsigned, &[2; 16]).unwrap();
    let path = new_path("own-key.bin");
    fs::write(&path, key.bytes()).expect("a folder");
    let mut sensor = Updated::start(&[
        "--bootloader",
        text(&built["bootloader"]),
        "--elf",
        text(&built["jn2101"]),
        "--key",
        text(&path),
    ]);
    for refused in [unsigned, foreign] {
        sensor.enter();
        let abort = "80501F0121000008";
        assert_eq!(sensor.download(&refused), Err(abort.to_owned()));
        sensor.starts();
    }
    sensor.enter();
    assert_eq!(sensor.download(&signed), Ok(()));
    let crc = sensor.ask(&[0x40, 0x56, 0x1F, 1]);
    let own: String = signed[20..24]
        .iter()
        .map(|it| format!("{it:02X}"))
        .collect();
    assert_eq!(crc, format!("43561F01{own}"));
}

#[test]
fn key_without_a_bootloader_that_checks_signatures_is_refused() {
    let mut built = firmware::build(Board::BluePill, &["bootloader"]).expect("it builds");
    let own = built.remove("bootloader").expect("the bootloader");
    let path = new_path("some-key.bin");
    fs::write(&path, [1; 56]).expect("a folder");
    let line = ["--model", "jn2101", "--key", text(&path)];
    assert_fails(&line, 2, &["--bootloader <FILE>"]);
    let line = [&line[..], &["--bootloader", text(&own)]].concat();
    assert_fails(&line, 2, &["--features signature"]);
    fs::write(&path, [1; 57]).expect("a folder");
    assert_fails(&line, 2, &["is not a public key of 56 bytes"]);
}

#[test]
fn python_canopen_loads_a_program_by_blocks_and_in_segments() {
    let image = new_path("jn2101.plu");
    let file = image_file::small(find("jn2101").expect("a product"), 1);
    fs::write(&image, file.expect("a file")).expect("a file");
    let built = firmware::build(Board::BluePill, &["bootloader"]).expect("it builds");
    let arguments = [
        ["--virtual-sensor", env!("CARGO_BIN_EXE_virtual-sensor")],
        ["--bootloader", text(&built["bootloader"])],
        ["--image", text(&image)],
    ];
    let modules = ["can", "canopen", "serial"];
    python::run("update_client.py", &modules, &arguments.concat());
}
