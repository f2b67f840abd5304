//! Every control of the page, used once.

use crate::browser::Browser;
use crate::devices;
use crate::reading::everything_is_named;
use crate::server::Running;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::io::Write;

/// A browser that notes which controls were used.
pub struct User {
    pub browser: Browser,
    used: RefCell<BTreeSet<String>>,
}

impl User {
    pub fn note(&self, id: &str) -> String {
        self.used.borrow_mut().insert(id.to_owned());
        format!("[id=\"{id}\"]")
    }

    #[track_caller]
    pub fn click(&self, id: &str) {
        let selector = self.note(id);
        self.browser
            .wait(&format!("!document.querySelector('{selector}').disabled"));
        self.browser.click(&selector);
    }

    #[track_caller]
    pub fn write(&self, id: &str, text: &str) {
        let selector = self.note(id);
        self.browser.write(&selector, text);
    }

    #[track_caller]
    pub fn choose(&self, id: &str, value: &str) {
        let selector = self.note(id);
        self.browser.choose(&selector, value);
    }

    #[track_caller]
    pub fn wait(&self, expression: &str) {
        self.browser.wait(expression);
    }

    /// The lines of the log, the newest first, each with its state.
    fn log(&self) -> Vec<String> {
        let lines = self.browser.value(
            "[...document.querySelectorAll('#log-rows li')].map((line) => line.querySelector('code').textContent + ' | ' + line.querySelector('.row > div').lastChild.textContent.trim())",
        );
        let lines = lines.as_array().cloned().unwrap_or_default();
        lines
            .iter()
            .filter_map(|line| line.as_str().map(str::to_owned))
            .collect()
    }

    /// Waits until the newest action is this one, and is done.
    #[track_caller]
    pub fn done(&self, command: &str) {
        self.browser.done(command);
    }

    /// Opens a question, reads it, and says yes.
    #[track_caller]
    pub fn confirm(&self, id: &str, contains: &str) {
        self.click(id);
        self.wait("document.getElementById('question').open");
        let text = self.browser.shown("#question-text") + &self.browser.shown("#question-field");
        assert!(text.contains(contains), "{id}: {text}");
        self.click("question-yes");
        self.wait("!document.getElementById('question').open");
    }

    /// Answers a question with a field.
    #[track_caller]
    pub fn answer(&self, id: &str, value: &str) {
        self.click(id);
        self.wait("document.getElementById('question').open");
        self.browser.write("#question-input", value);
        self.click("question-yes");
    }

    /// The value of a parameter in the column of the sensor.
    pub fn sensor(&self, name: &str) -> String {
        self.browser.text(&format!(
            "document.getElementById('file-{name}').closest('tr').children[1].textContent"
        ))
    }

    pub fn connect(&self, port: &str) {
        self.write("port", port);
        self.click("connect");
        self.done("watch");
    }
}

#[test]
fn every_control_does_what_it_says() {
    let server = Running::new("demo:is2");
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    let user = User {
        browser,
        used: RefCell::default(),
    };
    user.wait("document.getElementById('state').textContent === 'connected'");
    user.wait("document.getElementById('angle-1') && document.getElementById('angle-1').textContent !== '-'");
    assert_eq!(
        user.browser.value("location.hash"),
        "",
        "the secret is not in the address any more"
    );
    preferences(&user);
    chart(&user);
    actions(&user);
    parameters(&user);
    files(&user);
    requests(&user);
    connections(&user);
    calibration(&user);
    devices::other_products(&user);
    devices::in_j1939(&user);
    devices::with_data_sheets(&user);

    let controls = user.browser.value(
        "[...document.querySelectorAll('button[id], input[id], select[id]')].filter((control) => !control.closest('#question-field')).map(({ id }) => id).filter((id) => !id.startsWith('file-'))",
    );
    let controls = controls.as_array().cloned().unwrap_or_default();
    let unused: Vec<_> = controls
        .iter()
        .filter_map(|id| id.as_str())
        .filter(|id| !user.used.borrow().contains(*id))
        .collect();
    assert!(
        controls.len() >= 40 && unused.is_empty(),
        "not used: {unused:?}"
    );
    // The browser reports refused requests, which the page has shown to the user.
    let console = user.browser.console();
    let errors: Vec<_> = console
        .iter()
        .filter(|line| {
            !line.contains("the server responded with a status of 4")
                && !line.contains("the server responded with a status of 5")
        })
        .collect();
    assert!(errors.is_empty(), "{errors:?}");
}

fn preferences(user: &User) {
    user.choose("language", "de");
    user.wait("document.getElementById('angles-title').textContent === 'Winkel' && document.documentElement.lang === 'de'");
    user.wait("document.getElementById('condition').textContent.includes('kein Fehler')");
    user.choose("language", "en");
    user.wait("document.getElementById('angles-title').textContent === 'Angles'");
    let ground =
        |browser: &Browser| browser.text("getComputedStyle(document.body).backgroundColor");
    user.choose("theme", "light");
    let light = ground(&user.browser);
    user.choose("theme", "dark");
    assert_ne!(ground(&user.browser), light);
    user.choose("theme", "auto");
}

fn chart(user: &User) {
    user.choose("samples", "0");
    user.wait("document.getElementById('angles-empty').textContent.includes('Sampling is off')");
    user.choose("samples", "100");
    user.choose("window", "5");
    user.wait("document.getElementById('angles-empty').hidden");
    let got = user.browser.value("plumbline.got");
    user.wait(&format!("plumbline.got > {got} + 100"));
    user.click("pause");
    user.wait("document.getElementById('pause').getAttribute('aria-pressed') === 'true'");
    user.browser.keys("#chart", "\u{E014}");
    user.wait("/^-?[0-9.]+$/.test(document.querySelectorAll('.u-legend .u-value')[1].textContent)");
    user.browser.keys("#chart", " ");
    user.wait("document.getElementById('pause').getAttribute('aria-pressed') === 'false'");
    user.click("csv");
    let table = user.browser.saved("angles.csv");
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("time_s,angle-x_deg,angle-y_deg"));
    assert!(
        lines.clone().count() > 20 && lines.all(|line| line.split(',').count() == 3),
        "{table}"
    );
    user.click("clear");
    user.choose("samples", "50");
}

fn actions(user: &User) {
    let zeros = || user.log().join("\n").matches(" zero").count();
    let before = zeros();
    user.click("zero");
    user.wait("document.getElementById('question').open");
    let question = user.browser.shown("#question-text");
    assert!(
        question.contains("serial number 1, address 300") && question.contains("angle-x"),
        "{question}"
    );
    user.click("question-no");
    user.wait("!document.getElementById('question').open");
    user.confirm("zero", "becomes zero");
    user.done("zero");
    assert_eq!(zeros(), before + 1, "a no does nothing");
    user.click("zero-x");
    user.wait("document.getElementById('question').open");
    user.browser.click("#question-check-0");
    user.click("question-yes");
    user.done("zero --save x");
    user.confirm("zero-y", "becomes zero");
    user.done("zero y");
    // The noise can have a mean of 0 in one axis.
    user.wait(
        "['x', 'y'].some((axis) => document.getElementById(`file-zero-${axis}`).closest('tr').children[1].textContent !== '0 deg')",
    );
    user.answer("label", "boom");
    user.done("label boom");
    user.wait("document.getElementById('found-empty').textContent.includes('boom')");
    user.confirm("save", "stores its present settings");
    user.done("save");
    user.confirm("load-factory", "factory values");
    user.done("load-factory");
    user.wait("document.getElementById('file-zero-x').closest('tr').children[1].textContent.startsWith('0')");
    user.confirm("restart", "restarts");
    user.done("restart");
    user.wait("!document.getElementById('restart').disabled");
    // The line can be copied.
    user.browser.click_until(
        "#log-rows button",
        "document.querySelector('#log-rows button').textContent === 'Copied' || getSelection().toString().includes('plumbline')",
    );
}

fn parameters(user: &User) {
    user.click("read");
    user.done("get");
    user.browser.click("[aria-label=\"Set cut-off\"]");
    user.wait("document.getElementById('question').open");
    assert!(
        user.browser
            .shown("#question-hint")
            .contains("100..25000 mHz")
    );
    user.browser.write("#question-input", "2.5Hz");
    user.click("question-yes");
    user.done("set cut-off=2.5Hz");
    assert_eq!(user.sensor("cut-off"), "2500 mHz");
    // A value that is not permitted is refused with its range.
    user.browser.click("[aria-label=\"Set cyclic-time\"]");
    user.wait("document.getElementById('question').open");
    user.browser.write("#question-input", "0");
    user.click("question-yes");
    user.wait("document.getElementById('message').textContent.includes('1..65535 ms')");
    assert_eq!(user.sensor("cyclic-time"), "250 ms");
}

fn files(user: &User) {
    user.click("backup");
    user.done("backup FILE.toml");
    user.wait("document.getElementById('file-state').textContent.includes('is2-1.toml')");
    user.browser.write("#file-cyclic-time", "0\u{E007}");
    user.wait(
        "document.getElementById('file-cyclic-time').getAttribute('aria-invalid') === 'true'",
    );
    user.browser.write("#file-cyclic-time", "0.1s\u{E007}");
    user.wait("document.getElementById('file-cyclic-time').value === '100 ms'");
    user.browser.choose("#file-filter-type", "Butterworth");
    user.wait(
        "document.getElementById('file-state').textContent.includes('differ from the sensor: 2.')",
    );
    let visible =
        "[...document.querySelectorAll('#rows tr')].filter((line) => !line.hidden).length";
    user.click("only-differences");
    user.wait(&format!("{visible} === 2"));
    user.write("search", "cyclic");
    user.wait(&format!("{visible} === 1"));
    user.click("only-differences");
    user.write("search", "x\u{E003}");
    user.wait(&format!("{visible} > 10"));
    // First, one difference only.
    user.click("restore");
    user.wait("document.getElementById('question').open");
    user.browser.click("#question-check-0");
    user.click("question-yes");
    user.done("restore is2-1.toml --only filter-type");
    assert_eq!(user.sensor("cyclic-time"), "250 ms");
    user.confirm("restore", "cyclic-time: 250 ms → 100 ms");
    user.done("restore is2-1.toml --only cyclic-time");
    assert_eq!(
        (
            user.sensor("cyclic-time").as_str(),
            user.sensor("filter-type").as_str()
        ),
        ("100 ms", "Butterworth")
    );
    user.click("download");
    let text = user.browser.saved("is2-1.toml");
    assert!(text.contains("cyclic-time = \"100 ms\""), "{text}");
    // Without a sensor.
    user.click("disconnect");
    user.wait("document.getElementById('state').textContent === 'not connected'");
    user.choose("template", "jn2101");
    user.click("new-file");
    user.wait("document.getElementById('file-heating')?.value === 'on'");
    user.browser.choose("#file-heating", "off");
    user.wait("document.getElementById('file-state').textContent.includes('Not saved')");
    let mut file = tempfile::Builder::new()
        .suffix(".toml")
        .tempfile()
        .expect("a file");
    file.write_all(text.as_bytes()).expect("it is written");
    user.note("file");
    user.browser
        .keys("#file", file.path().to_str().expect("a path"));
    // The changes of the other file are not lost without a question.
    user.wait("document.getElementById('question').open");
    user.click("question-yes");
    user.wait("document.getElementById('file-cyclic-time')?.value === '100 ms'");
}

fn requests(user: &User) {
    user.connect("demo:is2");
    user.write("request", "04");
    user.confirm("send", "as it is");
    user.wait("document.getElementById('answer').textContent.startsWith('04')");
    user.done("raw 04");
    user.wait("[...document.querySelectorAll('#frame-rows tr')].some((line) => line.textContent.includes('301h'))");
}

fn connections(user: &User) {
    user.choose("rate", "125");
    user.choose("mode", "listen");
    user.click("connect");
    user.wait("document.getElementById('state').textContent === 'listening'");
    user.wait("document.getElementById('bus').textContent.includes('125 kbit/s')");
    user.choose("mode", "active");
    user.choose("rate", "");
    user.click("find");
    user.wait("document.getElementById('question').open");
    user.click("question-yes");
    user.wait("document.getElementById('progress').textContent.includes('listened at')");
    user.click("stop");
    user.wait("document.getElementById('message').textContent.includes('stopped')");
    user.wait("document.getElementById('found-empty').textContent.startsWith('Stopped')");
}

fn calibration(user: &User) {
    let question = "document.getElementById('calibrate-take').dataset.question";
    user.click("calibrate-start");
    user.wait(question);
    user.wait("document.getElementById('calibrate-step').textContent.includes('Position 1 of 6')");
    let first = user.browser.text(question);
    user.click("calibrate-again");
    user.wait(&format!("{question} && {question} !== '{first}'"));
    let positions = "document.getElementById('calibrate-positions').textContent";
    assert!(!user.browser.text(positions).contains("+z: taken"));
    user.click("calibrate-take");
    user.wait(&format!("{positions}.includes('+z: taken')"));
    everything_is_named(&user.browser);
    user.wait("document.getElementById('calibrate-step').textContent.includes('-z up')");
    user.click("calibrate-stop");
    user.wait("document.getElementById('calibrate-step').textContent.startsWith('stopped')");
    user.wait("!document.getElementById('calibrate-start').disabled");
}
