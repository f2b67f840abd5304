//! The thread that owns the adapter: it does one job after the other, and polls the angles between them.

mod action;
mod commands;
mod others;
mod report;
mod stand_in;
mod transmit;
mod unsaved;
mod update;
mod which;

use super::events::{Hub, Kind};
use super::job::{Connect, Job, Opener, Part, Task};
use super::lease::Lease;
use super::line::{self, Words};
use super::live::Live;
use super::sheets::{Kept, Sheets};
use super::transmission::Transmission;
use crate::connect;
use crate::error::{Error, Silence};
use crate::identify::Identity;
use crate::last::Last;
use crate::link::Link;
use crate::ops::align::Measured;
use crate::output::Terminal;
use crate::scan::Memory;
use action::Answers;
use adapter::unread::Unread;
use adapter::{Adapter, Mode};
use plumbline::time::{after, millis};
use report::Reported;
use serde_json::{Map, Value, json};
use stand_in::Jobs;
use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use texts::{Kind as Refusal, Text};
use which::{Asked, on_request};

/// The pause between two events with the status and the frames.
const STATUS: Duration = Duration::from_millis(250);

/// The samples per second at first.
const SAMPLES: u32 = 50;

enum State {
    Closed,
    Listening(Link),
    /// It only sends the frames of the transmit list or of a log.
    Open(Link),
    Active(Box<Live>),
}

/// The thread that has the adapter and performs the jobs.
pub struct Worker {
    jobs: Rc<RefCell<Jobs>>,
    hub: Arc<Hub>,
    opener: Opener,
    stop: Arc<AtomicBool>,
    /// The folder with the names of sensors; None: the folder of the user.
    pub(super) config: Option<PathBuf>,
    /// The data sheets that the user has opened.
    pub(super) sheets: Arc<Sheets>,
    /// The data sheet of the sensor.
    sheet: Option<Arc<Kept>>,
    port: Option<(String, Lease)>,
    /// What is sent beside the requests.
    transmission: Rc<RefCell<Transmission>>,
    state: State,
    /// The other sensors in the chart.
    others: Vec<Live>,
    /// The options that select the bus and the sensor.
    selection: Words,
    /// The request whose question the user can answer.
    asked: Option<Asked>,
    /// What `align` has measured before its question.
    measured: Measured,
    /// How it was connected, with the answers of the user.
    given: Option<Connect>,
    /// The last number of a sensor.
    connection: u64,
    /// The sensor of the session before, with its number.
    last: Option<(Identity, u64)>,
    /// What the sensor has told, for the page.
    values: Map<String, Value>,
    /// What was written, but not stored, with its value.
    unsaved: Map<String, Value>,
    samples: u32,
    /// The line of the running command.
    busy: Option<String>,
    /// Why the connection ended, for the page.
    error: Option<Value>,
    status: Reported,
}

impl Worker {
    /// A worker for these jobs.
    pub fn new(jobs: Receiver<Job>, hub: Arc<Hub>, opener: Opener, stop: Arc<AtomicBool>) -> Self {
        Self {
            jobs: Rc::new(RefCell::new(Jobs::new(jobs))),
            hub,
            opener,
            stop,
            config: None,
            sheets: Arc::default(),
            sheet: None,
            port: None,
            transmission: Rc::default(),
            state: State::Closed,
            others: Vec::new(),
            selection: Words::new(),
            asked: None,
            measured: Measured::default(),
            given: None,
            connection: 0,
            last: None,
            values: Map::new(),
            unsaved: Map::new(),
            samples: SAMPLES,
            busy: None,
            error: None,
            status: Reported::new(),
        }
    }

    /// Works until nobody can send jobs.
    pub fn run(mut self) {
        self.report();
        loop {
            let job = match self.state {
                State::Closed => match self.jobs.borrow_mut().next(STATUS * 4) {
                    Ok(job) => Some(job),
                    Err(RecvTimeoutError::Timeout) => None,
                    Err(RecvTimeoutError::Disconnected) => break,
                },
                _ => match self.jobs.borrow_mut().try_next() {
                    Ok(job) => Some(job),
                    Err(TryRecvError::Empty) => None,
                    Err(TryRecvError::Disconnected) => break,
                },
            };
            if let Some(job) = job {
                self.stop.store(false, Ordering::Relaxed);
                let result = self.work(job.task);
                let result = result.map_err(|failure| failure.with_unread(&self.unread()));
                self.stop.store(false, Ordering::Relaxed);
                // The page knows that the buttons can be pressed again before it has the answer.
                self.report();
                let _ = job.reply.send(result);
            } else {
                // Without a job there is nothing to stop.
                self.stop.store(false, Ordering::Relaxed);
                let turned = self.turn();
                self.survive(turned);
            }
            if self.status.at.elapsed() >= STATUS {
                self.report();
            }
        }
        self.stop.store(false, Ordering::Relaxed);
        let _ = self.close();
    }

    fn turn(&mut self) -> Result<(), Error> {
        if self.port.is_none() {
            return Ok(());
        }
        let due = self.others_due();
        match &mut self.state {
            State::Closed => Ok(()),
            State::Listening(link) => heard(link),
            State::Open(link) => {
                let result = heard(link);
                self.go_on_sending(result)
            }
            State::Active(live) => {
                live.turn(&self.hub, due)?;
                let was_silent = std::mem::replace(&mut self.status.was_silent, live.is_silent());
                if was_silent && !live.is_silent() {
                    // It has been restarted: its values can differ, or it is another one.
                    self.returned()?;
                }
                self.turn_others()
            }
        }
    }

    /// An adapter that has failed ends the connection, with its reason.
    fn survive(&mut self, result: Result<(), Error>) {
        if let Err(failure) = result
            && !failure.is_stopped()
        {
            self.error = Some(failure.texts());
            self.port = None;
            self.show_stand_in();
            self.forget();
            self.report();
        }
    }

    fn forget(&mut self) {
        self.state = State::Closed;
        // An adapter that has failed is dropped without its end.
        self.transmission.borrow_mut().stop();
        self.others.clear();
        self.show_others();
        self.selection.clear();
        self.measured = Measured::default();
        self.sheet = None;
        self.hub.publish(Kind::Device, &Value::Null);
        self.hub.publish(Kind::Values, &Value::Null);
        self.hub.publish(Kind::Condition, &Value::Null);
    }

    /// Ends the session and closes the adapter, which is kept for the next connection.
    fn close(&mut self) -> Result<(), Error> {
        for mut other in std::mem::take(&mut self.others) {
            // The failure of the session itself is told.
            let _ = other.release();
        }
        let result = match std::mem::replace(&mut self.state, State::Closed) {
            State::Active(mut live) => live.release(),
            _ => Ok(()),
        };
        if let Some((_, lease)) = &self.port {
            lease.end();
        }
        self.forget();
        result
    }

    /// The adapter of a port. The adapter of another port is dropped first.
    fn lease(&mut self, port: &str) -> Result<Lease, Error> {
        if let Some((own, lease)) = &self.port
            && own == port
        {
            return Ok(lease.clone());
        }
        self.port = None;
        self.show_stand_in();
        let lease = Lease::new(
            (self.opener)(port)?,
            self.transmission.clone(),
            self.moves(),
        );
        self.port = Some((port.to_owned(), lease.clone()));
        (self.status.tells_errors, self.status.errors_at) = (true, None);
        self.show_stand_in();
        Ok(lease)
    }

    fn work(&mut self, task: Task) -> Result<Value, Error> {
        match task {
            Task::Connect(connect) => self.connect(&connect),
            Task::Disconnect => {
                self.error = None;
                self.close()?;
                Ok(json!({}))
            }
            Task::Scan(wanted) => self.scan(&wanted),
            Task::Run(request) => self.perform(&request),
            Task::Update(wanted) => self.update(&wanted),
            Task::Align(wanted) => self.align(&wanted),
            Task::Chart(wanted) => self.chart(&wanted),
            Task::Transmit(wanted) => self.transmit(wanted),
            Task::StandIn(request) => self.stand_in(request),
            Task::Backup => self.backup(),
            Task::Restore {
                text,
                name,
                only,
                label,
            } => self.restore(&text, &name, &only, label),
            Task::For { sensor, task } => {
                self.check(sensor)?;
                self.work(*task)
            }
            Task::Samples(samples) => {
                self.samples = samples;
                if let State::Active(live) = &mut self.state {
                    live.set_rate(samples);
                }
                for other in &mut self.others {
                    other.set_rate(samples);
                }
                Ok(json!({}))
            }
        }
    }

    /// What the adapter says and the tool cannot read.
    fn unread(&self) -> Unread {
        let unread = self.port.as_ref().and_then(|(_, lease)| lease.unread());
        unread.unwrap_or_default()
    }

    fn connect(&mut self, wanted: &Connect) -> Result<Value, Error> {
        let mut shown = wanted.words(&self.sheets)?;
        let command: &[&str] = match wanted.mode {
            Part::Listen => &["log", "-"],
            Part::Frames => &["send", "FRAME"],
            Part::Active => &["watch"],
        };
        shown.extend(command.iter().map(|word| (*word).to_owned()));
        self.error = None;
        self.close()?;
        let answers = Answers::new(&wanted.yes, &wanted.names);
        self.action(&shown, &answers, |worker, terminal| {
            let asked = worker.asked(&shown, &wanted.yes);
            let memory = asked.memory.clone();
            let connected = worker.connected(wanted, &answers, memory, terminal);
            let result = connected.map_err(on_request);
            if let Err(failure) = &result {
                // An adapter that has failed can be plugged in again.
                if failure.kind() == Refusal::Bus {
                    worker.port = None;
                    worker.show_stand_in();
                }
                let _ = worker.close();
                if failure.questions().is_empty() {
                    worker.error = Some(failure.texts());
                } else {
                    worker.wait(asked, failure.questions().to_vec());
                }
            }
            result
        })
    }

    fn connected(
        &mut self,
        wanted: &Connect,
        answers: &Answers,
        memory: Memory,
        terminal: &mut Terminal,
    ) -> Result<Value, Error> {
        let (bus, sheet) = wanted.wanted(&self.sheets, self.config.as_deref(), memory)?;
        let lease = self.lease(&wanted.port)?;
        lease.with_tap(|tap| tap.clear());
        self.hub.publish(Kind::Frames, &json!([]));
        self.status.frames = 0;
        if wanted.mode != Part::Active {
            let mut link = Link::new(Box::new(lease.clone()), &terminal.stopped);
            let rate = match wanted.rate {
                None if lease.capabilities().needs_rate => {
                    let heard = connect::traffic(&mut link, terminal)?;
                    heard.map(|heard| heard.rate).ok_or(Silence::PageTraffic)?
                }
                rate => rate,
            };
            let (mode, state): (_, fn(Link) -> State) = match wanted.mode {
                Part::Frames => (Mode::Active, State::Open),
                _ => (Mode::Listen, State::Listening),
            };
            link.open(rate, mode)?;
            lease.keep();
            self.selection = line::bus(&wanted.port, rate);
            self.state = state(link);
            return Ok(json!({}));
        }
        // The page asks the user, and tries again.
        let opened = connect::session(Box::new(lease.clone()), &bus, terminal);
        let (session, found) = answers.instead(opened)?;
        self.given = Some(wanted.clone());
        Last::open(self.config.as_deref()).keep(&wanted.port, session.link.rate(), session.target);
        lease.keep();
        let rate = session.link.rate();
        let product = session.sheet.product.name;
        let eds = sheet.as_ref().map(|kept| kept.option());
        self.selection = line::selecting(&wanted.port, rate, &found, product, eds);
        self.sheet = sheet;
        let number = self.number(&found);
        let live = Live::new(session, (found, number), lease, self.samples)?;
        let device = live.device(&self.sheets);
        self.state = State::Active(Box::new(live));
        self.hub.publish(Kind::Device, &device);
        self.refresh()?;
        Ok(device)
    }
}

/// Takes the frames of a short time.
fn heard(link: &mut Link) -> Result<(), Error> {
    let until = after(link.now(), millis(20));
    while link.receive(until)?.is_some() {}
    Ok(())
}

/// The time in ms since 1970.
pub(super) fn now() -> u64 {
    let passed = SystemTime::now().duration_since(UNIX_EPOCH);
    passed.unwrap_or_default().as_millis() as u64
}
