//! Sensors of the other protocols, and devices with a data sheet (EDS).

use crate::controls::User;
use crate::reading::everything_is_named;
use plumbline::model::catalog::find;
use std::io::Write;
use tempfile::NamedTempFile;

#[track_caller]
fn is_hidden(user: &User, id: &str) {
    let hidden = user
        .browser
        .value(&format!("document.getElementById('{id}').hidden"));
    assert_eq!(hidden, true, "{id}");
}

/// The products of the other protocols, found by a scan and by address.
pub fn other_products(user: &User) {
    user.write("port", "demo:jn2101");
    user.click("find");
    user.wait("document.getElementById('question').open");
    user.click("question-yes");
    user.wait("document.querySelector('#found button')");
    everything_is_named(&user.browser);
    user.browser.keys("#found button", "\u{E007}");
    user.done("watch");
    // The row stays, and with it the focus.
    user.wait("document.activeElement.closest('#found')");
    assert_eq!(
        user.browser
            .value("document.getElementById('address').value"),
        "10"
    );
    user.confirm("teach", "reference frame");
    user.done("teach");
    user.answer("node-id", "11");
    user.wait("document.getElementById('found-empty').textContent.includes('address 11')");
    user.done("--node=11 watch");
    user.click("disconnect");
    user.choose("protocol", "devicenet");
    user.write("address", "63");
    user.choose("product", "tiltix080");
    user.connect("demo:tiltix080");
    user.answer("mac", "7");
    user.done("--mac=7");
    user.wait("document.getElementById('angle-0').textContent !== '-'");
    user.click("bit-rate");
    user.wait("document.getElementById('question').open");
    user.browser.choose("#question-input", "250");
    user.click("question-yes");
    user.wait("document.getElementById('bus').textContent.includes('250 kbit/s')");
    user.done("--rate 250");
}

/// A sensor in J1939 that a scan has found is connected by a click, set, zeroed, and gets another address.
pub fn in_j1939(user: &User) {
    user.click("disconnect");
    user.choose("rate", "250");
    user.write("port", "demo:ims360/j1939");
    let offered = "[...document.querySelectorAll('#ports option')].some(({ value }) => value === 'demo:ims360/j1939')";
    user.wait(offered);
    user.confirm("find", "listens");
    let bar = "document.getElementById('progress-bar')";
    user.wait(&format!(
        "{bar}.hidden && document.getElementById('found').textContent.includes('j1939 128')"
    ));
    user.browser.click("#found button");
    user.done("--address=128 watch");
    user.wait("document.getElementById('angle-1').textContent !== '-'");
    for id in ["node-id", "mac"] {
        is_hidden(user, id);
    }
    user.browser.click("[aria-label=\"Set cut-off\"]");
    user.wait("document.getElementById('question').open");
    user.browser.write("#question-input", "2.5Hz");
    user.click("question-yes");
    user.done("set cut-off=2.5Hz");
    assert_eq!(user.sensor("cut-off"), "2500 mHz");
    user.confirm("zero", "becomes zero");
    user.done("zero");
    user.confirm("save", "stores its present settings");
    user.done("save");
    user.answer("j1939-address", "160");
    user.done("--address=160 watch");
    user.wait("document.getElementById('found-empty').textContent.includes('address 160')");
    // The address can be typed as well.
    user.click("disconnect");
    user.choose("protocol", "j1939");
    user.write("address", "160");
    user.choose("product", "");
    user.connect("demo:ims360/j1939");
    user.wait("document.getElementById('angle-1').textContent !== '-'");
    user.click("disconnect");
}

/// The file of a data sheet.
fn file(text: &[u8]) -> NamedTempFile {
    let file = tempfile::Builder::new().suffix(".eds").tempfile();
    let mut file = file.expect("a file");
    file.write_all(text).expect("it is written");
    file
}

#[track_caller]
fn open(user: &User, file: &NamedTempFile) {
    user.note("eds");
    user.browser
        .keys("#eds", file.path().to_str().expect("a path"));
}

/// Devices that are not in the catalogue are read and set by the names of the data sheet that the user chooses.
pub fn with_data_sheets(user: &User) {
    let text = |product: &str| descriptors::describe(find(product).expect("a product")).text;
    // With a letter in Latin-1.
    let text_of_maker = text("jn2101").replace("VendorName=Plumbline", "VendorName=M\u{fc}ller");
    let latin: Vec<u8> = text_of_maker.chars().map(|letter| letter as u8).collect();
    let sheet = file(&latin);
    user.choose("rate", "");
    open(user, &sheet);
    let state = "document.getElementById('eds-state')";
    user.wait(&format!("{state}.textContent.includes('Give the address')"));
    assert_eq!(
        user.browser.value("[document.getElementById('product').value, document.getElementById('protocol').value, document.activeElement.id]"),
        serde_json::json!(["eds:1", "canopen", "address"])
    );
    user.choose("language", "de");
    user.wait(&format!(
        "{state}.textContent.includes('Geben Sie die Adresse')"
    ));
    user.choose("language", "en");
    everything_is_named(&user.browser);
    user.write("address", "10");
    user.connect("demo:jn2101");
    user.wait("document.getElementById('found-empty').textContent.includes('jn2101-eds')");
    user.wait("document.getElementById('angle-0')?.textContent !== '-'");
    for id in [
        "node-id",
        "mac",
        "j1939-address",
        "bit-rate",
        "zero",
        "teach",
    ] {
        is_hidden(user, id);
    }
    user.wait("document.getElementById('file-resolution')");
    user.browser
        .script("document.getElementById('file-resolution').scrollIntoView({ block: 'center' })");
    user.browser.click("[aria-label=\"Set resolution\"]");
    user.wait("document.getElementById('question').open");
    user.browser.write("#question-input", "100");
    user.click("question-yes");
    user.done("set resolution=100");
    user.wait("document.getElementById('file-resolution').closest('tr').children[1].textContent === '100'");
    user.click("disconnect");
    // A file that is not a data sheet changes nothing.
    open(user, &file(b"[Device]\n[Params]\nParam1 = \"\n"));
    user.wait("document.getElementById('message').textContent.includes('is not a data sheet')");
    open(user, &file(&vec![b' '; (1 << 20) + 1]));
    user.wait("document.getElementById('message').textContent.includes('longer than 1 MiB')");
    // A device whose data sheet does not say which values are angles.
    open(user, &file(text("tiltix080").as_bytes()));
    user.wait("document.getElementById('product').value === 'eds:2'");
    user.write("address", "63");
    user.connect("demo:tiltix080");
    user.wait("document.getElementById('angles-empty').textContent.includes('does not say which values are angles')");
    user.wait("document.getElementById('rows').textContent.includes('0.01 deg')");
    user.click("disconnect");
    user.choose("product", "");
    user.wait(&format!("{state}.hidden"));
}
