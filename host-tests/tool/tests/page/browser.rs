//! A headless Chromium with one tab.

use fantoccini::actions::{InputSource, KeyAction, KeyActions};
use fantoccini::wd::WebDriverCompatibleCommand;
use fantoccini::{Client, ClientBuilder, Locator};
use http::Method;
use hyper_util::client::legacy::connect::HttpConnector;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write, stderr};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::runtime::{Builder, Runtime};
use url::{ParseError, Url};

/// The longest wait for the page, on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// A browser. Only one browser runs at a time: two browsers slow each other down.
pub struct Browser {
    runtime: Runtime,
    client: Option<Client>,
    driver: Child,
    profile: tempfile::TempDir,
    _alone: MutexGuard<'static, ()>,
}

/// A command of Chromium.
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
    /// Opens a page; None without Chromium.
    pub fn open(url: &str) -> Option<Self> {
        static ALONE: Mutex<()> = Mutex::new(());
        let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
        for program in ["chromium", "chromedriver"] {
            if !exists(program) {
                assert!(std::env::var_os("CI").is_none(), "there is no {program}");
                let _ = writeln!(stderr(), "skipped: page: there is no {program}");
                return None;
            }
        }
        let mut driver = Command::new("chromedriver")
            .arg("--port=0")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("chromedriver starts");
        let output = BufReader::new(driver.stdout.take().expect("its output"));
        let port = output
            .lines()
            .map_while(Result::ok)
            .find_map(|line| {
                let port = line.split("successfully on port ").nth(1)?;
                port.trim_end_matches('.').parse::<u16>().ok()
            })
            .expect("the port of chromedriver");
        let profile = tempfile::tempdir().expect("a folder");
        let options = json!({"args": [
            "--headless=new",
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
        let client = client.unwrap_or_else(|error| {
            let _ = driver.kill();
            panic!("{error}")
        });
        let browser = Self {
            runtime,
            client: Some(client),
            driver,
            profile,
            _alone: alone,
        };
        browser.go(url);
        Some(browser)
    }

    fn client(&self) -> &Client {
        self.client.as_ref().expect("it is open")
    }

    /// Opens another page.
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

    /// The value of an expression.
    #[track_caller]
    pub fn value(&self, expression: &str) -> Value {
        self.script(&format!("return {expression}"))
    }

    /// The text of an expression.
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
        self.wait_within(expression, PATIENCE);
    }

    /// The same with another time-out.
    #[track_caller]
    pub fn wait_within(&self, expression: &str, patience: Duration) {
        let start = Instant::now();
        while self.value(&format!("!!({expression})")) != true {
            if start.elapsed() > patience {
                let message = self.text("document.getElementById('message').textContent");
                let state = self.text("document.getElementById('state').textContent");
                panic!(
                    "not true in time: {expression}; {state}; {message}; {:?}",
                    self.console()
                );
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Clicks an element as a user does, when it can be pressed. The page can replace it between the search and the click.
    #[track_caller]
    pub fn click(&self, selector: &str) {
        self.wait(&format!(
            "!(document.querySelector({selector:?})?.matches(':disabled') ?? true)"
        ));
        let start = Instant::now();
        loop {
            let clicked = self.runtime.block_on(async {
                let element = self.client().find(Locator::Css(selector)).await?;
                element.click().await
            });
            match clicked {
                Ok(()) => return,
                Err(error) if error.is_stale_element_reference() && start.elapsed() < PATIENCE => {}
                Err(error) => panic!("{selector}: {error}; {:?}", self.console()),
            }
        }
    }

    /// Clicks an element until an expression is true: what the click did is lost when the page replaces the element.
    #[track_caller]
    pub fn click_until(&self, selector: &str, expression: &str) {
        let start = Instant::now();
        while self.value(&format!("!!({expression})")) != true {
            assert!(start.elapsed() < PATIENCE, "not true in time: {expression}");
            self.click(selector);
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// Types a text into a field, instead of what it has.
    #[track_caller]
    pub fn write(&self, selector: &str, text: &str) {
        let written = self.runtime.block_on(async {
            let element = self.client().find(Locator::Css(selector)).await?;
            element.clear().await?;
            element.send_keys(text).await
        });
        written.unwrap_or_else(|error| panic!("{selector}: {error}"));
    }

    /// Presses keys at an element.
    #[track_caller]
    pub fn keys(&self, selector: &str, keys: &str) {
        let pressed = self.runtime.block_on(async {
            let element = self.client().find(Locator::Css(selector)).await?;
            element.send_keys(keys).await
        });
        pressed.unwrap_or_else(|error| panic!("{selector}: {error}"));
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
        let chosen = self.runtime.block_on(async {
            let element = self.client().find(Locator::Css(selector)).await?;
            element.select_by_value(value).await
        });
        chosen.unwrap_or_else(|error| panic!("{selector} {value}: {error}"));
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
            std::thread::sleep(Duration::from_millis(50));
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
        let _ = self.driver.kill();
        let _ = self.driver.wait();
    }
}
