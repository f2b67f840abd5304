//! The files of the page. They are parts of the program, so that it is one file.

use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};

/// A file: its path on the server, its content type, its bytes.
type Asset = (&'static str, &'static str, &'static [u8]);

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const JS: &str = "text/javascript; charset=utf-8";

macro_rules! asset {
    ($kind:expr, $path:literal) => {
        (
            concat!("/", $path),
            $kind,
            include_bytes!(concat!("../../assets/", $path)),
        )
    };
}

/// All files besides the first page.
pub const ASSETS: &[Asset] = &[
    asset!(HTML, "index.html"),
    asset!(CSS, "style.css"),
    asset!(JS, "app.js"),
    asset!(JS, "api.js"),
    asset!(JS, "actions.js"),
    asset!(JS, "align.js"),
    asset!(JS, "angles.js"),
    asset!(JS, "attitude.js"),
    asset!(JS, "calibrate.js"),
    asset!(JS, "chart.js"),
    asset!(JS, "connection.js"),
    asset!(JS, "dialog.js"),
    asset!(JS, "document.js"),
    asset!(JS, "failure.js"),
    asset!(JS, "focus.js"),
    asset!(JS, "frames.js"),
    asset!(JS, "identity.js"),
    asset!(JS, "log.js"),
    asset!(JS, "owner.js"),
    asset!(JS, "parameters.js"),
    asset!(JS, "reading.js"),
    asset!(JS, "ring.js"),
    asset!(JS, "stand-in.js"),
    asset!(JS, "state.js"),
    asset!(JS, "texts.js"),
    asset!(JS, "trace.js"),
    asset!(JS, "transmit.js"),
    asset!(JS, "update.js"),
    asset!(JS, "texts-de.js"),
    asset!(JS, "texts-en.js"),
    asset!("image/svg+xml", "icon.svg"),
    asset!(JS, "uplot/uPlot.iife.min.js"),
    asset!(CSS, "uplot/uPlot.min.css"),
    asset!("text/plain; charset=utf-8", "uplot/LICENSE"),
];

/// The file at a path.
pub fn answer(path: &str) -> Response {
    let path = if path == "/" { "/index.html" } else { path };
    match ASSETS.iter().find(|(own, ..)| *own == path) {
        Some((_, kind, bytes)) => ([(CONTENT_TYPE, *kind)], *bytes).into_response(),
        None => (StatusCode::NOT_FOUND, "there is no such file\n").into_response(),
    }
}
