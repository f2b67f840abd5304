//! The identity of a unit: from the sensor and from a file, into the store file of the command line.

use crate::serve::api::run;
use crate::serve::client::Running;
use crate::serve::fast_bus;
use bench::{Flash, Geometry, STORE_BUFFER};
use plumbline::model::catalog::find;
use plumbline::store::Store;
use serde_json::{Value, json};

#[test]
fn page_writes_identity_into_store_file_of_the_command_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let store = folder.path().join("unit.bin");
    let server = Running::with_store(Box::new(fast_bus::connect), Some(store.clone()));
    assert_eq!(server.get("/api/ports").json()["store"], json!(store));
    let body = json!({"port": "demo:tiltix080", "mode": "active"}).to_string();
    assert_eq!(server.post("/api/connect", &body).status, 200);
    let told = run(&server, json!("identity"));
    assert_eq!(told["identity"]["product-code"], 80);
    let sheet = told["sheet"].as_str().expect("a text");
    let sheet = sheet.replace("serial = 1 ", "serial = 77 ");
    let body = json!({"text": sheet, "name": "old.toml"}).to_string();
    let read = server.post("/api/identity", &body).json();
    assert_eq!(
        (&read["product"], &read["identity"]["serial"]),
        (&json!("tiltix080"), &json!(77))
    );
    assert!(!store.exists(), "reading writes nothing");
    assert_eq!(server.post("/api/identity/store", &body).status, 200);
    let flash = Flash::in_file(Geometry::STM32F103, &store).expect("a store");
    let owner = find("tiltix080").expect("a product").owner(1);
    let unit = Store::<_, [u8; STORE_BUFFER]>::open(flash, owner)
        .boot()
        .unit;
    assert_eq!((unit.serial, unit.product_code), (Some(77), Some(80)));
    let line = format!(
        "plumbline identity --from=old.toml --store={}",
        store.display()
    );
    server.tab().wait("action", |action| {
        action["line"] == line && action["state"] == "done"
    });
}

#[test]
fn bad_identity_and_missing_store_file_are_refused_with_the_next_step() {
    let server = Running::new();
    let post = |path: &str, body: Value| {
        let answer = server.post(path, &body.to_string());
        (answer.status, answer.code())
    };
    let sheet = "product = \"tiltix080\"\nproduct-code = 70000\n";
    for (body, code) in [
        (json!({"text": sheet, "name": "a.toml"}), "bad-file"),
        (json!({"text": "", "name": "a.toml"}), "unknown-product"),
        (
            json!({"text": "[Device]\n", "name": "a.eds", "product": "is2"}),
            "bad-file",
        ),
        (json!({"text": sheet}), "bad-request"),
    ] {
        let expected = (400, code.to_owned());
        assert_eq!(post("/api/identity", body.clone()), expected, "{body}");
    }
    let whole = json!({"text": "product = \"is2\"\nserial = 7\n", "name": "a.toml"});
    let expected = (400, "no-store".to_owned());
    assert_eq!(post("/api/identity/store", whole), expected);
}
