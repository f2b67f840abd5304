//! `restore` to a sensor that is not as it was when the file was written: after `load-factory`, and another sensor of the same product.

use super::rig::{PRODUCTS, Rig, file};
use serde_json::json;
use std::path::Path;

/// The sensor has the settings of a file after each power-up.
fn is_kept(rig: &mut Rig, path: &Path, product: &str) {
    for _ in 0..2 {
        rig.power_cycle(rig.first());
        let differences = rig.json(&format!("diff {}", path.display()));
        assert_eq!(differences, json!({}), "{product}");
    }
}

#[test]
fn settings_restored_after_load_factory_are_kept_at_power_off_by_every_product() {
    for product in PRODUCTS {
        let path = file(&format!("factory-{product}.toml"));
        let setting = match product {
            "jn2101" => "heartbeat-interval-time=500ms",
            "ims360" => "producer-heartbeat-time=500ms",
            "tiltix080" | "tiltix360" => "size-of=50",
            _ => "cyclic-time=100ms",
        };
        let mut rig = Rig::with(product);
        rig.done(&format!("set {setting} --save"));
        rig.done(&format!("backup {}", path.display()));
        rig.done("load-factory");
        rig.done(&format!("restore {}", path.display()));
        rig.run(1500);
        is_kept(&mut rig, &path, product);
    }
}

#[test]
fn factory_values_of_every_product_are_kept_at_power_off() {
    for product in PRODUCTS {
        let path = file(&format!("delivered-{product}.toml"));
        let mut rig = Rig::with(product);
        rig.done(&format!("backup {}", path.display()));
        let setting = match product {
            "jn2101" | "ims360" => "node-id=33",
            "tiltix080" | "tiltix360" => "size-of=50",
            _ => "cyclic-time=100ms",
        };
        rig.done(&format!("set {setting} --save"));
        rig.done("load-factory");
        rig.run(1500);
        is_kept(&mut rig, &path, product);
    }
}

#[test]
fn restart_with_factory_values_is_part_of_the_question() {
    let mut rig = Rig::with("ims360");
    rig.done("node-id 33");
    let path = file("asked.toml");
    rig.done(&format!("--node 33 backup {}", path.display()));
    rig.says_yes = false;
    assert_eq!(
        rig.fails("--node 33 load-factory"),
        (2, "not-confirmed".to_owned())
    );
    let question = rig.questions.last().unwrap();
    for part in ["restart", "node-ID 50", "125 kbit/s"] {
        assert!(question.contains(part), "{question}");
    }
    let diff = format!("--node 33 diff {}", path.display());
    assert_eq!(rig.json(&diff), json!({}));
}

#[test]
fn file_of_another_serial_number_is_restored_only_after_a_yes() {
    let path = file("other-serial.toml");
    let text = "[sensor]\nproduct = \"is2\"\nserial = 999\n[parameters]\nzero-x = -1.25\nset-id = \"123h\"\n";
    for text in [text.to_owned(), text.replace("serial = 999\n", "")] {
        std::fs::write(&path, text).unwrap();
        let mut rig = Rig::with("is2");
        rig.says_yes = false;
        let before = rig.done("get zero-x set-id");
        let restore = format!("restore {}", path.display());
        assert_eq!(rig.fails(&restore), (2, "not-confirmed".to_owned()));
        assert!(rig.questions[0].contains("another serial number"));
        assert_eq!(rig.done("get zero-x set-id"), before);
        rig.says_yes = true;
        rig.done(&restore);
        assert!(rig.done("get zero-x").contains("-1.25"));
        // If nothing differs, there is no question.
        rig.questions.clear();
        rig.done(&restore);
        assert!(rig.questions.is_empty(), "{:?}", rig.questions);
    }
}
