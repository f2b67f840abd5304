//! `plumbline update`: the program of a sensor with a bootloader, on the simulated microcontroller.

mod hardware;

use crate::rig::{Rig, tilted};
use bench::{BusRate, Flash};
use host_tests::effort;
use plumbline::can::BitRate;
use plumbline::model::catalog::find;
use plumbline::update::header::SIZE;
use plumbline::update::layout::BLUEPILL;
use plumbline::update::{Contents, Element, Header, Layout};
use plumbline_tool::image::ImageFile;
use plumbline_tool::signing::KeyFile;
use serde_json::json;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::OnceLock;
use stm32_sim::Microcontroller;
use stm32_sim::board::Board;
use stm32_sim::elf::Image;
use stm32_sim::firmware;

pub const SERIAL: u32 = 7;

/// The name of the bootloader that checks signatures.
const SIGNED: &str = "bootloader with signatures";

/// The ELF file of the bootloader, or of a program behind it.
pub fn elf(name: &str) -> &'static [u8] {
    static FILES: OnceLock<BTreeMap<String, Vec<u8>>> = OnceLock::new();
    let files = FILES.get_or_init(|| {
        let mut built = firmware::build(Board::BluePill, &["bootloader"]).expect("it builds");
        let signed = firmware::build_with_signatures(Board::BluePill, &["bootloader"]);
        let signed = signed.expect("it builds").into_values();
        built.extend(signed.map(|path| (SIGNED.to_owned(), path)));
        let programs = ["is2", "jn2101", "tiltix080"];
        let programs = firmware::build_behind_bootloader(Board::BluePill, &programs);
        built.extend(programs.expect("it builds"));
        let read = |path| fs::read(path).expect("the image can be read");
        let files = built.into_iter();
        files.map(|(name, path)| (name, read(path))).collect()
    });
    files.get(name).expect("an image of this name")
}

/// The bootloader that checks signatures, without a key.
pub fn signed_bootloader() -> Image {
    Image::parse(elf(SIGNED)).unwrap()
}

/// A folder of a test with the image file of a program that is newer by this number of versions, or older.
pub struct Files {
    folder: PathBuf,
    product: &'static str,
}

impl Files {
    pub fn new(product: &'static str, test: &str) -> Self {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("update-{test}"));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        Self { folder, product }
    }

    /// The program with four more bytes and this difference of its version.
    pub fn image(&self, difference: i32) -> PathBuf {
        self.image_for(difference, &BLUEPILL, Element::Ism330dhcx)
    }

    /// The same, for a board and a measuring element.
    fn image_for(&self, difference: i32, board: &Layout, element: Element) -> PathBuf {
        let own = ImageFile::of(elf(self.product)).unwrap();
        let mut body = own.bytes[SIZE..].to_vec();
        body.extend(difference.to_le_bytes());
        let contents = Contents {
            product: own.header.product(),
            element,
            board: board.board,
            layout: board.number,
            key: 0,
            version: own.header.version().saturating_add_signed(difference),
            hash: [0; 32],
        };
        let header = Header::new(&contents, &body).unwrap();
        let path = self
            .folder
            .join(format!("{}{difference:+}.plu", self.product));
        fs::write(&path, [header.bytes(), &body[..]].concat()).unwrap();
        path
    }

    /// The image file of the program that the sensors have.
    pub fn same(&self) -> PathBuf {
        let path = self.folder.join(format!("{}.plu", self.product));
        fs::write(&path, ImageFile::of(elf(self.product)).unwrap().bytes).unwrap();
        path
    }

    /// The file of the settings.
    fn backup(&self) -> PathBuf {
        self.folder.join(format!("{}-{SERIAL}.toml", self.product))
    }
}

/// An update without a backup.
fn line(address: &str, file: &Path, options: &str) -> String {
    format!("{address} update {} --no-backup {options}", file.display())
}

/// A bus with a sensor with a bootloader and its program, which is on-line. Another node acknowledges.
pub fn rig(product: &str) -> Rig {
    rig_behind(&Image::parse(elf("bootloader")).unwrap(), product)
}

/// The same with this bootloader.
pub fn rig_behind(bootloader: &Image, product: &str) -> Rig {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K500));
    (rig.rate, rig.says_yes) = (Some("500"), true);
    attach_behind(&mut rig, bootloader, product, SERIAL);
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, None, false);
    rig.run(2300);
    rig
}

/// Adds a sensor with a bootloader and its program.
fn attach(rig: &mut Rig, product: &str, serial: u32) {
    let bootloader = Image::parse(elf("bootloader")).unwrap();
    attach_behind(rig, &bootloader, product, serial);
}

/// The same with this bootloader.
fn attach_behind(rig: &mut Rig, bootloader: &Image, product: &str, serial: u32) {
    let program = Image::parse(elf(product)).unwrap();
    let image = Rc::new(program.behind(bootloader).expect("they fit"));
    let name = find(product).expect("a product").name;
    let flash = with_500_kbits(product, serial);
    rig.attach_sensor(Microcontroller::new(name, image, serial, flash, tilted()).quiet());
}

/// The memory of a sensor with this bit rate, at which a download needs a quarter of the time as delivered.
fn with_500_kbits(product: &str, serial: u32) -> Flash {
    let mut rig = Rig::new(BusRate::Follow);
    (rig.rate, rig.says_yes) = (Some("125"), true);
    let id = rig.attach(product, serial);
    rig.run(2300);
    let address = match product {
        "jn2101" => "--node 10",
        "is2" => "--id 300",
        _ => "--mac 63",
    };
    rig.done(&format!("{address} rate 500"));
    let mut bus = rig.bus.borrow_mut();
    let bytes = bus.device_mut(id).flash().bytes().to_vec();
    Flash::with_content(Board::BluePill.chip().facts().geometry, bytes)
}

/// The sensor gets a setting and takes a newer program.
#[track_caller]
fn updates(product: &'static str, options: &str, assignment: &str) {
    let files = Files::new(product, product);
    let mut rig = rig(product);
    rig.json(&format!("{options} set {assignment} --save"));
    rig.run(1100);
    let (name, _) = assignment.split_once('=').unwrap();
    let read = format!("{options} get {name}");
    let before = rig.json(&read);
    let image = files.image(1);
    let line = format!("{options} update {}", image.display());
    let told = rig.json(&line);
    assert_eq!(told["product"], product);
    assert_eq!(told["loaded"], true);
    assert_eq!(told["different"], 0);
    assert_eq!(told["backup"], json!(files.backup().display().to_string()));
    assert!(files.backup().exists());
    assert_eq!(rig.json(&read), before);
}

#[test]
fn canopen_sensor_takes_a_program_and_keeps_its_settings() {
    updates("jn2101", "--node 10", "heartbeat-time=2s");
}

#[test]
fn gemac_sensor_takes_a_program_and_keeps_its_settings() {
    updates("is2", "--id 300", "cyclic-time=777ms");
}

#[test]
fn devicenet_sensor_takes_a_program_and_keeps_its_settings() {
    updates("tiltix080", "--mac 63", "resolution=raw:100");
}

#[test]
fn file_for_another_product_or_of_an_older_version_changes_nothing() {
    let files = Files::new("jn2101", "refused");
    let mut rig = rig("jn2101");
    let other = Files::new("is2", "refused-other").image(1);
    let line = |file: &Path, options: &str| self::line("--node 10", file, options);
    let ended = rig.tool(&line(&other, ""));
    assert_eq!(ended.code, 2, "{ended:?}");
    assert!(
        ended
            .notes
            .contains("the file is for is2, but the sensor is jn2101"),
        "{ended:?}"
    );
    let older = files.image(-1);
    rig.says_yes = false;
    let ended = rig.tool(&line(&older, ""));
    assert_eq!(ended.code, 1, "{ended:?}");
    assert!(ended.notes.contains("--downgrade"), "{ended:?}");
    let question = rig.questions.last().expect("a question");
    assert!(
        question.contains("the file has the older version"),
        "{question}"
    );
    rig.says_yes = true;
    // The program of before runs again.
    rig.run(200);
    assert_eq!(rig.json(&line(&files.same(), ""))["loaded"], false);
    if effort::choose(false, true) {
        assert_eq!(rig.json(&line(&older, "--downgrade"))["loaded"], true);
    }
    let damaged = files.folder.join("damaged.plu");
    let mut bytes = fs::read(&older).unwrap();
    bytes[5000] ^= 1;
    fs::write(&damaged, bytes).unwrap();
    let ended = rig.tool(&line(&damaged, ""));
    assert_eq!(ended.code, 2, "{ended:?}");
    assert!(ended.notes.contains("it is damaged"), "{ended:?}");
}

#[test]
fn all_sensors_of_the_product_are_updated_one_after_the_other() {
    let files = Files::new("jn2101", "all");
    let mut rig = rig("jn2101");
    rig.json("--node 10 node-id 11");
    attach(&mut rig, "jn2101", SERIAL + 1);
    rig.attach("is2", SERIAL + 2);
    rig.run(2300);
    let mut update = |image: PathBuf, is_loaded| {
        let told = rig.json(&format!("update {} --all", image.display()));
        let rows = told.as_array().expect("a list");
        let rows: Vec<_> = rows
            .iter()
            .map(|row| (&row["address"], &row["loaded"]))
            .collect();
        let loaded = json!(is_loaded);
        assert_eq!(
            rows,
            [(&json!("10"), &loaded), (&json!("11"), &loaded)],
            "{told}"
        );
    };
    update(files.same(), false);
    if effort::choose(false, true) {
        update(files.image(1), true);
    }
}

#[test]
fn file_for_all_sensors_of_a_product_that_the_bus_has_not_is_refused() {
    let other = Files::new("tiltix080", "all-other").image(1);
    let mut rig = Rig::with("is2");
    let (code, error) = rig.fails(&format!("update {} --all", other.display()));
    assert_eq!((code, &*error), (2, "wrong-image"));
}

#[test]
fn sensor_whose_address_changes_at_its_start_is_not_updated() {
    let files = Files::new("is2", "moves");
    let mut rig = rig("is2");
    rig.json("--id 300 set set-id=310 --save");
    let line = format!("--id 300 update {} --no-backup", files.image(1).display());
    let (code, error) = rig.fails(&line);
    assert_eq!((code, &*error), (2, "restart-first"));
    rig.json("--id 300 restart");
    rig.run(300);
    // The identifier of replies is not the one after that of requests.
    rig.cut = Some(300);
    let line = line.replace("300", "310");
    assert_ne!(rig.tool(&line).code, 0);
    rig.cut = None;
    rig.run(3000);
    assert_eq!(rig.json(&line)["loaded"], true);
}

#[test]
fn board_without_a_program_takes_one_as_node_127() {
    for product in effort::choose(&["is2"][..], &["is2", "jn2101"]) {
        let files = Files::new(product, &format!("blank-{product}"));
        let mut rig = Rig::new(BusRate::Fixed(BitRate::K125));
        rig.rate = Some("125");
        let bootloader = Image::parse(elf("bootloader")).unwrap().as_bootloader();
        let flash = Flash::blank(Board::BluePill.chip().facts().geometry);
        let name = find(product).expect("a product").name;
        let part = Microcontroller::new(name, Rc::new(bootloader), SERIAL, flash, tilted());
        rig.attach_sensor(part.quiet());
        let folder = tempfile::tempdir().unwrap();
        rig.config = Some(folder.path().to_owned());
        let line = format!("--node 127 update {}", files.image(0).display());
        assert_eq!(rig.json(&line)["loaded"], true, "{product}");
        // The next command finds the sensor at its own address.
        let read = rig.json("get serial-number");
        assert_eq!(read["serial-number"]["raw"], SERIAL, "{product}");
    }
}

/// The adapter is unplugged within the download. The next command goes on.
#[test]
fn update_that_was_interrupted_is_completed_by_the_next_one() {
    let all = [("jn2101", "--node 10"), ("tiltix080", "--mac 63")];
    for (product, options) in all.into_iter().take(effort::choose(1, 2)) {
        let files = Files::new(product, &format!("interrupted-{product}"));
        let mut rig = rig(product);
        let line = line(options, &files.image(1), "");
        rig.cut = Some(400);
        assert_ne!(rig.tool(&line).code, 0);
        rig.cut = None;
        rig.run(3000);
        if product == "jn2101" {
            let rows = rig.json("--rate 500 scan --active");
            let told = ["product", "address", "firmware"].map(|key| &rows[0][key]);
            assert_eq!(told, ["jn2101", "10", "bootloader"], "{rows}");
        }
        if effort::choose(false, true) {
            assert_eq!(rig.json(&line)["loaded"], true, "{product}");
            assert_eq!(rig.json(&line)["loaded"], false, "{product}");
        }
    }
}

/// A CANopen sensor tells its product: see above.
#[test]
fn scan_finds_the_bootloader_of_a_sensor_without_canopen() {
    let all = [
        ("is2", "fsc", "--id", "300"),
        ("tiltix080", "devicenet", "--mac", "63"),
    ];
    for (product, protocol, option, address) in all {
        let files = Files::new(product, &format!("scan-{product}"));
        let mut rig = rig(product);
        let image = files.image(1);
        rig.cut = Some(400);
        let line = format!("{option} {address} update {} --no-backup", image.display());
        assert_ne!(rig.tool(&line).code, 0);
        rig.cut = None;
        rig.run(3000);
        let rows = rig.json("--rate 500 scan --active");
        let told = ["protocol", "address", "heard"].map(|key| &rows[0][key]);
        assert_eq!(told, [protocol, address, "bootloader"], "{rows}");
        let ended = rig.tool("--rate 500 scan --active");
        let next = format!("plumbline --rate 500 {option} {address} update FILE");
        assert!(ended.out.contains(&next), "{ended:?}");
    }
}

#[test]
fn sensor_without_a_bootloader_is_told_and_nothing_changes() {
    for (product, options) in [
        ("jn2101", "--node 10"),
        ("is2", "--id 300"),
        ("tiltix080", "--mac 63"),
    ] {
        let files = Files::new(product, &format!("none-{product}"));
        let mut rig = Rig::with(product);
        let ended = rig.tool(&format!("{options} update {}", files.image(1).display()));
        assert_eq!(ended.code, 1, "{ended:?}");
        assert!(
            ended.notes.contains("the sensor has no bootloader"),
            "{ended:?}"
        );
        assert!(!files.backup().exists());
    }
}

#[test]
fn sensor_with_a_key_takes_only_a_signed_file_and_another_one_no_signed_file() {
    let files = Files::new("jn2101", "signed");
    let mut key = KeyFile::create(&files.folder.join("own.key")).unwrap();
    let unsigned = files.image(1);
    let image = ImageFile::parse(fs::read(&unsigned).unwrap()).unwrap();
    let signed = files.folder.join("signed.plu");
    fs::write(&signed, image.signed(&mut key).unwrap().bytes).unwrap();
    let line = |file: &Path| line("--node 10", file, "");
    let bootloader = signed_bootloader().with_key(&key.public()).unwrap();
    let mut rig = rig_behind(&bootloader, "jn2101");
    let (code, error) = rig.fails(&line(&unsigned));
    assert_eq!((code, &*error), (1, "unsigned-image"));
    // The program of before runs again.
    rig.run(200);
    assert_eq!(rig.json(&line(&files.same()))["loaded"], false);
    assert_eq!(rig.json(&line(&signed))["loaded"], true);
    let mut rig = self::rig("jn2101");
    let (code, error) = rig.fails(&line(&signed));
    assert_eq!((code, &*error), (1, "damaged-image"));
}
