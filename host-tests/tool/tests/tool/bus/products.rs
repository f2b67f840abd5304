//! Which product a sensor is: if its answers leave a doubt, the tool asks, and writes nothing without a yes.

use super::files::file;
use super::rig::Rig;
use plumbline::can::{CanId, Frame};

/// The question for serial number and software version (04h).
fn asks_version(frame: &Frame) -> bool {
    frame.can_id() == CanId::standard(0x300) && frame.bytes().first() == Some(&4)
}

/// A sensor of an article of both generations that does not tell its software version.
fn without_version() -> Rig {
    let mut rig = Rig::with("is2");
    rig.lost = asks_version;
    rig.witnessed();
    rig
}

/// The frames of the tool that change something.
fn writes(rig: &mut Rig) -> Vec<String> {
    let frames = rig.witnessed();
    let frames = frames.iter().map(|frame| format!("{frame:?}"));
    let is_write = |frame: &String| {
        let is_fsc = ["300#2", "300#4", "300#5"];
        let is_sdo = ["60A#2", "632#2"];
        // Set_Attribute_Single on the explicit connection of MAC ID 63.
        let is_explicit = frame.starts_with("5FC#") && frame[6..].starts_with("10");
        is_explicit
            || is_fsc
                .iter()
                .chain(&is_sdo)
                .any(|start| frame.starts_with(start))
    };
    frames.filter(is_write).collect()
}

#[test]
fn sensor_that_can_be_two_products_is_the_one_that_the_user_says() {
    for (part, product) in [("Is it is2?", "is2"), ("Is it is2d?", "is2d")] {
        let mut rig = without_version();
        rig.yes_to = Some(part);
        let path = file(&format!("which-{product}.toml"));
        rig.done(&format!("--id 300 backup {}", path.display()));
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(&format!("product = \"{product}\"")), "{text}");
    }
}

#[test]
fn sensor_that_can_be_two_products_is_not_touched_without_an_answer() {
    let mut rig = without_version();
    rig.says_yes = false;
    let set = "set cyclic-time=100ms";
    let failed = (2, "ambiguous-product".to_owned());
    assert_eq!(rig.fails(&format!("--id 300 {set}")), failed);
    let asked: Vec<&str> = rig
        .questions
        .iter()
        .filter_map(|question| question.rsplit(". ").next())
        .collect();
    assert_eq!(asked, ["Is it is2?", "Is it is2d?"]);
    // A yes to all questions selects no product.
    rig.says_yes = true;
    assert_eq!(rig.fails(&format!("--id 300 --yes {set}")), failed);
    assert_eq!(rig.questions.len(), 2);
    assert_eq!(writes(&mut rig), [""; 0]);
    rig.says_yes = false;
    rig.done(&format!("--id 300 --product is2d {set}"));
    assert_eq!(writes(&mut rig).len(), 1);
}

#[test]
fn product_that_the_sensor_contradicts_is_used_only_after_a_yes() {
    for (own, address, product, set) in [
        ("is2", "--id 300", "is1", "cyclic-time=100ms"),
        ("is2", "--id 300", "is2d", "cyclic-time=100ms"),
        ("jn2101", "--node 10", "ims360", "node-id=12"),
        ("tiltix080", "--mac 63", "tiltix360", "mac-id=7"),
    ] {
        let mut rig = Rig::with(own);
        rig.says_yes = false;
        rig.witnessed();
        let command = format!("{address} --product {product} set {set}");
        let failed = rig.fails(&command);
        assert_eq!(failed, (2, "wrong-product".to_owned()), "{own} {product}");
        assert_eq!(writes(&mut rig), [""; 0], "{own} {product}");
        let question = &rig.questions[..];
        assert!(
            question.len() == 1
                && question[0].contains(&format!("identifies itself as {own} "))
                && question[0].contains(&format!("tables of {product} ")),
            "{question:?}"
        );
        // Its own product is no question.
        rig.done(&format!("{address} --product {own} get"));
        assert_eq!(rig.questions.len(), 1);
        rig.says_yes = true;
        rig.tool(&command);
        assert_eq!(rig.questions.len(), 2, "{own} {product}");
        assert_ne!(writes(&mut rig), [""; 0], "{own} {product}");
    }
}
