//! `identity`: from the sensor, from a data sheet, from a configuration file and from a sheet of values, into the store of the successor.

use super::rig::{PRODUCTS, Rig, file, tilted};
use bench::{BusRate, Device, Flash, Geometry, NodeType, STORE_BUFFER};
use plumbline::model::catalog::find;
use plumbline::store::{Name, Store, Unit};
use serde_json::{Value, json};
use std::fs::{read_to_string, write};
use std::path::{Path, PathBuf};

/// A bus with a sensor that has this store.
fn successor(product: &str, store: &Path) -> Rig {
    let mut rig = Rig::new(BusRate::Follow);
    rig.rate = Some("250");
    rig.says_yes = true;
    let node_type = NodeType::find(product).unwrap();
    let flash = Flash::in_file(Geometry::STM32F103, store).unwrap();
    let id = rig.attach_sensor(Device::new(&node_type, 1, flash, tilted()));
    rig.power_cycle(id);
    rig.witnessed();
    rig
}

/// The identity in a store file.
fn unit_in(product: &str, store: &Path) -> Unit {
    let flash = Flash::in_file(Geometry::STM32F103, store).unwrap();
    let owner = find(product).unwrap().owner(1);
    let mut store = Store::<_, [u8; STORE_BUFFER]>::open(flash, owner);
    store.boot().unit
}

/// A file with this content.
fn with(name: &str, text: &str) -> PathBuf {
    let path = file(name);
    write(&path, text).unwrap();
    path
}

/// Runs the program without a sensor, which must succeed.
#[track_caller]
fn done(arguments: &str) -> Value {
    Rig::new(BusRate::Follow).json(arguments)
}

/// Runs the program without a sensor, which must fail. Returns the code of the error and its message.
#[track_caller]
fn fails(arguments: &str) -> (String, String) {
    let ended = Rig::new(BusRate::Follow).tool(&format!("--json {arguments}"));
    assert_eq!(ended.code, 2, "{arguments}: {ended:?}");
    let document: Value = serde_json::from_str(&ended.out).unwrap();
    let text = |key: &str| document["error"][key].as_str().unwrap().to_owned();
    (text("code"), text("message"))
}

#[test]
fn successor_of_each_product_has_the_identity_of_the_old_sensor() {
    for product in PRODUCTS {
        let (sheet, store) = (
            file(&format!("identity-{product}.toml")),
            file(&format!("identity-{product}.bin")),
        );
        let mut old = Rig::with(product);
        let (sheet, store) = (sheet.display(), store.display());
        let told = old.json(&format!(
            "identity --from-sensor --output {sheet} --store {store}"
        ));
        assert_eq!(told["product"], json!(product));
        assert_eq!(told["identity"]["serial"], json!(1), "{told}");
        // Another serial number, as of the sensor of another maker.
        let text = read_to_string(sheet.to_string()).unwrap();
        let text = text.replace("serial = 1 ", "serial = 10597059 ");
        write(sheet.to_string(), text).unwrap();
        let given = done(&format!("identity --from {sheet} --store {store}"));
        assert_eq!(given["identity"]["serial"], json!(10_597_059));
        let mut expected = told["identity"].clone();
        expected["serial"] = json!(10_597_059);
        assert_eq!(given["identity"], expected);
        let mut new = successor(product, Path::new(&store.to_string()));
        assert_eq!(new.json("identity"), given, "{product}");
    }
}

#[test]
fn identity_over_j1939_is_that_of_the_identification() {
    let mut rig = Rig::with("ims360");
    rig.done("set can-protocol=raw:1 --save");
    rig.done("restart");
    rig.run(1000);
    let told = rig.json("--address 128 identity");
    let identity = &told["identity"];
    assert_eq!(identity["name"], json!("IMS360"));
    assert_eq!(identity["serial"], json!(1));
    assert_eq!(identity["software-version"], json!("010000"));
    assert_eq!(identity["vendor"], Value::Null);
}

const CANOPEN: &str = "[FileInfo]\r\nFileName=old.dcf\r\n[DeviceInfo]\r\nVendorName=Old\r\nVendorNumber=0x195\r\nProductName=Any\r\nProductNumber=0x22\r\nRevisionNumber=0x00010003\r\n[1018]\r\nSubNumber=5\r\n[1018sub1]\r\nDefaultValue=0\r\n[1018sub2]\r\nDefaultValue=0x23\r\nParameterValue=0x24\r\n[1018sub4]\r\nDefaultValue=0\r\n[1008]\r\nDefaultValue=Old one\r\n[1009]\r\nDefaultValue=\r\n[100A]\r\nDefaultValue=V1\r\nParameterValue=V2\r\n";

#[test]
fn canopen_data_sheet_and_configuration_file_give_the_identity() {
    let eds = with("identity-old.eds", CANOPEN);
    let expected = json!({
        "vendor": 0x195,
        "product-code": 0x24,
        "revision": 0x0001_0003,
        "serial": null,
        "name": "Old one",
        "hardware-version": null,
        "software-version": "V2",
    });
    let from = |path: &Path| {
        done(&format!(
            "--product jn2101 identity --from {}",
            path.display()
        ))
    };
    assert_eq!(from(&eds)["identity"], expected);
    let dcf = format!("{CANOPEN}[DeviceComissioning]\r\nNodeID=10\r\nLSS_SerialNumber=0x4D2\r\n");
    let told = from(&with("identity-old.dcf", &dcf));
    assert_eq!(told["identity"]["serial"], json!(1234));
    // The data sheet of the project gives the identity of the product.
    let text = descriptors::describe(find("jn2101").unwrap()).text;
    let store = file("identity-own.bin");
    let own = with("identity-own.eds", &text);
    let store_option = format!("--store {}", store.display());
    done(&format!(
        "--product jn2101 identity --from {} {store_option}",
        own.display()
    ));
    let unit = unit_in("jn2101", &store);
    let expected = (Some(0x6D66_6900), Some(1), Some(0xAA), Name::new("JN2101"));
    assert_eq!(
        (unit.vendor, unit.product_code, unit.revision, unit.name),
        expected
    );
    assert_eq!(unit.serial, None);
}

/// `ParameterValue` counts more than the values of the type.
#[test]
fn values_of_the_unit_in_a_configuration_file_give_the_identity() {
    let dcf = "[DeviceInfo]\nVendorNumber=1\nProductNumber=2\nRevisionNumber=3\n\
        [1008]\nDefaultValue=a\nParameterValue=A name\n\
        [1009]\nDefaultValue=b\nParameterValue=H4\n\
        [100A]\nDefaultValue=c\nParameterValue=S5\n\
        [1018sub1]\nDefaultValue=1\nParameterValue=11\n\
        [1018sub2]\nDefaultValue=2\nParameterValue=12\n\
        [1018sub3]\nDefaultValue=3\nParameterValue=13\n\
        [1018sub4]\nDefaultValue=4\nParameterValue=14\n\
        [DeviceComissioning]\nLSS_SerialNumber=15\n";
    let path = with("identity-unit.dcf", dcf);
    for product in ["jn2101", "ims360"] {
        let arguments = format!("--product {product} identity --from {}", path.display());
        let expected = json!({
            "vendor": 11,
            "product-code": 12,
            "revision": 13,
            "serial": 14,
            "name": "A name",
            "hardware-version": "H4",
            "software-version": "S5",
        });
        assert_eq!(done(&arguments)["identity"], expected, "{product}");
    }
}

#[test]
fn devicenet_data_sheet_gives_the_identity() {
    let text = "[File]\nDescText = \"Old\";\nRevision = 9.9;\n\
        [Device]\nVendCode = 11;\nVendName = \"Vendor\";\nProdType = 12;\nProdTypeStr = \"Type\";\n\
        ProdCode = 13;\nMajRev = 4;\nMinRev = 7;\nProdName = \"Old one\";\nCatalog = \"Part\";\n";
    let path = with("identity-old-devicenet.eds", text);
    let from = |path: &Path| {
        done(&format!(
            "--product tiltix080 identity --from {}",
            path.display()
        ))
    };
    let expected = json!({
        "vendor": 11,
        "device-type": 12,
        "product-code": 13,
        "revision": "4.7",
        "serial": null,
        "name": "Old one",
    });
    assert_eq!(from(&path)["identity"], expected);
    // The data sheet of the project gives the identity of the product.
    let text = descriptors::describe(find("tiltix080").unwrap()).text;
    let own = &from(&with("identity-tiltix.eds", &text))["identity"];
    assert_eq!(own["vendor"], json!(354));
    assert_eq!(own["device-type"], json!(0));
    assert_eq!(own["product-code"], json!(80));
    assert_eq!(own["name"], json!("INCLINOMETER 080 degree"));
}

#[test]
fn file_that_does_not_fit_is_refused_and_nothing_is_written() {
    let store = file("identity-refused.bin");
    let devicenet = descriptors::describe(find("tiltix080").unwrap()).text;
    let long = format!("name = \"{}\"", "x".repeat(33));
    for (product, content, part) in [
        (
            "tiltix080",
            "vendor = 0",
            "vendor = 0: attribute 1 of class 1 takes 1 to 65535",
        ),
        (
            "tiltix080",
            "product-code = 65536",
            "product-code = 65536: attribute 3 of class 1 takes 1 to 65535",
        ),
        (
            "tiltix080",
            &long,
            "attribute 7 of class 1 takes a text of 1 to 32 characters",
        ),
        (
            "jn2101",
            "serial = 4294967296",
            "serial = 4294967296: 1018h:04 takes 0 to 4294967295",
        ),
        ("jn2101", "device-type = 0", "jn2101 has no device-type"),
        (
            "jn2101",
            &CANOPEN.replace("0x195", "0"),
            "vendor = 0: 1018h:01 takes 1 to 4294967295",
        ),
        (
            "jn2101",
            &CANOPEN.replace("0x195", "ifm"),
            "vendornumber = ifm in [deviceinfo] is no number",
        ),
        (
            "jn2101",
            "[FileInfo]\nFileName=a.eds\n",
            "it has no identity",
        ),
        (
            "jn2101",
            &devicenet,
            "describes a DeviceNet device, but jn2101 uses CANopen",
        ),
        (
            "tiltix080",
            CANOPEN,
            "describes a CANopen device, but tiltix080 uses DeviceNet",
        ),
        ("is2", CANOPEN, "is2 has no data sheet"),
        (
            "is2",
            "product = \"is1\"\nserial = 1",
            "the sheet is for is1, not for is2",
        ),
        ("is2", "serial = one", "line 1"),
    ] {
        let path = with("identity-refused.txt", content);
        let arguments = format!(
            "--product {product} identity --from {} --store {}",
            path.display(),
            store.display()
        );
        let (code, message) = fails(&arguments);
        assert_eq!(code, "bad-file", "{message}");
        assert!(message.contains(part), "{part}: {message}");
        assert!(message.ends_with("nothing was written"), "{message}");
        assert!(!store.exists());
    }
}

#[test]
fn identity_needs_a_product_and_a_source() {
    let sheet = with("identity-no-product.toml", "serial = 5");
    let (code, _) = fails(&format!("identity --from {}", sheet.display()));
    assert_eq!(code, "unknown-product");
    let (code, _) = fails("identity --store new.bin");
    assert_eq!(code, "no-identity");
    let missing = file("identity-missing.toml");
    let ended = Rig::new(BusRate::Follow).fails(&format!("identity --from {}", missing.display()));
    assert_eq!(ended, (4, "no-file".to_owned()));
}

#[test]
fn identity_is_shown_with_the_place_of_each_value() {
    let text = Rig::with("tiltix360").done("identity");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 6, "{text}");
    assert!(lines[0].starts_with("vendor            354 "), "{text}");
    assert!(lines[0].ends_with(" attribute 1 of class 1"), "{text}");
}
