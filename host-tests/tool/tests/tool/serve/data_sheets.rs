//! Devices with a data sheet (EDS): one that the page sends, and one from the command line. The devices belong to this project, but the
//! server knows them only from the data sheet.

use crate::serve::api::{run, value};
use crate::serve::client::{Answer, Running};
use plumbline::model::catalog::find;
use plumbline_tool::cli::Options;
use plumbline_tool::serve::{Server, Settings};
use serde_json::{Value, json};
use std::io::Write;

pub fn data_sheet(product: &str) -> String {
    descriptors::describe(find(product).expect("a product")).text
}

pub fn send(server: &Running, name: &str, text: &str) -> Answer {
    let body = json!({"name": name, "text": text});
    server.post("/api/eds", &body.to_string())
}

/// Connects to a virtual sensor with a data sheet.
pub fn connect(
    server: &Running,
    product: &str,
    address: (&str, &str),
    sheet: &Value,
    yes: &[Value],
) -> Answer {
    let body = json!({
        "port": format!("demo:{product}"), "mode": "active",
        "protocol": address.0, "address": address.1, "product": sheet, "yes": yes,
    });
    server.post("/api/connect", &body.to_string())
}

pub const NODE: (&str, &str) = ("canopen", "10");

#[test]
fn canopen_device_is_read_set_stored_and_restored_by_its_data_sheet() {
    let server = Running::new();
    let sent = send(&server, "encoder 1.eds", &data_sheet("jn2101")).json();
    assert_eq!(
        (&sent["sheet"], &sent["name"], &sent["protocol"]),
        (&json!("eds:1"), &json!("jn2101-eds"), &json!("canopen"))
    );
    let products = server.get("/api/products").json();
    let listed = products.as_array().and_then(|all| all.last()).cloned();
    assert_eq!(listed.as_ref(), Some(&sent));
    let sheet = server.get("/api/parameters/eds:1").json();
    let resolution = sheet["entries"]
        .as_array()
        .and_then(|entries| entries.iter().find(|entry| entry["name"] == "resolution"));
    assert_eq!(resolution.expect("a parameter")["range"], "1..1000");
    let device = connect(&server, "jn2101", NODE, &sent["sheet"], &[]).json();
    assert_eq!(
        (&device["sheet"], &device["foreign"], &device["product"]),
        (&json!("eds:1"), &json!(true), &json!("jn2101-eds"))
    );
    let mut tab = server.tab();
    let values = tab.wait("values", |values| !values.is_null());
    assert_eq!(values["resolution"]["raw"], 10);
    tab.wait("samples", |_| true);
    run(
        &server,
        json!({"set": {"assignments": ["resolution=100"], "save": true}}),
    );
    assert_eq!(value(&server, "resolution"), 100);
    let action = tab.wait("action", |action| {
        action["line"]
            .as_str()
            .is_some_and(|line| line.contains(" set "))
    });
    assert_eq!(
        action["line"],
        "plumbline --port demo:jn2101 --node 10 '--eds=encoder 1.eds' set --save resolution=100"
    );
    let file = server.post("/api/backup", "{}").json();
    assert_eq!(
        (&file["sheet"], &file["product"]),
        (&json!("eds:1"), &json!("jn2101-eds"))
    );
    let body = json!({"text": file["text"], "name": "resolution", "value": "10"});
    let changed = server.post("/api/file/set", &body.to_string()).json();
    assert_eq!(changed["values"]["resolution"]["raw"], 10);
    let body = json!({"text": changed["text"], "name": "crane.toml"}).to_string();
    let restored = server.post("/api/restore", &body);
    assert_eq!(restored.status, 200, "{restored:?}");
    assert_eq!(value(&server, "resolution"), 10);
    for command in [
        json!({"node-id": {"new": 11}}),
        json!({"rate": {"new": "250"}}),
        json!({"zero": {}}),
    ] {
        let refused = server.post("/api/run", &command.to_string());
        assert_eq!(refused.code(), "not-offered", "{command}");
    }
    // Without a sensor the file is still known, and there is one with the default values.
    server.post("/api/disconnect", "{}");
    let body = json!({"text": file["text"]}).to_string();
    assert_eq!(server.post("/api/file", &body).json()["sheet"], "eds:1");
    let made = server.post("/api/file", r#"{"product":"eds:1"}"#).json();
    assert_eq!(made["values"]["resolution"]["raw"], 10);
    let another = Running::new().post("/api/file", &body);
    assert_eq!(another.code(), "bad-file");
}

#[test]
fn devicenet_device_without_known_angles_is_read_and_set() {
    let server = Running::new();
    let sent = send(&server, "tiltix.eds", &data_sheet("tiltix080")).json();
    let device = connect(
        &server,
        "tiltix080",
        ("devicenet", "63"),
        &sent["sheet"],
        &[],
    )
    .json();
    assert_eq!(device["angles"], json!([]));
    let mut tab = server.tab();
    let values = tab.wait("values", |values| !values.is_null());
    let resolution = json!({"value": 0.01, "unit": "deg", "raw": 10});
    assert_eq!(values["resolution"], resolution);
    run(
        &server,
        json!({"set": {"assignments": ["resolution=raw:100"]}}),
    );
    assert_eq!(value(&server, "resolution"), 0.1);
    let status = tab.wait("status", |status| status["busy"].is_null());
    assert_eq!(
        (&status["state"], &status["lost"], &status["silent"]),
        (&json!("active"), &json!(0), &json!(false))
    );
}

#[test]
fn data_sheet_of_another_device_is_used_only_after_a_yes() {
    let server = Running::new();
    let text = data_sheet("jn2101").replace("ProductNumber=0x", "ProductNumber=0x1");
    let sent = send(&server, "other.eds", &text).json();
    let asked = connect(&server, "jn2101", NODE, &sent["sheet"], &[]);
    assert_eq!(asked.code(), "asks");
    assert!(asked.body.contains("product code"), "{asked:?}");
    let question = asked.json()["error"]["questions"][0].clone();
    assert_eq!(question["id"], "data-sheet");
    let yes = [question];
    assert_eq!(
        connect(&server, "jn2101", NODE, &sent["sheet"], &yes).status,
        200
    );
    assert_eq!(value(&server, "resolution"), 10);
}

#[test]
fn hostile_data_sheets_are_refused_and_known_ones_are_taken_once() {
    let server = Running::new();
    let (long, deep) = (
        data_sheet("jn2101") + &";\r\n".repeat(400_000),
        "[".repeat(100_000),
    );
    for text in [
        "",
        "\0\u{FFFD}",
        "[Device]\n[Params]\nParam1 = \"",
        "[DeviceInfo]\nProductName=x\n",
        &long,
        &deep,
    ] {
        let answer = send(&server, "../../etc/\u{1b}[2Jx.eds", text);
        assert_eq!(
            (answer.status, answer.code().as_str()),
            (400, "bad-file"),
            "{text:.20}"
        );
        assert!(
            !answer.json()["error"]["message"]
                .as_str()
                .is_some_and(|text| text.contains('\u{1b}'))
        );
    }
    assert_eq!(
        server.get("/api/parameters/eds:1").code(),
        "unknown-product"
    );
    let unknown = connect(&server, "jn2101", NODE, &json!("eds:1"), &[]);
    assert_eq!(unknown.code(), "unknown-product");
    // A file of the server cannot be named.
    for product in ["eds:/etc/passwd", "--eds=/etc/passwd", "--yes"] {
        let refused = connect(&server, "jn2101", NODE, &json!(product), &[]);
        assert_eq!(
            (refused.status, refused.code().as_str()),
            (400, "unknown-product"),
            "{product}"
        );
    }
    let text = data_sheet("ims360");
    let mut tab = server.tab();
    let first = send(&server, "one.eds", &text).json();
    assert_eq!(
        tab.wait("sheets", |rows| rows != &json!([])),
        json!([first])
    );
    assert_eq!(send(&server, "--version", &text).json(), first);
    let other = text.replace("ProductNumber=0x", "ProductNumber=0x1");
    assert_eq!(send(&server, "--version", &other).json()["sheet"], "eds:2");
}

#[test]
fn data_sheet_of_the_command_line_is_offered_first() {
    let mut file = tempfile::Builder::new()
        .suffix(".eds")
        .tempfile()
        .expect("a file");
    file.write_all(data_sheet("jn2101").as_bytes())
        .expect("it is written");
    let server = Running::with_data_sheet(file.path().to_owned());
    let first = server.get("/api/ports").json()["first"].clone();
    assert_eq!(first["product"], "eds:1");
    let device = connect(&server, "jn2101", NODE, &first["product"], &[]).json();
    assert_eq!(device["product"], "jn2101-eds");
    let settings = |path: &str| Settings {
        listen: "127.0.0.1:0".parse().expect("an address"),
        options: Options {
            eds: Some(path.into()),
            ..Options::default()
        },
        demo: false,
        unit: None,
        store: None,
    };
    for (path, code) in [("/nonexistent.eds", "no-file"), ("/dev/null", "bad-file")] {
        let refused = Server::bind(settings(path)).err().expect("it is refused");
        assert_eq!(refused.code(), code);
    }
}
