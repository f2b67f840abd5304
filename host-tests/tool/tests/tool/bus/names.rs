//! `parameters` and `get`: every name of every product.

use super::rig::{PRODUCTS, Rig};
use plumbline::model::catalog::find;
use serde_json::json;

#[test]
fn every_name_is_unique_and_readable_at_factory_value() {
    for product in PRODUCTS {
        let mut rig = Rig::with(product);
        let listed = rig.json(&format!("parameters --product {product}"));
        let listed = listed.as_object().unwrap();
        let table = find(product).unwrap();
        let read = rig.json("get");
        let mut parameters = 0;
        for (name, row) in listed {
            if row["access"] == "wo" {
                assert!(read.get(name).is_none(), "{product} {name}");
                continue;
            }
            let value = &read[name];
            assert!(value["value"] != json!(null), "{product} {name}: {value}");
            if row["factory"].is_null() {
                continue;
            }
            parameters += 1;
            let is_address = row["factory"]["value"].is_string() && name.contains("cob-id");
            if !is_address {
                assert_eq!(value, &row["factory"], "{product} {name}");
            }
        }
        let hidden = if product == "jn2101" {
            6
        } else if product == "ims360" {
            10
        } else {
            0
        };
        assert_eq!(parameters + hidden, table.parameters.len(), "{product}");
    }
}

#[test]
fn angles_are_in_degrees() {
    let mut shown = Vec::new();
    for (product, names) in [
        ("is2", ["angle-x", "angle-y"]),
        ("jn2101", ["slope-long32", "slope-lateral32"]),
        ("ims360", ["slope-long32", "slope-lateral32"]),
        ("tiltix080", ["slope-long16", "slope-lateral16"]),
    ] {
        let mut rig = Rig::with(product);
        let read = rig.json(&format!("get {} {}", names[0], names[1]));
        let value = |name: &str| {
            assert_eq!(read[name]["unit"], "deg", "{product}");
            (read[name]["value"].as_f64().unwrap() * 10.0).round()
        };
        shown.push((product, names.map(value)));
    }
    // In 0.1 deg. The longitudinal angle is about Y, the lateral one about X.
    let expected = [
        ("is2", [100.0, 50.0]),
        ("jn2101", [100.0, 50.0]),
        ("ims360", [100.0, 50.0]),
        ("tiltix080", [100.0, 50.0]),
    ];
    assert_eq!(shown, expected);
}

#[test]
fn abbreviation_reads_the_same_and_ambiguous_one_is_refused() {
    let mut rig = Rig::with("is2");
    let full = rig.json("get cyclic-time");
    assert_eq!(
        full,
        json!({"cyclic-time": {"value": 250, "unit": "ms", "raw": 250}})
    );
    assert_eq!(rig.json("get cyclic-t"), full);
    assert_eq!(rig.json("get zero-offset-x"), rig.json("get zero-x"));
    assert_eq!(rig.fails("get cyclic"), (2, "ambiguous-name".to_owned()));
    assert_eq!(rig.fails("get cylic-time"), (2, "unknown-name".to_owned()));
}

#[test]
fn group_reads_all_its_parameters() {
    let mut rig = Rig::with("is2");
    let read = rig.json("get filter");
    assert_eq!(read["cut-off"]["raw"], 2000);
    assert_eq!(read["filter-type"]["value"], "critically damped");
}

#[test]
fn text_of_devicenet_has_no_length_byte() {
    let mut rig = Rig::with("tiltix080");
    assert_eq!(
        rig.json("get product-name")["product-name"],
        json!({"value": "INCLINOMETER 080 degree", "unit": ""})
    );
}

#[test]
fn serial_number_and_bit_rate_have_the_same_form_for_every_product() {
    for product in PRODUCTS {
        let mut rig = Rig::with(product);
        if !["jn2101", "ims360", "tiltix080", "tiltix360"].contains(&product) {
            rig.done("set baud-rate=125");
        }
        let serials: &[&str] = match product {
            "ims360" => &[
                "identity-object-serial-number",
                "logistic-data-serial-number",
            ],
            _ => &["serial-number"],
        };
        let read = rig.json(&format!("get baud-rate {}", serials.join(" ")));
        for serial in serials {
            assert_eq!(read[serial]["value"], 1, "{product} {read}");
        }
        let rate = &read["baud-rate"];
        assert_eq!(
            (&rate["value"], &rate["unit"]),
            (&json!(125), &json!("kbit/s")),
            "{product}"
        );
        assert!(rate["raw"].is_u64(), "{product}");
    }
    let mut rig = Rig::with("tiltix080");
    assert_eq!(
        rig.json("set resolution=0.01deg")["resolution"],
        json!({"value": 0.01, "unit": "deg", "raw": 10})
    );
}
