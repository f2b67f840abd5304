//! `serve`: one local web page that finds, shows and sets sensors.
//!
//! ```text
//!  browser tab --- HTTP ---> guard --> api --- jobs ---> worker (adapter, session, samples)
//!              <-- events -- hub <----------- events ---'
//! ```
//!
//! - [`guard`]: who may ask: Host, Origin, token, content type; headers of every answer
//! - [`assets`]: the files of the page, which are parts of the program
//! - [`api`]: the requests of the page, as JSON
//! - [`job`]: the jobs of the worker
//! - [`worker`]: one thread that owns the adapter; it performs the operations in its session, and polls the angles between them
//! - [`lease`], [`tap`]: the adapter that commands and samples share, with counts of its frames
//! - [`transmission`]: the frames of the transmit list and of a log, which the adapter sends meanwhile
//! - [`live`]: the session that is polled; [`mod@line`]: a command as the line that the user can copy
//! - [`calibration`]: the six positions of a unit of this project, with a thread of their own
//! - [`sheets`]: the data sheets (EDS) of devices that are not in the catalogue
//! - [`events`]: server-sent events to the tabs
//!
//! An action of the page is an operation of the command line (`ops`): the same function runs, and the page shows the line.

pub mod api;
pub mod assets;
pub mod calibration;
pub mod events;
pub mod guard;
pub mod job;
pub mod lease;
pub mod line;
pub mod live;
pub mod sheets;
pub mod tap;
pub mod transmission;
pub mod worker;

use crate::cli::Options;
use crate::error::{Error, PageError};
use crate::note::Note;
use crate::output::Terminal;
use api::App;
use calibration::{Calibration, Unit};
use events::{Hub, Kind};
use job::{Connect, Job, Opener, Start, Task};
use serde_json::json;
use sheets::Sheets;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;
use tokio::net::TcpListener;
use worker::Worker;

/// The port of the demonstration.
pub const DEMO: &str = "demo:is2";

/// The pause between two checks for Ctrl-C.
const STOP: Duration = Duration::from_millis(20);

/// What the server offers, and where.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Where to listen. Port 0 takes a free port.
    pub listen: SocketAddr,
    /// Port, rate, address and product that the page offers first.
    pub options: Options,
    /// Connects to the port at once; without a port to a virtual sensor.
    pub demo: bool,
    /// The unit that the page calibrates.
    pub unit: Option<Unit>,
    /// The store file into which the page writes the identity of a unit.
    pub store: Option<PathBuf>,
}

/// A server that listens, but does not answer yet.
pub struct Server {
    listener: std::net::TcpListener,
    address: SocketAddr,
    token: String,
    settings: Settings,
    sheets: Arc<Sheets>,
    /// The measurement of the demonstration.
    _folder: Option<tempfile::TempDir>,
}

impl Server {
    /// Takes the address.
    ///
    /// # Errors
    /// The address is in use or does not exist, there are no random numbers, a store file has no product, or the data sheet is none.
    pub fn bind(mut settings: Settings) -> Result<Self, Error> {
        let sheets = Arc::new(Sheets::default());
        if let Some(path) = &settings.options.eds {
            let kept = sheets.read(path)?;
            settings.options.product = Some(kept.key.clone());
        }
        if let Some(unit) = &settings.unit {
            unit.check()?;
        }
        let wanted = settings.listen;
        let in_use =
            |error: std::io::Error| PageError::NoListen(wanted.to_string(), error.to_string());
        let listener = std::net::TcpListener::bind(wanted).map_err(in_use)?;
        listener.set_nonblocking(true).map_err(in_use)?;
        let address = listener.local_addr().map_err(in_use)?;
        if settings.demo && settings.options.port.is_none() {
            settings.options.port = Some(DEMO.to_owned());
        }
        let mut folder = None;
        let port = settings.options.port.as_deref().unwrap_or_default();
        if settings.demo && settings.unit.is_none() && port.starts_with("demo:") {
            let new = tempfile::tempdir().map_err(in_use)?;
            settings.unit = Some(Unit::demonstration(new.path()));
            folder = Some(new);
        }
        Ok(Self {
            listener,
            address,
            token: token()?,
            settings,
            sheets,
            _folder: folder,
        })
    }

    /// The address at which the server listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The secret that every request of the page contains.
    pub fn token(&self) -> &str {
        &self.token
    }

    /// The address of the page, with the secret behind `#`, which a browser does not send.
    pub fn url(&self) -> String {
        let mut shown = self.address;
        if shown.ip().is_unspecified() {
            shown.set_ip([127, 0, 0, 1].into());
        }
        format!("http://{shown}/#{}", self.token)
    }

    /// Answers until `stopped` returns true, with adapters of `opener`. Then the sensor is released and the adapter closed.
    ///
    /// # Errors
    /// The network of this computer failed.
    pub fn run(self, opener: Opener, stopped: &dyn Fn() -> bool) -> Result<(), Error> {
        let failed = |error: std::io::Error| PageError::NoServer(error.to_string());
        let (hub, stop) = (Arc::new(Hub::default()), Arc::new(AtomicBool::new(false)));
        let (jobs, receiver) = channel();
        let options = &self.settings.options;
        let connect = Connect::of(options);
        let start = Start {
            connect: connect.clone(),
            connects: self.settings.demo,
        };
        hub.publish(Kind::Sheets, &self.sheets.rows().into());
        if start.connects {
            let (reply, _) = tokio::sync::oneshot::channel();
            let _ = jobs.send(Job {
                task: Task::Connect(connect),
                reply,
            });
        }
        let calibration = Arc::new(Calibration::new(self.settings.unit.clone(), hub.clone()));
        let app = App {
            jobs,
            hub: hub.clone(),
            stop: stop.clone(),
            start,
            token: self.token.clone(),
            address: self.address,
            calibration: calibration.clone(),
            sheets: self.sheets.clone(),
            store: self.settings.store.clone(),
            config: options.config.clone(),
        };
        let (ends, config, sheets) = (stop.clone(), options.config.clone(), self.sheets.clone());
        let worker = thread::Builder::new().name("worker".to_owned());
        let worker = worker
            .spawn(move || {
                let mut worker = Worker::new(receiver, hub, opener, stop);
                worker.config = config;
                worker.sheets = sheets;
                worker.run();
            })
            .map_err(failed)?;
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(failed)?;
        let listener = self.listener;
        let result = runtime.block_on(async move {
            let listener = TcpListener::from_std(listener)?;
            // The router has the only sender of jobs, so the worker ends with it.
            let serve = tokio::spawn(async move { axum::serve(listener, api::router(app)).await });
            while !stopped() && !serve.is_finished() {
                tokio::time::sleep(STOP).await;
            }
            if serve.is_finished() {
                return serve.await.map_err(std::io::Error::other)?;
            }
            serve.abort();
            Ok(())
        });
        ends.store(true, Ordering::Relaxed);
        calibration.end();
        drop(runtime);
        let _ = worker.join();
        Ok(result.map_err(failed)?)
    }
}

/// Serves the page until Ctrl-C.
///
/// # Errors
/// The address is in use, or the network of this computer failed.
pub fn run(settings: Settings, opens: bool, terminal: &mut Terminal) -> Result<(), Error> {
    let server = Server::bind(settings)?;
    let url = server.url();
    terminal.line(&url)?;
    terminal.document(&json!({"url": url}))?;
    if !server.address().ip().is_loopback() {
        terminal.note(&Note::OtherComputers);
    }
    terminal.note(&Note::Secret);
    if opens && let Err(error) = open::that_detached(&url) {
        terminal.note(&Note::NoBrowser(error.to_string()));
    }
    server.run(Box::new(crate::port::connect), &*terminal.stopped)
}

/// A secret of 128 random bits, as 32 hexadecimal digits.
fn token() -> Result<String, Error> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(|error| PageError::NoRandom(error.to_string()))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
