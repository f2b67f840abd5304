//! The server of the page, with virtual sensors.

use plumbline_tool::adapter;
use plumbline_tool::cli::Options;
use plumbline_tool::serve::job::Opener;
use plumbline_tool::serve::{Server, Settings};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

/// A server that runs until it is dropped.
pub struct Running {
    pub url: String,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    /// The names of sensors.
    _config: tempfile::TempDir,
}

impl Running {
    /// A server that connects to this port at once; none for an empty text.
    pub fn new(port: &str) -> Self {
        Self::with(port, Box::new(adapter::connect))
    }

    /// The same with other adapters.
    pub fn with(port: &str, opener: Opener) -> Self {
        let config = tempfile::tempdir().expect("a folder");
        let settings = Settings {
            listen: "127.0.0.1:0".parse().expect("an address"),
            options: Options {
                port: (!port.is_empty()).then(|| port.to_owned()),
                config: Some(config.path().to_owned()),
                ..Options::default()
            },
            demo: !port.is_empty(),
            unit: None,
        };
        let server = Server::bind(settings).expect("a free port");
        let url = server.url();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        let thread = thread::spawn(move || {
            let run = server.run(opener, &|| stopped.load(Ordering::Relaxed));
            run.expect("the server runs");
        });
        Self {
            url,
            stop,
            thread: Some(thread),
            _config: config,
        }
    }
}

impl Running {
    /// Takes the place of a tab, until it is dropped.
    pub fn tab(&self) -> TcpStream {
        let (address, token) = self.url.split_once("/#").expect("an address with a secret");
        let address = address.trim_start_matches("http://");
        let mut stream = TcpStream::connect(address).expect("a connection");
        let request = format!(
            "GET /api/events HTTP/1.1\r\nHost: {address}\r\nX-Plumbline-Token: {token}\r\n\r\n"
        );
        stream.write_all(request.as_bytes()).expect("it is sent");
        let mut status = [0; 12];
        stream.read_exact(&mut status).expect("an answer");
        assert_eq!(&status, b"HTTP/1.1 200");
        stream
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let ended = self.thread.take().expect("it runs").join();
        assert!(ended.is_ok() || thread::panicking(), "the server ends");
    }
}
