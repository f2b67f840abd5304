//! `doctor`: what is wrong with a bus, and what to do next. It only listens, unless it may ask.

mod finding;
pub(crate) mod traffic;
mod usage;

use crate::connect::{self, RATES};
use crate::counted::{self, Errors};
use crate::error::Error;
use crate::identify;
use crate::link::{Link, stopped};
use crate::master::{Target, factory_targets};
use crate::note::Step;
use crate::number::shown;
use crate::output::{Progress, Terminal};
use crate::scan::listen::{self, Frames};
use crate::scan::passive::{self, Sighting};
use crate::scan::{self, kbits};
use adapter::Adapter;
use finding::Finding;
use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, Instant, after, millis};
use serde::Serialize;
use serde_json::Value;
use traffic::Traffic;
use usage::Usage;

/// The load from which on frames of low priority wait long, in percent.
const BUSY: f64 = 70.0;

/// The errors from which on a bus is disturbed: one in so many frames.
const RARE: u64 = 100;

/// The frames that are kept to recognise nodes.
const KEPT: usize = 20_000;

/// How often the progress is shown.
const SHOWN: Duration = millis(1000);

/// How long it listens if the user does not say it.
pub const USUAL: Duration = millis(5000);

/// The options.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    /// The bit rate that the bus must have; None: the one that is heard.
    pub rate: Option<BitRate>,
    /// How long it listens.
    pub time: Duration,
    /// Also asks the sensors, and on a bus without traffic at the addresses as delivered.
    pub active: bool,
    /// The address of a sensor that is then asked too.
    pub target: Option<Target>,
}

/// What was seen.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The bit rate in kbit/s; None: unknown.
    pub rate: Option<Value>,
    /// How long it has listened, in s.
    pub seconds: f64,
    /// The valid frames.
    pub frames: u64,
    /// The bus load in percent; None: the bit rate is unknown.
    pub load: Option<f64>,
    /// The errors; None: the adapter does not tell them.
    pub errors: Option<u64>,
    /// The identifiers.
    pub identifiers: Vec<Row>,
    /// The sensors that have answered.
    pub sensors: Vec<String>,
    /// The diagnostic data of those with the firmware of this project.
    pub usage: Vec<Usage>,
    /// What is wrong.
    pub findings: Vec<Finding>,
}

/// An identifier.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// In hexadecimal.
    pub id: String,
    /// Its frames.
    pub frames: u64,
    /// The errors before its frames; None: the adapter does not tell when they happen.
    pub errors: Option<u64>,
}

impl Report {
    /// For people.
    pub fn lines(&self) -> Vec<String> {
        let rate = self.rate.as_ref();
        let rate = rate.map_or("unknown bit rate".to_owned(), |rate| {
            format!("{rate} kbit/s")
        });
        let load = self
            .load
            .map_or("unknown".to_owned(), |load| format!("{load} %"));
        let errors = self
            .errors
            .map_or("not reported by the adapter".to_owned(), |own| {
                own.to_string()
            });
        let mut lines = vec![format!(
            "{rate}, {} s: {}, bus load {load}, errors {errors}",
            self.seconds,
            counted::Frames(self.frames)
        )];
        for Row { id, frames, errors } in &self.identifiers {
            let errors = errors.map_or(String::new(), |errors| format!(", {}", Errors(errors)));
            lines.push(format!("  {id}: {}{errors}", counted::Frames(*frames)));
        }
        for sensor in &self.sensors {
            lines.push(format!("  answers: {sensor}"));
            let told = self.usage.iter().filter(|usage| usage.sensor == *sensor);
            let told = told.flat_map(Usage::lines);
            lines.extend(told.map(|line| format!("    {line}")));
        }
        lines.extend(self.findings.iter().map(Finding::to_string));
        if self.findings.is_empty() {
            lines.push("no fault was found".to_owned());
        }
        lines
    }
}

/// Listens to a bus, and says what is wrong with it.
///
/// # Errors
/// The adapter fails, a question was answered with no, or the user has pressed Ctrl-C.
pub(crate) fn doctor(
    adapter: Box<dyn Adapter>,
    request: Request,
    terminal: &mut Terminal,
) -> Result<Report, Error> {
    let mut link = Link::new(adapter, &terminal.stopped);
    let examined = examine(&mut link, request, terminal);
    terminal.hide();
    link.close();
    scan::report(&link, terminal);
    examined
}

fn examine(link: &mut Link, request: Request, terminal: &mut Terminal) -> Result<Report, Error> {
    let mut findings = Vec::new();
    let sets_rate = link.adapter().capabilities().sets_rate;
    let mut rate = request.rate;
    let mut seen = match (rate, sets_rate) {
        (None, true) => None,
        _ => Some(Seen::listen(link, rate, request.time, terminal)?),
    };
    if seen.as_ref().is_none_or(|seen| seen.traffic.frames == 0) && sets_rate {
        let heard = connect::traffic(link, terminal)?;
        if let Some(heard) = heard {
            if let (Some(given), Some(own)) = (rate, heard.rate) {
                findings.push(Finding::WrongRate(given.name(), own.name()));
            }
            rate = heard.rate;
            seen = Some(Seen::listen(link, rate, request.time, terminal)?);
        }
    }
    let seen = match seen {
        Some(seen) => seen,
        // Errors are counted at any bit rate.
        None => Seen::listen(link, Some(RATES[0]), request.time, terminal)?.unsure(),
    };
    findings.extend(seen.findings());
    let mut answers = Answers::default();
    if request.active {
        active(
            link,
            (rate, request.target),
            &seen,
            &mut answers,
            &mut findings,
        )?;
    }
    Ok(seen.report(answers, findings))
}

/// What sensors have answered.
#[derive(Default)]
struct Answers {
    sensors: Vec<String>,
    usage: Vec<Usage>,
}

/// What was seen at a bit rate.
struct Seen {
    rate: Option<BitRate>,
    passed: Duration,
    traffic: Traffic,
    frames: Vec<(Instant, Frame)>,
    errors: Option<u64>,
    overruns: Option<u64>,
    /// The adapter tells errors when they happen.
    tells: bool,
}

impl Seen {
    fn listen(
        link: &mut Link,
        rate: Option<BitRate>,
        time: Duration,
        terminal: &mut Terminal,
    ) -> Result<Self, Error> {
        listen::open(link, rate, terminal)?;
        let rate = link.rate();
        let tells = link.adapter().capabilities().reports_errors;
        let (start, mut counted) = (link.now(), 0);
        let until = after(start, time);
        let (mut traffic, mut frames) = (Traffic::default(), Vec::new());
        let mut next = start;
        loop {
            let now = link.now();
            if link.is_stopped() {
                return Err(stopped());
            }
            if now >= next {
                next = after(next, SHOWN);
                let done = now.ticks().saturating_sub(start.ticks()) / SHOWN.ticks();
                let total = time.ticks().div_ceil(SHOWN.ticks()) as usize;
                let step = Step::Examines(counted::Frames(traffic.frames));
                let progress = Progress {
                    done: done as usize,
                    total,
                    step: &step,
                };
                terminal.progress(progress, None);
            }
            let Some((at, frame)) = link.receive(next.min(until))? else {
                if link.now() >= until {
                    break;
                }
                continue;
            };
            if at >= until {
                break;
            }
            let errors = tells.then(|| link.adapter().errors()).flatten();
            let errors = errors.unwrap_or(0);
            traffic.take(at, &frame, errors.saturating_sub(counted), rate);
            counted = errors;
            if frames.len() < KEPT {
                frames.push((at, frame));
            }
        }
        let passed = link.now().ticks().min(until.ticks()) - start.ticks();
        let (errors, overruns) = (link.adapter().errors(), link.adapter().overruns());
        link.close();
        Ok(Self {
            rate,
            passed: Duration::from_ticks(passed),
            traffic,
            frames,
            errors,
            overruns,
            tells,
        })
    }

    /// The same at a bit rate that was a guess: only a frame shows that it is right.
    fn unsure(self) -> Self {
        let rate = self.rate.filter(|_| self.traffic.frames > 0);
        Self { rate, ..self }
    }

    fn load(&self) -> Option<f64> {
        self.traffic.load(self.rate, self.passed.ticks())
    }

    fn findings(&self) -> Vec<Finding> {
        let (frames, errors) = (self.traffic.frames, self.errors.unwrap_or(0));
        let mut findings = Vec::new();
        findings.extend(
            self.overruns
                .filter(|count| *count > 0)
                .map(|count| Finding::Overruns(counted::Frames(count))),
        );
        match (frames, errors) {
            (0, 0) => findings.push(Finding::Silent),
            (0, _) => findings.push(Finding::OnlyErrors(Errors(errors))),
            _ => {}
        }
        if frames == 0 {
            return findings;
        }
        // Each repetition is an error too, and the load is that of one sender.
        if self.traffic.is_unacknowledged() {
            let id = self.traffic.identifiers.first().map(|own| shown(own.id));
            findings.push(Finding::Unacknowledged(id.unwrap_or_default()));
            return findings;
        }
        if errors * RARE > frames {
            findings.push(match self.traffic.disturbed().filter(|_| self.tells) {
                Some(own) => Finding::OneDisturbed(shown(own.id), Errors(own.errors)),
                None => Finding::Disturbed(Errors(errors), counted::Frames(frames)),
            });
        }
        let doubled = self.traffic.doubled();
        findings.extend(doubled.map(|id| Finding::Doubled(shown(id))));
        findings.extend(same_addresses(&self.frames));
        findings.extend(self.load().filter(|load| *load >= BUSY).map(Finding::Busy));
        findings
    }

    fn report(self, answers: Answers, findings: Vec<Finding>) -> Report {
        let rows = self.traffic.identifiers.iter().map(|own| Row {
            id: shown(own.id),
            frames: own.frames,
            errors: self.tells.then_some(own.errors),
        });
        let load = self.load();
        Report {
            rate: self.rate.map(kbits),
            seconds: self.passed.ticks() as f64 / 1e6,
            frames: self.traffic.frames,
            load,
            errors: self.errors,
            identifiers: rows.collect(),
            sensors: answers.sensors,
            usage: answers.usage,
            findings,
        }
    }
}

/// Nodes with one address that have told different things.
fn same_addresses(frames: &Frames) -> Vec<Finding> {
    let sightings = passive::sightings(frames);
    let told: Vec<_> = sightings.iter().filter_map(Sighting::told).collect();
    let mut findings: Vec<Finding> = Vec::new();
    for (place, (address, text)) in told.iter().enumerate() {
        let mut earlier = told[..place].iter();
        let is_other = earlier.any(|(own, other)| own == address && other != text);
        let finding = Finding::SameAddress(address.clone());
        if is_other && !findings.contains(&finding) {
            findings.push(finding);
        }
    }
    findings
}

/// Asks the sensors that were heard, and the one of the user; on a bus without traffic, those at the addresses as delivered.
fn active(
    link: &mut Link,
    (rate, given): (Option<BitRate>, Option<Target>),
    seen: &Seen,
    answers: &mut Answers,
    findings: &mut Vec<Finding>,
) -> Result<(), Error> {
    let is_silent = seen.traffic.frames == 0;
    let sightings = passive::sightings(&seen.frames);
    let heard = sightings.iter().filter(|sighting| sighting.is_sure);
    let mut targets = match is_silent {
        true => factory_targets(),
        false => heard.filter_map(|sighting| sighting.target).collect(),
    };
    targets.extend(given.filter(|given| !targets.contains(given)));
    let rates: Vec<Option<BitRate>> = match (rate, link.adapter().capabilities().sets_rate) {
        (None, true) => RATES.map(Some).to_vec(),
        _ => vec![rate],
    };
    for rate in &rates {
        if !link.try_rate(*rate, &rates)? {
            continue;
        }
        let mut told = Vec::new();
        for target in &targets {
            // A sensor that detects the bit rate needs a frame before it answers.
            let mut answer = identify::ask_all(link, *target, identify::QUICK)?;
            if answer.is_none() {
                answer = identify::ask_all(link, *target, identify::PATIENT)?;
            }
            if let Some(found) = answer {
                answers
                    .usage
                    .extend(Usage::ask(link, &found, found.line(*rate))?);
                told.push(found);
            }
        }
        let errors = link.adapter().errors().unwrap_or(0);
        link.close();
        for found in &told {
            answers.sensors.push(found.line(*rate));
            if !found.twins.is_empty() {
                findings.push(Finding::Twins(found.twins().into()));
            }
        }
        if !told.is_empty() {
            findings.retain(|finding| *finding != Finding::Silent);
            return Ok(());
        }
        if is_silent && rates.len() == 1 && errors > 0 {
            findings.retain(|finding| *finding != Finding::Silent);
            findings.push(Finding::NotTaken(Errors(errors)));
        }
    }
    Ok(())
}
