//! The broker mosquitto, and a subscriber.

use rumqttc::{Client, Event, MqttOptions, Packet, QoS};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::io::{Write, stderr};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Waits until something is so. The time is only a limit for a test that fails.
#[track_caller]
pub fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs(120);
    while !is_so() {
        assert!(Instant::now() < end, "{what} did not come");
        thread::sleep(Duration::from_millis(20));
    }
}

/// Asks a program to end, with SIGTERM.
pub fn terminate(child: &Child) {
    let sent = Command::new("kill").arg(child.id().to_string()).status();
    assert!(sent.is_ok_and(|status| status.success()));
}

/// A broker that keeps its sessions while it is away.
pub struct Mosquitto {
    program: PathBuf,
    folder: PathBuf,
    port: u16,
    has_tls: bool,
    child: Option<Child>,
}

impl Mosquitto {
    /// Starts it with its files in a folder. `with` has "password" for the user crane with the password right, "tls", and "certificate" if it
    /// wants one of the client. None: the program does not exist.
    pub fn start(folder: &Path, with: &[&str]) -> Option<Self> {
        let places = [
            "mosquitto",
            "/usr/sbin/mosquitto",
            "/usr/local/sbin/mosquitto",
        ];
        let starts = |program: &&&str| {
            let help = Command::new(program)
                .arg("-h")
                .stdout(Stdio::null())
                .status();
            help.is_ok()
        };
        let Some(program) = places.iter().find(starts) else {
            assert!(std::env::var_os("CI").is_none(), "there is no mosquitto");
            let _ = writeln!(stderr(), "skipped: bridge: there is no mosquitto");
            return None;
        };
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let port = listener.local_addr().expect("an address").port();
        drop(listener);
        let shown = folder.display();
        let mut text = format!(
            "listener {port} 127.0.0.1\npersistence true\npersistence_location {shown}/\nmax_queued_messages 0\n"
        );
        match with.contains(&"password") {
            true => {
                done("mosquitto_passwd", folder, "-c -b users crane right");
                let _ = writeln!(text, "password_file {shown}/users");
            }
            false => text.push_str("allow_anonymous true\n"),
        }
        if with.contains(&"tls") {
            certificates(folder);
            let _ = write!(
                text,
                "certfile {shown}/server.pem\nkeyfile {shown}/server.key\n"
            );
        }
        if with.contains(&"certificate") {
            let _ = write!(text, "cafile {shown}/ca.pem\nrequire_certificate true\n");
        }
        // It changes to a user of its own otherwise.
        text.push_str("user root\n");
        std::fs::write(folder.join("mosquitto.conf"), text).expect("a file");
        let mut broker = Self {
            program: program.into(),
            folder: folder.to_owned(),
            port,
            has_tls: with.contains(&"tls"),
            child: None,
        };
        broker.go_on();
        Some(broker)
    }

    /// The address for `--mqtt`.
    pub fn url(&self) -> String {
        let scheme = if self.has_tls { "mqtts" } else { "mqtt" };
        format!("{scheme}://localhost:{}", self.port)
    }

    /// Starts it again.
    pub fn go_on(&mut self) {
        let mut command = Command::new(&self.program);
        command.arg("-c").arg(self.folder.join("mosquitto.conf"));
        command.stdout(Stdio::null()).stderr(Stdio::null());
        self.child = Some(command.spawn().expect("mosquitto starts"));
        until("mosquitto", || {
            TcpStream::connect(("127.0.0.1", self.port)).is_ok()
        });
    }

    /// Ends it. It keeps its sessions in its file.
    pub fn stop(&mut self) {
        if let Some(mut child) = self.child.take() {
            terminate(&child);
            child.wait().expect("mosquitto ends");
        }
    }
}

impl Drop for Mosquitto {
    fn drop(&mut self) {
        if let Some(mut child) = self.child.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn done(program: &str, folder: &Path, words: &str) {
    let mut command = Command::new(program);
    command.current_dir(folder).args(words.split(' '));
    let output = command
        .output()
        .unwrap_or_else(|error| panic!("{program}: {error}"));
    assert!(output.status.success(), "{program} {words}: {output:?}");
}

/// An authority with the certificates of the broker and of a client, and another authority.
fn certificates(folder: &Path) {
    std::fs::write(
        folder.join("names"),
        "subjectAltName=DNS:localhost,IP:127.0.0.1\n",
    )
    .expect("a file");
    let key = "-newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes";
    for name in ["ca", "other"] {
        let words =
            format!("req -x509 {key} -keyout {name}.key -out {name}.pem -subj /CN={name} -days 30");
        done("openssl", folder, &words);
    }
    for (name, subject) in [("server", "localhost"), ("client", "crane")] {
        let words = format!("req {key} -keyout {name}.key -out {name}.csr -subj /CN={subject}");
        done("openssl", folder, &words);
        let words = format!(
            "x509 -req -in {name}.csr -CA ca.pem -CAkey ca.key -CAcreateserial -out {name}.pem -days 30 -extfile names"
        );
        done("openssl", folder, &words);
    }
}

/// The messages that a subscriber has taken.
#[derive(Default)]
pub struct Collected {
    /// The numbers of the documents with angles.
    pub numbers: BTreeSet<u64>,
    /// The documents that have the number of another one.
    pub different: usize,
    /// The newest text of each topic.
    pub newest: BTreeMap<String, String>,
    texts: BTreeMap<u64, String>,
}

/// A subscriber whose session the broker keeps.
pub struct Subscriber {
    messages: Receiver<(String, String)>,
}

impl Subscriber {
    /// Subscribes to these topics.
    pub fn new(broker: &Mosquitto, topics: &'static str) -> Self {
        let mut options = MqttOptions::new("subscriber", "127.0.0.1", broker.port);
        options.set_clean_session(false);
        let (client, mut connection) = Client::new(options, 100);
        let (sender, messages) = channel();
        let (ready, is_ready) = channel();
        thread::spawn(move || {
            client
                .subscribe(topics, QoS::AtLeastOnce)
                .expect("a request");
            for event in connection.iter() {
                match event {
                    // The broker is away.
                    Err(_) => thread::sleep(Duration::from_millis(100)),
                    Ok(Event::Incoming(Packet::SubAck(_))) => {
                        let _ = ready.send(());
                    }
                    Ok(Event::Incoming(Packet::Publish(message))) => {
                        let text = String::from_utf8_lossy(&message.payload).into_owned();
                        if sender.send((message.topic, text)).is_err() {
                            break;
                        }
                    }
                    Ok(_) => {}
                }
            }
        });
        is_ready.recv().expect("a subscription");
        Self { messages }
    }

    /// Takes what has come.
    pub fn collect(&mut self, all: &mut Collected) {
        for (topic, text) in self.messages.try_iter() {
            let document: Value = serde_json::from_str(&text).unwrap_or(Value::Null);
            if let Some(number) = document["seq"].as_u64() {
                all.numbers.insert(number);
                let first = all.texts.entry(number).or_insert_with(|| text.clone());
                all.different += usize::from(*first != text);
            }
            all.newest.insert(topic, text);
        }
    }
}
