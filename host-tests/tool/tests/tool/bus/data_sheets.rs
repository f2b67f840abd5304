//! `--eds`: devices by the names of their data sheet, and the Device Configuration File of `backup`.
//!
//! The devices belong to this project, but the program knows them only from the data sheet.

use super::files::file;
use super::rig::Rig;
use plumbline::model::catalog::find;
use serde_json::json;
use std::path::PathBuf;

/// The data sheet of a product as a file, with a replacement.
fn data_sheet(product: &str, name: &str, (from, to): (&str, &str)) -> PathBuf {
    let text = descriptors::describe(find(product).unwrap()).text;
    assert!(text.contains(from), "{from}");
    let path = file(name);
    std::fs::write(&path, text.replace(from, to)).unwrap();
    path
}

/// The commands of a device with its data sheet.
struct Foreign {
    rig: Rig,
    options: String,
}

impl Foreign {
    fn new(product: &str, name: &str, address: &str) -> Self {
        let eds = data_sheet(product, name, ("", ""));
        Self {
            rig: Rig::with(product),
            options: format!("{address} --eds {}", eds.display()),
        }
    }

    fn line(&self, command: &str) -> String {
        format!("{} {command}", self.options)
    }

    fn json(&mut self, command: &str) -> serde_json::Value {
        let line = self.line(command);
        self.rig.json(&line)
    }

    fn done(&mut self, command: &str) -> String {
        let line = self.line(command);
        self.rig.done(&line)
    }

    fn fails(&mut self, command: &str) -> (u8, String) {
        let line = self.line(command);
        self.rig.fails(&line)
    }
}

#[test]
fn canopen_device_is_read_set_and_stored_by_the_names_of_its_data_sheet() {
    let mut device = Foreign::new("jn2101", "foreign-jn2101.eds", "--node 10");
    let read = device.json("get heartbeat-interval-time slope-long16 product-designation");
    assert_eq!(read["product-designation"]["value"], "JN2101");
    assert_eq!(read["slope-long16"]["unit"], "");
    let listed = device.json("parameters");
    assert_eq!(listed["resolution"]["range"], "1..1000");
    device.done("set resolution=100 --save");
    let id = device.rig.first();
    device.rig.power_cycle(id);
    assert_eq!(device.json("get resolution")["resolution"]["raw"], 100);
    // By the product of the catalogue it is the same.
    let read = device.rig.json("--node 10 get resolution");
    assert_eq!(read["resolution"]["raw"], 100);
}

#[test]
fn value_outside_the_limits_of_the_data_sheet_is_refused_before_anything_is_written() {
    let mut device = Foreign::new("jn2101", "foreign-limits.eds", "--node 10");
    device.rig.witnessed();
    for (set, code) in [
        ("resolution=1001", "out-of-range"),
        ("resolution=70000", "out-of-range"),
        ("resolution=1deg", "bad-value"),
        ("slope-long16=1", "read-only"),
        ("nonsense=1", "unknown-name"),
    ] {
        let (exit, failure) = device.fails(&format!("set node-id=11 {set}"));
        assert_eq!((exit, failure.as_str()), (2, code), "{set}");
    }
    let writes = device.rig.witnessed();
    let is_write = |frame: &&plumbline::can::Frame| {
        matches!(frame.bytes(), [0x20..=0x3F, ..]) && format!("{frame:?}").starts_with("60A")
    };
    assert_eq!(writes.iter().filter(is_write).count(), 0, "{writes:?}");
}

#[test]
fn backup_and_restore_work_with_a_data_sheet() {
    let mut device = Foreign::new("jn2101", "foreign-backup.eds", "--node 10");
    let (one, two) = (file("foreign-1.toml"), file("foreign-2.toml"));
    let resolution = device.json("get resolution")["resolution"]["raw"].clone();
    assert_eq!(resolution, 10);
    device.done("set resolution=1000 tpdo1-event-timer=20");
    device.done(&format!("backup {}", one.display()));
    device.done("set resolution=10 tpdo1-event-timer=10");
    let differences = device.json(&format!("diff {}", one.display()));
    assert_eq!(differences.as_object().unwrap().len(), 2, "{differences}");
    device.done(&format!("restore {}", one.display()));
    device.done(&format!("backup {}", two.display()));
    let read = |path: &PathBuf| std::fs::read_to_string(path).unwrap();
    assert_eq!(read(&one), read(&two));
    device.done(&format!("set resolution=100 --file {}", one.display()));
    assert_eq!(
        device.json(&format!("diff {}", one.display()))["resolution"]["file"]["raw"],
        100
    );
    // Without the data sheet the file is of an unknown product.
    let failure = device
        .rig
        .fails(&format!("--node 10 diff {}", one.display()));
    assert_eq!(failure, (2, "bad-file".to_owned()));
}

#[test]
fn entries_that_the_device_refuses_to_read_are_left_out_of_a_backup() {
    // A number and a text that a JN2101 does not have.
    let object = "[2FF0]\r\nParameterName=Ramp\r\nObjectType=7\r\nDataType=6\r\nAccessType=rw\r\n\
                  [2FF1]\r\nParameterName=Place\r\nObjectType=7\r\nDataType=9\r\nAccessType=rw\r\n[1000]";
    let eds = data_sheet("jn2101", "foreign-more.eds", ("[1000]", object));
    let mut rig = Rig::with("jn2101");
    let options = format!("--node 10 --eds {}", eds.display());
    let (one, two) = (file("foreign-more-1.toml"), file("foreign-more-2.toml"));
    rig.done(&format!("{options} set resolution=100"));
    let ended = rig.tool(&format!("{options} backup {}", one.display()));
    assert_eq!(ended.code, 0, "{ended:?}");
    assert!(ended.notes.contains("ramp is skipped: "), "{ended:?}");
    assert!(ended.notes.contains("place is skipped: "), "{ended:?}");
    let text = std::fs::read_to_string(&one).unwrap();
    assert!(!text.contains("ramp") && !text.contains("place"), "{text}");
    assert!(text.contains("resolution = "), "{text}");
    assert!(text.contains("\nnode-id = 10\n"), "{text}");
    let dcf = std::fs::read_to_string(one.with_extension("dcf")).unwrap();
    assert!(!dcf.contains("[2FF0]\r\nParameterValue"), "{dcf}");
    rig.done(&format!("{options} load-factory"));
    rig.power_cycle(rig.first());
    rig.done(&format!("{options} restore {}", one.display()));
    rig.done(&format!("{options} backup {}", two.display()));
    assert_eq!(text, std::fs::read_to_string(&two).unwrap());
    // By name it is an error.
    let failed = rig.fails(&format!("{options} get ramp"));
    assert_eq!(failed, (1, "refused".to_owned()));
}

#[test]
fn angles_of_the_device_profile_and_values_by_name_are_watched() {
    let mut device = Foreign::new("jn2101", "foreign-watch.eds", "--node 10");
    let out = device.done("--json watch --seconds 1");
    let line: serde_json::Value = serde_json::from_str(out.lines().next().unwrap()).unwrap();
    assert!(
        line["slope-long32"].is_number() && line["slope-lateral32"].is_number(),
        "{line}"
    );
    let out = device.done("--json watch slope-long16 resolution --seconds 1");
    let line: serde_json::Value = serde_json::from_str(out.lines().next().unwrap()).unwrap();
    assert_eq!(line["resolution"], 10);
    assert_eq!(line.as_object().unwrap().len(), 3, "{line}");
    assert_eq!(device.fails("watch product-designation").0, 2);
    let path = file("foreign-watch.csv");
    device.done(&format!(
        "record {} slope-long16 resolution --seconds 1",
        path.display()
    ));
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(text.lines().next(), Some("time_s,slope-long16,resolution"));
    // Also with a product of the catalogue.
    let mut rig = Rig::with("is2");
    let out = rig.done("watch serial-number cyclic-time --seconds 1");
    assert!(
        out.contains("cyclic-time") && !out.contains("status"),
        "{out}"
    );
}

#[test]
fn data_sheet_of_another_device_is_used_only_after_a_yes() {
    let change = ("ProductNumber=0x", "ProductNumber=0x1");
    let eds = data_sheet("jn2101", "foreign-other.eds", change);
    let mut rig = Rig::with("jn2101");
    let line = format!("--node 10 --eds {} get resolution", eds.display());
    rig.done(&line);
    assert!(rig.questions.last().unwrap().contains("product code"));
    rig.says_yes = false;
    assert_eq!(rig.fails(&line), (2, "wrong-product".to_owned()));
}

#[test]
fn hostile_data_sheet_is_refused_and_nothing_is_sent() {
    let eds = file("hostile.eds");
    let mut rig = Rig::with("jn2101");
    rig.witnessed();
    for (text, code) in [
        (&b"\0\xFF\xFE"[..], "bad-file"),
        (b"", "bad-file"),
        (b"[Device]\n[Params]\nParam1 = \"", "bad-file"),
    ] {
        std::fs::write(&eds, text).unwrap();
        for command in ["get", "parameters", "set x=1", "backup x.toml"] {
            let line = format!("--node 10 --eds {} {command}", eds.display());
            assert_eq!(rig.fails(&line), (2, code.to_owned()), "{command}");
        }
    }
    let missing = rig.fails("--node 10 --eds /nonexistent.eds get");
    assert_eq!(missing, (4, "no-file".to_owned()));
    let both = rig.fails("--node 10 --eds x.eds rate 500");
    assert_eq!(both, (2, "not-offered".to_owned()));
    assert!(rig.witnessed().is_empty());
}

#[test]
fn devicenet_device_is_read_and_set_by_the_names_of_its_data_sheet() {
    let mut device = Foreign::new("tiltix080", "foreign-tiltix.eds", "--mac 63");
    let read = device.json("get resolution slope-long16");
    let resolution = json!({"value": 0.01, "unit": "deg", "raw": 10});
    assert_eq!(read["resolution"], resolution);
    device.done("set resolution=raw:100");
    let read = device.rig.json("--mac 63 get resolution");
    assert_eq!(read["resolution"]["raw"], 100);
    assert_eq!(device.fails("set resolution=raw:11").0, 2);
    let path = file("foreign-tiltix.toml");
    device.done(&format!("backup {}", path.display()));
    assert_eq!(device.json(&format!("diff {}", path.display())), json!({}));
    assert!(!path.with_extension("dcf").exists());
}

#[test]
fn configuration_file_is_beside_the_backup_of_every_canopen_product() {
    for (product, address) in [("jn2101", "--node 10"), ("ims360", "--node 50")] {
        let path = file(&format!("dcf-{product}.toml"));
        let mut rig = Rig::with(product);
        let document = rig.json(&format!("{address} backup {}", path.display()));
        let dcf = path.with_extension("dcf");
        assert_eq!(document["dcf"], dcf.display().to_string());
        let text = std::fs::read_to_string(&dcf).unwrap();
        let written = text.matches("ParameterValue=").count();
        assert_eq!(document["settings"], written, "{product}");
        // It is a data sheet too.
        let line = format!("{address} --eds {} get", dcf.display());
        rig.done(&line);
        let failure = rig.fails(&format!("{address} backup {}", dcf.display()));
        assert_eq!(failure, (2, "bad-file".to_owned()));
    }
}
