//! The requests that use the bus: jobs for the worker.

use super::{Answer, App, on_sensor, parse, work};
use crate::error::{Error, PageError};
use crate::serve::job::{self, Task};
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

pub(super) async fn scan(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    work(&app, Task::Scan(parse(&body)?)).await
}

/// Performs an operation on the sensor.
pub(super) async fn run(State(app): State<Arc<App>>, headers: HeaderMap, body: Bytes) -> Answer {
    on_sensor(&app, &headers, Task::Run(parse(&body)?)).await
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
        return Err(Error::from(PageError::Samples(MOST_SAMPLES)).into());
    }
    work(&app, Task::Samples(per_second)).await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Image {
    name: String,
    image: Vec<u8>,
}

/// What an image file is for.
pub(super) async fn image(body: Bytes) -> Answer {
    let Image { name, image } = parse(&body)?;
    let image = job::image(&name, image)?;
    Ok(axum::Json(json!({
        "product": image.product(),
        "version": image.version(),
        "board": image.board,
        "signed": image.header.key() != 0,
    })))
}

/// Loads another program into a sensor.
pub(super) async fn update(State(app): State<Arc<App>>, headers: HeaderMap, body: Bytes) -> Answer {
    on_sensor(&app, &headers, Task::Update(parse(&body)?)).await
}

/// Makes the offset of the mounting zero.
pub(super) async fn align(State(app): State<Arc<App>>, headers: HeaderMap, body: Bytes) -> Answer {
    on_sensor(&app, &headers, Task::Align(parse(&body)?)).await
}

/// Adds or removes a sensor of the chart.
pub(super) async fn chart(State(app): State<Arc<App>>, headers: HeaderMap, body: Bytes) -> Answer {
    on_sensor(&app, &headers, Task::Chart(parse(&body)?)).await
}

/// Moves or breaks the virtual sensor.
pub(super) async fn stand_in(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    work(&app, Task::StandIn(parse(&body)?)).await
}

/// Changes what is sent beside the requests.
pub(super) async fn transmit(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    work(&app, Task::Transmit(parse(&body)?)).await
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
