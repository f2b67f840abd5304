//! The requests that use the bus: jobs for the worker.

use super::{Answer, App, on_sensor, parse, work};
use crate::failure::Failure;
use crate::serve::job::Task;
use crate::serve::line::{Words, positional};
use axum::body::Bytes;
use axum::extract::State;
use axum::http::HeaderMap;
use serde::Deserialize;
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// The maximum number of samples per second.
const MOST_SAMPLES: u32 = 1000;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Nothing {}

pub(super) async fn connect(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    work(&app, Task::Connect(parse(&body)?)).await
}

pub(super) async fn disconnect(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    let Nothing {} = parse(&body)?;
    work(&app, Task::Disconnect).await
}

pub(super) async fn stop(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    let Nothing {} = parse(&body)?;
    app.stop.store(true, Ordering::Relaxed);
    Ok(axum::Json(json!({})))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Scan {
    port: String,
    #[serde(default)]
    rate: Option<f64>,
    #[serde(default)]
    active: bool,
    #[serde(default)]
    search: bool,
    /// The questions that were answered with yes.
    #[serde(default)]
    yes: Vec<String>,
}

pub(super) async fn scan(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    let scan: Scan = parse(&body)?;
    let mut words = vec!["--port".to_owned(), scan.port.clone()];
    if let Some(rate) = scan.rate {
        words.extend(["--rate".to_owned(), rate.to_string()]);
    }
    words.push("scan".to_owned());
    for (name, is_wanted) in [("--active", scan.active), ("--search", scan.search)] {
        if is_wanted {
            words.push(name.to_owned());
        }
    }
    let task = Task::Scan {
        port: scan.port,
        words,
        yes: scan.yes,
        asks: scan.active || scan.search,
    };
    work(&app, task).await
}

/// A command on the sensor.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
enum Run {
    Get(Get),
    Set(Set),
    Save,
    LoadFactory,
    Zero(Zero),
    Teach(Teach),
    Restart,
    NodeId(Address),
    Mac(Address),
    Address(Address),
    Rate(Rate),
    Label(Label),
    Identity,
    Raw(Raw),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Get {
    #[serde(default)]
    names: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Set {
    assignments: Vec<String>,
    #[serde(default)]
    save: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Zero {
    #[serde(default)]
    axis: Option<String>,
    #[serde(default)]
    save: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Teach {
    #[serde(default)]
    save: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Address {
    new: u8,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Rate {
    /// In kbit/s, or `auto`.
    new: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Label {
    /// None takes the name away.
    #[serde(default)]
    name: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    request: String,
}

impl Run {
    /// The words of the command line.
    fn words(&self) -> Words {
        let (name, save, values) = match self {
            Self::Get(Get { names }) => ("get", false, names.clone()),
            Self::Set(Set { assignments, save }) => ("set", *save, assignments.clone()),
            Self::Save => ("save", false, Vec::new()),
            Self::LoadFactory => ("load-factory", false, Vec::new()),
            Self::Zero(Zero { axis, save }) => ("zero", *save, axis.iter().cloned().collect()),
            Self::Teach(Teach { save }) => ("teach", *save, Vec::new()),
            Self::Restart => ("restart", false, Vec::new()),
            Self::NodeId(Address { new }) => ("node-id", false, vec![new.to_string()]),
            Self::Mac(Address { new }) => ("mac", false, vec![new.to_string()]),
            Self::Address(Address { new }) => ("address", false, vec![new.to_string()]),
            Self::Rate(Rate { new }) => ("rate", false, vec![new.clone()]),
            Self::Label(Label { name: None }) => {
                return ["label", "--remove"].map(str::to_owned).to_vec();
            }
            Self::Label(Label { name }) => ("label", false, name.iter().cloned().collect()),
            Self::Identity => ("identity", false, Vec::new()),
            Self::Raw(Raw { request }) => ("raw", false, vec![request.clone()]),
        };
        let mut words = vec![name.to_owned()];
        if save {
            words.push("--save".to_owned());
        }
        positional(&mut words, &values);
        words
    }
}

/// Runs a command on the sensor.
pub(super) async fn run(State(app): State<Arc<App>>, headers: HeaderMap, body: Bytes) -> Answer {
    let run: Run = parse(&body)?;
    on_sensor(&app, &headers, Task::Run(run.words())).await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct Samples {
    per_second: u32,
}

/// Sets the samples per second.
pub(super) async fn samples(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    let Samples { per_second } = parse(&body)?;
    if per_second > MOST_SAMPLES {
        let message = format!("at most {MOST_SAMPLES} samples per second are possible");
        return Err(Failure::usage("out-of-range", message).into());
    }
    work(&app, Task::Samples(per_second)).await
}

pub(super) async fn backup(State(app): State<Arc<App>>, headers: HeaderMap, body: Bytes) -> Answer {
    let Nothing {} = parse(&body)?;
    on_sensor(&app, &headers, Task::Backup).await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Restore {
    text: String,
    #[serde(default)]
    name: Option<String>,
    #[serde(default)]
    only: Vec<String>,
    /// Also the name of the sensor.
    #[serde(default)]
    label: bool,
}

/// Writes the settings of a file that differ.
pub(super) async fn restore(
    State(app): State<Arc<App>>,
    headers: HeaderMap,
    body: Bytes,
) -> Answer {
    let restore: Restore = parse(&body)?;
    let task = Task::Restore {
        text: restore.text,
        name: restore.name.unwrap_or_else(|| "FILE.toml".to_owned()),
        only: restore.only,
        label: restore.label,
    };
    let answer: Value = on_sensor(&app, &headers, task).await?.0;
    Ok(axum::Json(json!({"differences": answer})))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::Cli;
    use clap::Parser;

    fn words(body: &str) -> String {
        let run: Run = parse(body.as_bytes()).unwrap_or_else(|error| panic!("{error}"));
        run.words().join(" ")
    }

    #[test]
    fn page_and_command_line_have_the_same_commands() {
        for (body, expected) in [
            (r#""save""#, "save"),
            (r#""load-factory""#, "load-factory"),
            (r#""restart""#, "restart"),
            (r#"{"get":{}}"#, "get"),
            (r#"{"get":{"names":["filter"]}}"#, "get filter"),
            (
                r#"{"set":{"assignments":["zero-x=-1deg","b=2"],"save":true}}"#,
                "set --save zero-x=-1deg b=2",
            ),
            (r#"{"zero":{}}"#, "zero"),
            (r#"{"zero":{"axis":"x","save":true}}"#, "zero --save x"),
            (r#"{"teach":{}}"#, "teach"),
            (r#"{"node-id":{"new":11}}"#, "node-id 11"),
            (r#"{"mac":{"new":7}}"#, "mac 7"),
            (r#"{"address":{"new":160}}"#, "address 160"),
            (r#"{"rate":{"new":"500"}}"#, "rate 500"),
            (r#"{"rate":{"new":"auto"}}"#, "rate auto"),
            (r#"{"label":{"name":"boom"}}"#, "label boom"),
            (r#"{"label":{"name":"--remove"}}"#, "label -- --remove"),
            (r#"{"label":{}}"#, "label --remove"),
            (r#""identity""#, "identity"),
            (r#"{"raw":{"request":"1018:1"}}"#, "raw 1018:1"),
            (r#"{"raw":{"request":"--help"}}"#, "raw -- --help"),
        ] {
            let words = words(body);
            assert_eq!(words, expected);
            let all = format!("plumbline {words}");
            assert!(Cli::try_parse_from(all.split(' ')).is_ok(), "{all}");
        }
    }

    #[test]
    fn unknown_commands_and_fields_are_refused() {
        for body in [
            "",
            "null",
            "{}",
            "[]",
            r#""serve""#,
            r#""man""#,
            r#"{"set":{}}"#,
            r#"{"set":{"assignments":"a=1"}}"#,
            r#"{"set":{"assignments":[],"file":"/etc/passwd"}}"#,
            r#"{"zero":{"axis":1}}"#,
            r#"{"node-id":{"new":256}}"#,
            r#"{"node-id":{"new":-1}}"#,
            r#"{"zero":{},"save":{}}"#,
        ] {
            assert!(parse::<Run>(body.as_bytes()).is_err(), "{body}");
        }
    }
}
