//! A headless Chromium with one tab.

use fantoccini::actions::{InputSource, KeyAction, KeyActions};
use fantoccini::elements::Element;
use fantoccini::error::{CmdError, ErrorStatus};
use fantoccini::wd::WebDriverCompatibleCommand;
use fantoccini::{Client, ClientBuilder, Locator};
use http::Method;
use hyper_util::client::legacy::connect::HttpConnector;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write, stderr};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::channel;
use std::thread;
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tokio::runtime::{Builder, Runtime};
use url::{ParseError, Url};

/// The longest wait for the page, on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// The question is shown.
pub const OPEN: &str = "document.getElementById('question').open";

/// The page is connected to a sensor.
pub const CONNECTED: &str = "document.getElementById('state').textContent === 'connected'";

/// The text of the newest action of the log.
const NEWEST: &str = "(document.querySelector('#log-rows li')?.textContent ?? '')";

/// How often the start of the browser is tried.
const STARTS: usize = 3;

/// Chromium with one page, driven by chromedriver.
pub struct Browser {
    runtime: Runtime,
    client: Option<Client>,
    _driver: Driver,
    profile: TempDir,
}

/// A running chromedriver; it is killed when this is dropped.
struct Driver(Child);

impl Driver {
    /// Starts it; returns its port too.
    fn start() -> Result<(Self, u16), String> {
        let mut child = Command::new("chromedriver")
            .arg("--port=0")
            // The page has the language of the browser.
            .env("LANGUAGE", "en")
            .env("LANG", "C.UTF-8")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("chromedriver starts");
        let output = BufReader::new(child.stdout.take().expect("its output"));
        let driver = Self(child);
        let (sender, port) = channel();
        thread::spawn(move || {
            for line in output.lines().map_while(Result::ok) {
                let port = line.split("successfully on port ").nth(1);
                if let Some(Ok(port)) = port.map(|port| port.trim_end_matches('.').parse()) {
                    let _ = sender.send(port);
                }
            }
        });
        let port = port.recv_timeout(PATIENCE);
        let port = port.map_err(|_| "chromedriver does not print its port")?;
        Ok((driver, port))
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Whether an error is only of the moment: the page replaces the element, moves it, or has another one over it.
fn is_of_the_moment(error: &CmdError) -> bool {
    let is_covered = matches!(
        error,
        CmdError::Standard(own) if own.error == ErrorStatus::ElementClickIntercepted
    );
    is_covered || error.is_stale_element_reference() || error.is_element_not_interactable()
}

#[derive(Debug)]
struct Vendor {
    path: &'static str,
    body: Value,
}

impl WebDriverCompatibleCommand for Vendor {
    fn endpoint(&self, base: &Url, session: Option<&str>) -> Result<Url, ParseError> {
        base.join(&format!(
            "session/{}/{}",
            session.unwrap_or_default(),
            self.path
        ))
    }

    fn method_and_body(&self, _: &Url) -> (Method, Option<String>) {
        (Method::POST, Some(self.body.to_string()))
    }
}

/// Whether a program can be started.
fn exists(program: &str) -> bool {
    let mut command = Command::new(program);
    let silent = command
        .arg("--version")
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    silent.status().is_ok_and(|status| status.success())
}

impl Browser {
    /// Starts it; None without Chromium.
    pub fn start() -> Option<Self> {
        for program in ["chromium", "chromedriver"] {
            if !exists(program) {
                assert!(std::env::var_os("CI").is_none(), "there is no {program}");
                let _ = writeln!(stderr(), "skipped: page: there is no {program}");
                return None;
            }
        }
        // On a busy machine, chromedriver or Chromium can take longer to start than the other one waits.
        let mut started = Self::started();
        for _ in 1..STARTS {
            let Err(error) = &started else {
                break;
            };
            let _ = writeln!(stderr(), "the browser is started again: {error}");
            started = Self::started();
        }
        Some(started.unwrap_or_else(|error| panic!("{error}")))
    }

    fn started() -> Result<Self, String> {
        let (driver, port) = Driver::start()?;
        let profile = tempfile::tempdir().expect("a folder");
        let options = json!({"args": [
            "--headless=new",
            "--lang=en-US",
            "--no-sandbox",
            "--window-size=1400,1500",
            "--disable-dev-shm-usage",
            "--enable-precise-memory-info",
            format!("--user-data-dir={}", profile.path().display()),
        ], "prefs": {"download.default_directory": profile.path()}});
        let capabilities = json!({
            "goog:chromeOptions": options,
            "goog:loggingPrefs": {"browser": "ALL"},
        });
        let runtime = Builder::new_current_thread()
            .enable_all()
            .build()
            .expect("a runtime");
        let client = runtime.block_on(async {
            let mut builder = ClientBuilder::new(HttpConnector::new());
            builder.capabilities(capabilities.as_object().expect("an object").clone());
            builder.connect(&format!("http://127.0.0.1:{port}")).await
        });
        let client = client.map_err(|error| error.to_string())?;
        Ok(Self {
            runtime,
            client: Some(client),
            _driver: driver,
            profile,
        })
    }

    fn client(&self) -> &Client {
        self.client.as_ref().expect("it is open")
    }

    /// Opens a page, in a window as at the start.
    pub fn open(&self, url: &str) {
        self.devtools("Emulation.clearDeviceMetricsOverride", json!({}));
        // The messages of an earlier page.
        self.go("about:blank");
        self.console();
        self.go(url);
        self.wait("document.getElementById('rate')?.options.length > 10");
    }

    pub fn go(&self, url: &str) {
        let went = self.runtime.block_on(self.client().goto(url));
        went.unwrap_or_else(|error| panic!("{error}"));
    }

    /// Runs a script, which returns a value.
    #[track_caller]
    pub fn script(&self, script: &str) -> Value {
        let run = self
            .runtime
            .block_on(self.client().execute(script, Vec::new()));
        run.unwrap_or_else(|error| panic!("{script}: {error}"))
    }

    /// The value of a JavaScript expression.
    #[track_caller]
    pub fn value(&self, expression: &str) -> Value {
        self.script(&format!("return {expression}"))
    }

    /// The value of a JavaScript expression as text.
    #[track_caller]
    pub fn text(&self, expression: &str) -> String {
        match self.value(expression) {
            Value::String(text) => text,
            other => other.to_string(),
        }
    }

    /// Waits until an expression is true.
    #[track_caller]
    pub fn wait(&self, expression: &str) {
        let start = Instant::now();
        while self.value(&format!("!!({expression})")) != true {
            if start.elapsed() > PATIENCE {
                let message = self.text("document.getElementById('message').textContent");
                let state = self.text("document.getElementById('state').textContent");
                panic!(
                    "not true in time: {expression}; {state}; {message}; {:?}",
                    self.console()
                );
            }
            thread::sleep(Duration::from_millis(10));
        }
    }

    /// Clicks an element as a user does, when it can be pressed.
    #[track_caller]
    pub fn click(&self, selector: &str) {
        self.wait(&format!(
            "!(document.querySelector({selector:?})?.matches(':disabled') ?? true)"
        ));
        self.act(selector, async |element| element.click().await);
    }

    /// Does something with an element as a user does, who tries again when it was not possible at the moment.
    #[track_caller]
    fn act(&self, selector: &str, action: impl AsyncFn(Element) -> Result<(), CmdError>) {
        let start = Instant::now();
        loop {
            let done = self.runtime.block_on(async {
                action(self.client().find(Locator::Css(selector)).await?).await
            });
            match done {
                Ok(()) => return,
                Err(error) if is_of_the_moment(&error) && start.elapsed() < PATIENCE => {
                    thread::sleep(Duration::from_millis(20));
                }
                Err(error) => panic!("{selector}: {error}; {:?}", self.console()),
            }
        }
    }

    /// Types a text into a field, instead of what it has.
    #[track_caller]
    pub fn write(&self, selector: &str, text: &str) {
        self.act(selector, async |element| {
            element.clear().await?;
            element.send_keys(text).await
        });
    }

    /// Presses keys at an element.
    #[track_caller]
    pub fn keys(&self, selector: &str, keys: &str) {
        self.act(selector, async |element| element.send_keys(keys).await);
    }

    /// Presses keys of the keyboard, one after the other, with these held down (Shift).
    #[track_caller]
    pub fn press(&self, held: &str, keys: &str) {
        let mut actions = KeyActions::new("keyboard".to_owned());
        for value in held.chars() {
            actions = actions.then(KeyAction::Down { value });
        }
        for value in keys.chars() {
            actions = actions.then(KeyAction::Down { value });
            actions = actions.then(KeyAction::Up { value });
        }
        for value in held.chars() {
            actions = actions.then(KeyAction::Up { value });
        }
        let pressed = self
            .runtime
            .block_on(self.client().perform_actions(actions));
        pressed.unwrap_or_else(|error| panic!("{error}"));
    }

    /// Chooses an option by its value.
    #[track_caller]
    pub fn choose(&self, selector: &str, value: &str) {
        self.act(selector, async |element| {
            element.select_by_value(value).await
        });
    }

    /// Waits until the newest action of the log is this one, and is done.
    #[track_caller]
    pub fn done(&self, command: &str) {
        self.wait(&format!(
            "{NEWEST}.includes({command:?}) && {NEWEST}.includes('done')"
        ));
        self.wait(CONNECTED);
    }

    /// Gives the window this width, and a height of 900 px.
    #[track_caller]
    pub fn resize(&self, width: u32) {
        let size = json!({"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": false});
        self.devtools("Emulation.setDeviceMetricsOverride", size);
        self.wait(&format!("innerWidth === {width}"));
    }

    /// The text that an element shows.
    #[track_caller]
    pub fn shown(&self, selector: &str) -> String {
        self.text(&format!("document.querySelector({selector:?}).textContent"))
    }

    /// A command of the DevTools protocol.
    #[track_caller]
    pub fn devtools(&self, method: &str, parameters: Value) -> Value {
        let command = Vendor {
            path: "goog/cdp/execute",
            body: json!({"cmd": method, "params": parameters}),
        };
        let run = self.runtime.block_on(self.client().issue_cmd(command));
        run.unwrap_or_else(|error| panic!("{method}: {error}"))
    }

    /// The messages of the console since the last call, without hints.
    #[track_caller]
    pub fn console(&self) -> Vec<String> {
        let command = Vendor {
            path: "se/log",
            body: json!({"type": "browser"}),
        };
        let run = self.runtime.block_on(self.client().issue_cmd(command));
        let log = run.unwrap_or_else(|error| panic!("{error}"));
        let entries = log.as_array().cloned().unwrap_or_default();
        entries.iter().map(Value::to_string).collect()
    }

    /// A file that the page has saved.
    #[track_caller]
    pub fn saved(&self, name: &str) -> String {
        let (path, start) = (self.profile.path().join(name), Instant::now());
        while start.elapsed() < PATIENCE {
            if let Ok(text) = std::fs::read_to_string(&path) {
                return text;
            }
            thread::sleep(Duration::from_millis(50));
        }
        panic!("{name} was not saved");
    }

    /// A picture of the window as PNG.
    pub fn picture(&self) -> Vec<u8> {
        let taken = self.runtime.block_on(self.client().screenshot());
        taken.unwrap_or_else(|error| panic!("{error}"))
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        if let Some(client) = self.client.take() {
            let _ = self.runtime.block_on(client.close());
        }
    }
}
