//! The requests of the page. All bodies and answers are JSON; an error has the document of `--json`, and for the page `texts`, or `asks`.
//! `run`, `align`, `update`, `backup` and `restore` have the number of their sensor in a header, and are refused if it is not the one that is connected. A tab
//! gives its name in a header, and is refused to act while another tab is in charge.
//!
//! | request | body | does |
//! |---|---|---|
//! | `GET /api/events` | | server-sent events |
//! | `POST /api/owner` | | the tab takes over from the one that is in charge |
//! | `GET /api/ports` | | the ports of this computer, and what the command line says |
//! | `GET /api/products` | | the products of the catalogue |
//! | `GET /api/protocols` | | the protocols, with the command that changes the address |
//! | `GET /api/parameters/PRODUCT` | | names, ranges, units and factory values of a product, or of a data sheet |
//! | `POST /api/connect` | `{"port": .., "mode": "active"}` | finds the sensor, and polls it |
//! | `POST /api/disconnect` | `{}` | closes the adapter |
//! | `POST /api/scan` | `{"port": .., "active": false}` | finds sensors |
//! | `POST /api/stop` | `{}` | stops the running command |
//! | `POST /api/run` | `"save"`, `{"zero": {"axis": "x"}}` | a command on the sensor |
//! | `POST /api/align` | `{"save": true}` | the offset of the mounting, with the questions `turn` and `align` |
//! | `POST /api/image` | `{"name": .., "image": [..]}` | what an image file is for |
//! | `POST /api/update` | `{"name": .., "image": [..], "backup": "..", "waiting": null}` | loads it into the sensor, or into one that waits in its bootloader |
//! | `POST /api/samples` | `{"perSecond": 200}` | the samples per second |
//! | `POST /api/chart` | `{"add": {"protocol": .., "address": ..}}`, `{"remove": 2}` | the sensors in the chart beside the connected one |
//! | `POST /api/transmit` | `{"add": {"frame": "181#0102", "every": 100}}`, `{"start": 1}`, `{"replay": {"text": .., ..}}` | the transmit list, and the replay of a log |
//! | `POST /api/stand-in` | `{"do": "tilt", "x": 10, "y": -2.5}` | moves or breaks the virtual sensor of a demonstration, by the control protocol of `virtual-sensor` |
//! | `POST /api/backup` | `{}` | reads all settings into a file |
//! | `POST /api/restore` | `{"text": .., "only": []}` | writes the differences, stores them |
//! | `POST /api/eds` | `{"name": .., "text": ..}` | takes a data sheet, which has a key then: `eds:1` |
//! | `POST /api/calibrate` | `"start"`, `{"take": 7}`, `{"again": 7}`, `"stop"` | the calibration of a unit |
//! | `POST /api/identity` | `{"text": .., "name": .., "product": ..}` | reads the identity in an EDS, a DCF or a sheet |
//! | `POST /api/identity/store` | the same | writes it into the store file of the command line |
//! | `POST /api/file` | `{"text": ..}`, `{"product": ..}` | reads a file; or a file with factory values |
//! | `POST /api/file/set` | `{"text": .., "name": .., "value": ..}` | changes a value in a file |

pub mod bus;
pub mod catalog;
pub mod file;
mod identity;

use super::calibration::Calibration;
use super::events::{Hub, tell};
use super::job::{Job, Start, Task};
use super::sheets::Sheets;
use super::{assets, guard};
use crate::error::{BadRequest, Error, PageError};
use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::header::CONTENT_TYPE;
use axum::http::{HeaderMap, StatusCode, Uri};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::convert::Infallible;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::Sender;
use texts::Kind;
use tokio::sync::oneshot;
use tokio_stream::StreamExt;
use tokio_stream::wrappers::ReceiverStream;

/// The longest body in bytes: a file of 1 MiB with its escapes.
const LONGEST: usize = 3 << 20;

/// The request that sends a log, and its longest body: a log of 16 MiB with its escapes.
const TRANSMIT: &str = "/api/transmit";
const LONGEST_LOG: usize = 18 << 20;

/// The longest body of a request in bytes.
pub fn longest(path: &str) -> usize {
    match path {
        TRANSMIT => LONGEST_LOG,
        _ => LONGEST,
    }
}

/// The header with the number of the sensor that the page shows: `connection` of the event `device`.
const SENSOR: &str = "x-plumbline-sensor";

/// The header with the name that a tab has given itself. A program has none.
const TAB: &str = "x-plumbline-tab";

/// What the handlers of all requests share.
pub struct App {
    /// The jobs of the worker.
    pub jobs: Sender<Job>,
    /// The open tabs of browsers.
    pub hub: Arc<Hub>,
    /// Stops the running command when it is set.
    pub stop: Arc<AtomicBool>,
    /// What the page offers first.
    pub start: Start,
    /// The secret that each request must contain.
    pub token: String,
    /// The address of the server.
    pub address: SocketAddr,
    /// The calibration of a unit.
    pub calibration: Arc<Calibration>,
    /// The data sheets that the user has opened.
    pub sheets: Arc<Sheets>,
    /// The store file of the command line.
    pub store: Option<PathBuf>,
    /// The folder with what the tool remembers; None: the folder of the user.
    pub config: Option<PathBuf>,
}

/// The answer to a request that failed.
pub struct Refusal {
    /// The status code of HTTP.
    pub status: StatusCode,
    /// The failure that the page shows.
    pub failure: Error,
}

impl From<Error> for Refusal {
    fn from(failure: Error) -> Self {
        let status = match failure.kind() {
            Kind::Refused => StatusCode::CONFLICT,
            Kind::Usage => StatusCode::BAD_REQUEST,
            Kind::Silent => StatusCode::GATEWAY_TIMEOUT,
            Kind::Bus | Kind::Stopped => StatusCode::BAD_GATEWAY,
        };
        Self { status, failure }
    }
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        let mut answer = json!({});
        tell(&mut answer, &self.failure);
        (self.status, axum::Json(answer)).into_response()
    }
}

/// The answer to a request.
pub type Answer = Result<axum::Json<Value>, Refusal>;

/// The pages and the requests.
pub fn router(app: App) -> Router {
    let app = Arc::new(app);
    let acts = Router::new()
        .route("/connect", post(bus::connect))
        .route("/disconnect", post(bus::disconnect))
        .route("/scan", post(bus::scan))
        .route("/stop", post(bus::stop))
        .route("/run", post(bus::run))
        .route("/stand-in", post(bus::stand_in))
        .route("/update", post(bus::update))
        .route("/align", post(bus::align))
        .route("/samples", post(bus::samples))
        .route("/chart", post(bus::chart))
        .route(
            "/transmit",
            post(bus::transmit).layer(DefaultBodyLimit::max(LONGEST_LOG)),
        )
        .route("/backup", post(bus::backup))
        .route("/restore", post(bus::restore))
        .route("/calibrate", post(calibrate))
        .route("/identity/store", post(identity::write))
        .route_layer(middleware::from_fn_with_state(app.clone(), in_charge));
    let api = Router::new()
        .merge(acts)
        .route("/owner", post(take_over))
        .route("/events", get(events))
        .route("/ports", get(catalog::ports))
        .route("/products", get(catalog::products))
        .route("/protocols", get(catalog::protocols))
        .route("/parameters/{product}", get(catalog::parameters))
        .route("/eds", post(file::data_sheet))
        .route("/identity", post(identity::read))
        .route("/image", post(bus::image))
        .route("/file", post(file::open))
        .route("/file/set", post(file::set))
        .fallback(nothing)
        .method_not_allowed_fallback(nothing);
    Router::new()
        .nest("/api", api)
        .fallback(get(|uri: Uri| async move { assets::answer(uri.path()) }))
        .layer(DefaultBodyLimit::max(LONGEST))
        .layer(middleware::from_fn_with_state(app.clone(), guard::check))
        .with_state(app)
}

/// The name of the tab of a request.
fn tab(headers: &HeaderMap) -> Option<&str> {
    let name = headers.get(TAB)?.to_str().ok()?;
    Some(name).filter(|name| !name.is_empty() && name.len() <= 64)
}

/// Refuses what a tab does while another one is in charge.
async fn in_charge(
    State(app): State<Arc<App>>,
    request: Request,
    next: Next,
) -> Result<Response, Refusal> {
    match tab(request.headers()) {
        Some(name) if !app.hub.may_act(name) => Err(Error::from(PageError::OtherTab).into()),
        _ => Ok(next.run(request).await),
    }
}

/// Lets this tab be in charge.
async fn take_over(State(app): State<Arc<App>>, headers: HeaderMap) -> Answer {
    let name = tab(&headers).ok_or(Error::from(PageError::NoTab))?;
    app.hub.take_over(name);
    Ok(axum::Json(Value::Null))
}

async fn nothing() -> Refusal {
    Refusal {
        status: StatusCode::NOT_FOUND,
        failure: PageError::NoRequest.into(),
    }
}

/// The events of a tab.
async fn events(State(app): State<Arc<App>>, headers: HeaderMap) -> Result<Response, Refusal> {
    let name = tab(&headers).map(str::to_owned);
    let events = app.hub.subscribe(name).map_err(|failure| Refusal {
        status: StatusCode::SERVICE_UNAVAILABLE,
        failure,
    })?;
    let stream = ReceiverStream::new(events)
        .map(|event| Ok::<_, Infallible>(Bytes::from(event.as_bytes().to_vec())));
    let headers = [(CONTENT_TYPE, "text/event-stream")];
    Ok((headers, Body::from_stream(stream)).into_response())
}

/// The calibration of a unit.
async fn calibrate(State(app): State<Arc<App>>, body: Bytes) -> Answer {
    app.calibration.handle(parse(&body)?)?;
    Ok(axum::Json(Value::Null))
}

/// Hands a job to the worker that is only for the sensor of the page.
///
/// # Errors
/// The worker has another sensor, or the job fails.
async fn on_sensor(app: &App, headers: &HeaderMap, task: Task) -> Answer {
    let sensor = headers.get(SENSOR).and_then(|value| value.to_str().ok());
    let sensor = sensor.and_then(|text| text.parse().ok());
    let task = Box::new(task);
    work(app, Task::For { sensor, task }).await
}

/// The body of a request.
///
/// # Errors
/// It is not what the request needs.
pub fn parse<T: DeserializeOwned>(body: &[u8]) -> Result<T, Error> {
    // A list is no object, though its fields could be taken in their order.
    if body.trim_ascii_start().starts_with(b"[") {
        return Err(PageError::List.into());
    }
    serde_json::from_slice(body).map_err(|error| PageError::Invalid(BadRequest::from(error)).into())
}

/// Hands a job to the worker and waits for its answer.
///
/// # Errors
/// The job fails.
pub async fn work(app: &App, task: Task) -> Answer {
    let gone = || Error::from(PageError::Stopping);
    let (reply, answer) = oneshot::channel();
    app.jobs.send(Job { task, reply }).map_err(|_| gone())?;
    let answer = answer.await.map_err(|_| gone())?;
    Ok(axum::Json(answer?))
}
