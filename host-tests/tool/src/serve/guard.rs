//! Which requests the server accepts. Any page in the user's browser can send requests to this computer, but another page must not move the
//! zero point of a crane.
//!
//! | check | against |
//! |---|---|
//! | Host is an IP address of the server or `localhost`, with its port | a foreign name that resolves to this computer |
//! | Origin, if there is one, is the one of the page | requests of other pages |
//! | `Sec-Fetch-Site`, if there is one, is `same-origin` or `none` | the same, also without Origin |
//! | `X-Plumbline-Token` has the secret (only `/api/`) | other pages, other users of the computer |
//! | POST has `application/json`, and is not too long (only `/api/`) | forms of other pages |

use super::api::{App, Refusal, longest};
use crate::error::{Forbidden, PageError};
use axum::extract::{Request, State};
use axum::http::header::{self, HeaderName, HeaderValue};
use axum::http::{HeaderMap, Method, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;

/// The header with the secret.
pub const TOKEN: &str = "x-plumbline-token";

/// The headers of every answer.
const HEADERS: [(HeaderName, &str); 7] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; object-src 'none'",
    ),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::X_FRAME_OPTIONS, "DENY"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CACHE_CONTROL, "no-store"),
    (
        HeaderName::from_static("cross-origin-resource-policy"),
        "same-origin",
    ),
    (
        HeaderName::from_static("cross-origin-opener-policy"),
        "same-origin",
    ),
];

/// Checks a request, and gives its answer the headers.
pub async fn check(State(app): State<Arc<App>>, request: Request, next: Next) -> Response {
    let judged = judge(
        &app,
        request.method(),
        request.headers(),
        request.uri().path(),
    );
    let mut response = match judged {
        Ok(()) => next.run(request).await,
        Err((status, why)) => Refusal {
            status,
            failure: PageError::Forbidden(why).into(),
        }
        .into_response(),
    };
    for (name, value) in HEADERS {
        let value = HeaderValue::from_static(value);
        response.headers_mut().insert(name, value);
    }
    response
}

type Judged = Result<(), (StatusCode, Forbidden)>;

fn judge(app: &App, method: &Method, headers: &HeaderMap, path: &str) -> Judged {
    let is_api = path == "/api" || path.starts_with("/api/");
    // Several headers of one name are no header of ours.
    let text = |name: &str| -> Result<Option<String>, (StatusCode, Forbidden)> {
        let mut values = headers.get_all(name).iter();
        match (values.next(), values.next()) {
            (None, _) => Ok(None),
            (Some(value), None) => match value.to_str() {
                Ok(value) => Ok(Some(value.to_owned())),
                Err(_) => Err((StatusCode::BAD_REQUEST, Forbidden::Unreadable)),
            },
            _ => Err((StatusCode::BAD_REQUEST, Forbidden::Twice)),
        }
    };
    let host = text("host")?.unwrap_or_default();
    if !is_own_host(&host, app.address) {
        return Err((StatusCode::FORBIDDEN, Forbidden::Host));
    }
    if let Some(origin) = text("origin")?
        && !origin.eq_ignore_ascii_case(&format!("http://{host}"))
    {
        return Err((StatusCode::FORBIDDEN, Forbidden::Origin));
    }
    if let Some(site) = text("sec-fetch-site")?
        && is_api
        && !["same-origin", "none"].contains(&site.as_str())
    {
        return Err((StatusCode::FORBIDDEN, Forbidden::Origin));
    }
    if !is_api {
        return Ok(());
    }
    if !is_equal(&text(TOKEN)?.unwrap_or_default(), &app.token) {
        return Err((StatusCode::UNAUTHORIZED, Forbidden::Secret));
    }
    if *method == Method::POST {
        let kind = text("content-type")?.unwrap_or_default();
        let kind = kind.split(';').next().unwrap_or_default().trim();
        if !kind.eq_ignore_ascii_case("application/json") {
            return Err((StatusCode::UNSUPPORTED_MEDIA_TYPE, Forbidden::ContentType));
        }
        let length = text("content-length")?.and_then(|length| length.parse::<usize>().ok());
        if length.is_some_and(|length| length > longest(path)) {
            return Err((StatusCode::PAYLOAD_TOO_LARGE, Forbidden::TooLong));
        }
    }
    Ok(())
}

/// Whether a Host header means this server. A name other than `localhost` can be a foreign one that resolves to this computer.
fn is_own_host(host: &str, own: SocketAddr) -> bool {
    let (name, port) = match host.rsplit_once(':') {
        Some((name, port)) if !port.contains(']') => (name, port.parse().ok()),
        // A browser leaves out the port 80.
        _ => (host, Some(80)),
    };
    if port != Some(own.port()) {
        return false;
    }
    if name.eq_ignore_ascii_case("localhost") {
        return own.ip().is_loopback() || own.ip().is_unspecified();
    }
    let bare = name
        .strip_prefix('[')
        .and_then(|name| name.strip_suffix(']'));
    let Ok(ip) = bare.unwrap_or(name).parse::<IpAddr>() else {
        return false;
    };
    ip == own.ip() || own.ip().is_unspecified()
}

/// Compares secrets in a time that does not depend on the first difference.
fn is_equal(one: &str, other: &str) -> bool {
    let pairs = one.bytes().zip(other.bytes());
    one.len() == other.len() && pairs.fold(0, |sum, (one, other)| sum | (one ^ other)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn host_is_address_of_server_or_localhost_with_its_port() {
        let own = "127.0.0.1:8080".parse().expect("an address");
        for host in ["127.0.0.1:8080", "localhost:8080", "LOCALHOST:8080"] {
            assert!(is_own_host(host, own), "{host}");
        }
        for host in [
            "",
            "127.0.0.1",
            "127.0.0.1:8081",
            "evil.example:8080",
            "127.0.0.1.evil.example:8080",
            "localhost.:8080",
            "[::1]:8080",
            "192.168.1.2:8080",
            "127.0.0.1:8080:8080",
        ] {
            assert!(!is_own_host(host, own), "{host}");
        }
        let all = "0.0.0.0:80".parse().expect("an address");
        assert!(is_own_host("192.168.1.2", all) && is_own_host("[::1]", all));
        assert!(!is_own_host("evil.example", all));
    }

    #[test]
    fn secret_matches_only_if_complete() {
        assert!(is_equal("ab", "ab"));
        assert!(!is_equal("", "ab") && !is_equal("a", "ab") && !is_equal("ac", "ab"));
    }
}
