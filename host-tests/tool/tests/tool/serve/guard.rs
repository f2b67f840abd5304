//! The server refuses requests of other pages, requests with another host name, and requests without the secret.

use crate::serve::client::Running;

/// The page loads only files of this server, and no other page shows it or sends a form to it.
const POLICY: &str = "content-security-policy: default-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; object-src 'none'";

#[test]
fn page_needs_no_secret_and_has_a_strict_policy() {
    let server = Running::new();
    for (path, kind) in [
        ("/", "text/html"),
        ("/style.css", "text/css"),
        ("/app.js", "text/javascript"),
        ("/uplot/uPlot.iife.min.js", "text/javascript"),
        ("/uplot/LICENSE", "text/plain"),
    ] {
        let answer = server.request(&format!("GET {path}"), &[], "");
        assert_eq!(answer.status, 200, "{path}");
        assert!(
            answer.head.contains(&format!("content-type: {kind}")),
            "{answer:?}"
        );
        assert!(answer.head.lines().any(|line| line == POLICY), "{answer:?}");
        assert!(
            answer.head.contains("x-content-type-options: nosniff"),
            "{answer:?}"
        );
        assert!(
            answer.head.contains("cache-control: no-store"),
            "{answer:?}"
        );
    }
    assert_eq!(server.get("/../Cargo.toml").status, 404);
    assert_eq!(server.get("/nothing").status, 404);
}

#[test]
fn policy_permits_every_file_of_the_page() {
    let server = Running::new();
    let page = server.get("/").body;
    // Scripts and styles inside of the page would be refused by the browser.
    assert!(!page.contains("<style") && !page.contains(" style=") && !page.contains(" onclick="));
    for attribute in page
        .split(['"', ' '])
        .filter(|part| part.ends_with(".js") || part.ends_with(".css"))
    {
        let answer = server.get(&format!("/{attribute}"));
        assert_eq!(answer.status, 200, "{attribute}");
    }
    // Modules import only files that exist.
    for module in [
        "app.js",
        "parameters.js",
        "document.js",
        "chart.js",
        "frames.js",
    ] {
        let text = server.get(&format!("/{module}")).body;
        for import in text.split("from \"./").skip(1) {
            let path = import.split('"').next().expect("a path");
            assert_eq!(
                server.get(&format!("/{path}")).status,
                200,
                "{module}: {path}"
            );
        }
    }
}

#[test]
fn request_without_secret_is_refused() {
    let server = Running::new();
    let token = server.token.clone();
    let wrong = token.replace(|letter: char| letter != '0', "0");
    for secret in ["", "x", &token[..31], &format!("{token}0"), &wrong] {
        for line in [
            "GET /api/ports",
            "GET /api/events",
            "POST /api/stop",
            "GET /api/nothing",
        ] {
            let headers = [
                ("X-Plumbline-Token", secret),
                ("Content-Type", "application/json"),
            ];
            let answer = server.request(line, &headers, "{}");
            assert_eq!(
                (answer.status, answer.code().as_str()),
                (401, "forbidden"),
                "{line} {secret}"
            );
        }
    }
    // The secret is not in the address: addresses are kept in logs.
    let answer = server.request(&format!("GET /api/ports?token={token}"), &[], "");
    assert_eq!(answer.status, 401);
    let twice = [
        ("X-Plumbline-Token", token.as_str()),
        ("X-Plumbline-Token", token.as_str()),
    ];
    assert_eq!(server.request("GET /api/ports", &twice, "").status, 400);
}

#[test]
fn request_of_another_page_is_refused_with_the_secret_as_well() {
    let server = Running::new();
    let (token, own) = (server.token.clone(), format!("http://{}", server.address));
    let port = server.address.port();
    for origin in [
        "http://evil.example".to_owned(),
        "null".to_owned(),
        format!("https://{}", server.address),
        format!("http://127.0.0.1:{}", port.wrapping_add(1)),
        format!("http://localhost:{port}"),
        format!("{own}.evil.example"),
    ] {
        let headers = [
            ("X-Plumbline-Token", token.as_str()),
            ("Content-Type", "application/json"),
            ("Origin", origin.as_str()),
        ];
        let answer = server.request("POST /api/stop", &headers, "{}");
        assert_eq!(
            (answer.status, answer.code().as_str()),
            (403, "forbidden"),
            "{origin}"
        );
    }
    for site in ["cross-site", "same-site"] {
        let headers = [
            ("X-Plumbline-Token", token.as_str()),
            ("Sec-Fetch-Site", site),
        ];
        assert_eq!(
            server.request("GET /api/ports", &headers, "").status,
            403,
            "{site}"
        );
    }
    assert_eq!(server.post("/api/stop", "{}").status, 200);
}

#[test]
fn name_that_is_not_of_this_server_is_refused() {
    let server = Running::new();
    let (token, port) = (server.token.clone(), server.address.port());
    for host in [
        format!("evil.example:{port}"),
        format!("127.0.0.1.evil.example:{port}"),
        "127.0.0.1".to_owned(),
        format!("192.168.0.1:{port}"),
        String::new(),
    ] {
        for path in ["/", "/api/ports"] {
            let headers = [
                ("Host", host.as_str()),
                ("X-Plumbline-Token", token.as_str()),
            ];
            let answer = server.request(&format!("GET {path}"), &headers, "");
            assert_eq!(answer.status, 403, "{host} {path}");
        }
    }
    let local = format!("localhost:{port}");
    let headers = [
        ("Host", local.as_str()),
        ("X-Plumbline-Token", token.as_str()),
    ];
    assert_eq!(server.request("GET /api/ports", &headers, "").status, 200);
}

#[test]
fn form_of_another_page_is_refused() {
    let server = Running::new();
    let token = server.token.clone();
    for kind in [
        "text/plain",
        "application/x-www-form-urlencoded",
        "multipart/form-data; boundary=x",
        "text/plain; application/json",
        "",
    ] {
        let headers = [
            ("X-Plumbline-Token", token.as_str()),
            ("Content-Type", kind),
        ];
        assert_eq!(
            server.request("POST /api/stop", &headers, "{}").status,
            415,
            "{kind}"
        );
    }
    let headers = [
        ("X-Plumbline-Token", token.as_str()),
        ("Content-Type", "Application/JSON; charset=utf-8"),
    ];
    assert_eq!(server.request("POST /api/stop", &headers, "{}").status, 200);
}
