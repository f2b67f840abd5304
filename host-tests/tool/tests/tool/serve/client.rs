//! A client of HTTP that sends any bytes, and a server for it.

use super::fast_bus;
use plumbline_tool::cli::Options;
use plumbline_tool::serve::calibration::Unit;
use plumbline_tool::serve::job::Opener;
use plumbline_tool::serve::{Server, Settings};
use serde_json::Value;
use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// The longest wait for an event or an answer, on a busy machine: an update of a simulated microcontroller takes 6 s on an idle one.
pub const PATIENCE: Duration = Duration::from_secs(300);

/// Waits until `is` returns true.
#[track_caller]
pub fn until(what: &str, mut is: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is() {
        assert!(start.elapsed() < PATIENCE, "no {what} in {PATIENCE:?}");
        thread::sleep(Duration::from_millis(1));
    }
}

/// A server that runs until it is dropped.
pub struct Running {
    pub address: SocketAddr,
    pub token: String,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    /// The folder with the names of sensors.
    pub config: tempfile::TempDir,
    /// The number of the sensor that the page shows.
    sensor: Mutex<Option<u64>>,
}

/// The answer to a request.
#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: String,
}

impl Answer {
    #[track_caller]
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap_or_else(|error| panic!("{error}: {self:?}"))
    }

    /// The code of the error.
    #[track_caller]
    pub fn code(&self) -> String {
        let document = self.json();
        let message = document["error"]["message"].as_str().unwrap_or_default();
        assert!(
            message.len() > 20,
            "the message names the next step: {self:?}"
        );
        document["error"]["code"]
            .as_str()
            .unwrap_or_default()
            .to_owned()
    }
}

impl Running {
    /// A server with virtual sensors.
    pub fn new() -> Self {
        Self::with(Box::new(fast_bus::connect))
    }

    /// A server with other adapters.
    pub fn with(opener: Opener) -> Self {
        Self::of(opener, None, None)
    }

    /// A server that calibrates a unit.
    pub fn calibrating(unit: Unit) -> Self {
        Self::of(Box::new(fast_bus::connect), Some(unit), None)
    }

    /// A server with the data sheet of the command line.
    pub fn with_data_sheet(eds: PathBuf) -> Self {
        Self::of(Box::new(fast_bus::connect), None, Some(eds))
    }

    /// A server of the demonstration, which connects at once.
    pub fn demonstration() -> Self {
        Self::start(Box::new(fast_bus::connect), None, None, None, true)
    }

    /// A server with the store file of the command line.
    pub fn with_store(opener: Opener, store: Option<PathBuf>) -> Self {
        Self::start(opener, None, None, store, false)
    }

    fn of(opener: Opener, unit: Option<Unit>, eds: Option<PathBuf>) -> Self {
        Self::start(opener, unit, eds, None, false)
    }

    fn start(
        opener: Opener,
        unit: Option<Unit>,
        eds: Option<PathBuf>,
        store: Option<PathBuf>,
        demo: bool,
    ) -> Self {
        let config = tempfile::tempdir().expect("a folder");
        let settings = Settings {
            listen: "127.0.0.1:0".parse().expect("an address"),
            options: Options {
                config: Some(config.path().to_owned()),
                eds,
                ..Options::default()
            },
            demo,
            unit,
            store,
        };
        let server = Server::bind(settings).expect("a free port");
        let (address, token) = (server.address(), server.token().to_owned());
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        let thread = thread::spawn(move || {
            let run = server.run(opener, &|| stopped.load(Ordering::Relaxed));
            run.expect("the server runs");
        });
        Self {
            address,
            token,
            stop,
            thread: Some(thread),
            config,
            sensor: Mutex::default(),
        }
    }

    /// A server that is connected to a virtual sensor.
    pub fn connected(product: &str) -> Self {
        let running = Self::new();
        let answer = running.post(
            "/api/connect",
            &format!(r#"{{"port":"demo:{product}","mode":"active"}}"#),
        );
        assert_eq!(answer.status, 200, "{answer:?}");
        running
    }

    /// The address of the page.
    pub fn url(&self) -> String {
        format!("http://{}/#{}", self.address, self.token)
    }

    /// Sends these bytes and reads the answer until the server closes the connection.
    pub fn send(&self, request: &str) -> Answer {
        let mut stream = TcpStream::connect(self.address).expect("a connection");
        stream.set_read_timeout(Some(PATIENCE)).expect("a time");
        stream.write_all(request.as_bytes()).expect("it is sent");
        let mut bytes = Vec::new();
        let mut part = [0; 4096];
        let mut text = String::new();
        // A refused request can leave the connection open until its body has come.
        while !is_whole(&text) {
            match stream.read(&mut part) {
                Ok(count @ 1..) => bytes.extend_from_slice(&part[..count]),
                // The computer has stopped this program for some time.
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                _ => break,
            }
            text = String::from_utf8_lossy(&bytes).into_owned();
        }
        let (head, body) = text.split_once("\r\n\r\n").unwrap_or((&text, ""));
        let status = head
            .split(' ')
            .nth(1)
            .and_then(|status| status.parse().ok());
        Answer {
            status: status.unwrap_or(0),
            head: head.to_lowercase(),
            body: body.to_owned(),
        }
    }

    /// A request with these headers besides Host and Connection.
    pub fn request(&self, line: &str, headers: &[(&str, &str)], body: &str) -> Answer {
        let mut request = format!("{line} HTTP/1.1\r\n");
        if !headers.iter().any(|(name, _)| *name == "Host") {
            request.push_str(&format!("Host: {}\r\n", self.address));
        }
        for (name, value) in headers {
            request.push_str(&format!("{name}: {value}\r\n"));
        }
        request.push_str(&format!(
            "Connection: close\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        ));
        self.send(&request)
    }

    /// A GET of the page.
    pub fn get(&self, path: &str) -> Answer {
        let token = self.token.clone();
        self.request(&format!("GET {path}"), &[("X-Plumbline-Token", &token)], "")
    }

    /// A POST of the page, for the sensor that it has connected to.
    pub fn post(&self, path: &str, body: &str) -> Answer {
        let sensor = *self.sensor.lock().expect("a number");
        let answer = self.post_for(sensor, path, body);
        let document: Option<Value> = serde_json::from_str(&answer.body).ok();
        if let Some(number) = document.and_then(|document| document["connection"].as_u64()) {
            *self.sensor.lock().expect("a number") = Some(number);
        }
        answer
    }

    /// A POST of a page that shows the sensor with this number.
    pub fn post_for(&self, sensor: Option<u64>, path: &str, body: &str) -> Answer {
        let origin = format!("http://{}", self.address);
        let mut headers = vec![
            ("X-Plumbline-Token", self.token.as_str()),
            ("Content-Type", "application/json"),
            ("Origin", origin.as_str()),
        ];
        let sensor = sensor.map(|number| number.to_string());
        headers.extend(
            sensor
                .as_deref()
                .map(|number| ("X-Plumbline-Sensor", number)),
        );
        self.request(&format!("POST {path}"), &headers, body)
    }

    /// Opens the stream of events, as a tab does.
    pub fn tab(&self) -> Tab {
        self.tab_with("")
    }

    /// The same for a tab with a name.
    pub fn named_tab(&self, name: &str) -> Tab {
        self.tab_with(&format!("X-Plumbline-Tab: {name}\r\n"))
    }

    fn tab_with(&self, headers: &str) -> Tab {
        let mut stream = TcpStream::connect(self.address).expect("a connection");
        stream.set_read_timeout(Some(PATIENCE)).expect("a time");
        let request = format!(
            "GET /api/events HTTP/1.1\r\nHost: {}\r\nX-Plumbline-Token: {}\r\n{headers}\r\n",
            self.address, self.token
        );
        stream.write_all(request.as_bytes()).expect("it is sent");
        let mut reader = BufReader::new(stream);
        let mut status = String::new();
        reader.read_line(&mut status).expect("an answer");
        let status = status
            .split(' ')
            .nth(1)
            .and_then(|status| status.parse().ok());
        Tab {
            status: status.unwrap_or(0),
            reader,
            kind: String::new(),
        }
    }
}

/// Whether an answer has all bytes of its Content-Length.
fn is_whole(text: &str) -> bool {
    let Some((head, body)) = text.split_once("\r\n\r\n") else {
        return false;
    };
    let head = head.to_lowercase();
    let mut lines = head.lines();
    let length = lines.find_map(|line| line.strip_prefix("content-length: "));
    length.is_some_and(|length| length.parse() == Ok(body.len()))
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let thread = self.thread.take().expect("it runs");
        let ended = thread.join();
        assert!(ended.is_ok() || thread::panicking(), "the server ends");
    }
}

/// The stream of events of a tab.
pub struct Tab {
    pub status: u16,
    reader: BufReader<TcpStream>,
    kind: String,
}

impl Tab {
    /// The next event: its kind and its data.
    #[track_caller]
    pub fn next(&mut self) -> (String, Value) {
        loop {
            let mut line = String::new();
            let read = self.reader.read_line(&mut line).expect("an event");
            assert!(read > 0, "the stream has ended");
            if let Some(kind) = line.strip_prefix("event: ") {
                self.kind = kind.trim().to_owned();
            }
            if let Some(data) = line.strip_prefix("data: ") {
                return (self.kind.clone(), serde_json::from_str(data).expect("JSON"));
            }
        }
    }

    /// The next event of a kind that `is` takes.
    #[track_caller]
    pub fn wait(&mut self, kind: &str, is: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            let (own, data) = self.next();
            if own == kind && is(&data) {
                return data;
            }
        }
        panic!("no {kind} in {PATIENCE:?}");
    }
}
