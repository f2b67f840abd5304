//! `bridge` with the broker mosquitto, which is a program of its own. Without it the tests print `skipped`; in a continuous integration run
//! (`CI` is set) they fail.

use super::mosquitto::{Collected, Mosquitto, Subscriber, terminate, until};
use super::sensor::{Sensor, command, plumbline};
use bench::BusRate;
use plumbline::can::BitRate;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, UdpSocket};
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::Duration;
use virtual_sensor::server::Clock;

fn sensor() -> Sensor {
    Sensor::start("is2", BusRate::Fixed(BitRate::K250), Clock::Computer)
}

/// Starts `bridge` on the bus of a sensor.
fn start(sensor: &Sensor, folder: &Path, words: &str) -> Child {
    let buffer = folder.join("buffer");
    let line = format!(
        "--rate 250 --id 300 bridge --site yard --bus crane --buffer {} {words}",
        buffer.display()
    );
    let mut command = command(&sensor.port, "computer", &line);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().expect("the program starts")
}

/// The notes of a bridge until one has these words.
#[track_caller]
fn noted(child: &mut Child, part: &str) -> String {
    let lines = BufReader::new(child.stderr.take().expect("its notes")).lines();
    let mut notes = String::new();
    for line in lines {
        notes += &line.expect("a note");
        if notes.contains(part) {
            return notes;
        }
        notes.push('\n');
    }
    panic!("no {part}: {notes}");
}

/// The length of the records in the buffer.
fn buffered(folder: &Path) -> u64 {
    let files = std::fs::read_dir(folder.join("buffer"))
        .into_iter()
        .flatten();
    let lengths = files.filter_map(|file| {
        let file = file.ok()?;
        let is_own = file.path().extension().is_some_and(|own| own == "records");
        is_own
            .then(|| file.metadata().map(|own| own.len()).ok())
            .flatten()
    });
    lengths.sum()
}

fn kill(mut child: Child) {
    child.kill().expect("the program runs");
    child.wait().expect("the program ends");
}

/// The broker is away, the bridge is killed and started again, and the broker comes back.
#[test]
fn no_sample_is_lost_or_has_a_second_number_while_the_broker_is_away() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some(mut broker) = Mosquitto::start(folder.path(), &[]) else {
        return;
    };
    let sensor = sensor();
    let mut subscriber = Subscriber::new(&broker, "yard/crane/+/angle");
    let words = format!("--every 20 --mqtt {}", broker.url());
    let bridge = start(&sensor, folder.path(), &words);
    let mut all = Collected::default();
    until("the first samples", || {
        subscriber.collect(&mut all);
        all.numbers.len() >= 20
    });
    broker.stop();
    let before = buffered(folder.path());
    until("samples in the buffer", || {
        buffered(folder.path()) > before + 5000
    });
    kill(bridge);
    let bridge = start(&sensor, folder.path(), &words);
    let before = buffered(folder.path());
    until("more samples in the buffer", || {
        buffered(folder.path()) > before + 5000
    });
    let wanted = all.numbers.last().copied().unwrap_or_default() + 100;
    broker.go_on();
    until("all samples", || {
        subscriber.collect(&mut all);
        all.numbers.last().is_some_and(|last| *last > wanted)
    });
    kill(bridge);
    let expected: Vec<u64> = (1..).take(all.numbers.len()).collect();
    assert_eq!(all.numbers.iter().copied().collect::<Vec<_>>(), expected);
    assert_eq!(all.different, 0, "documents with the number of another one");
}

#[test]
fn broker_keeps_identity_status_availability_and_the_discovery() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some(broker) = Mosquitto::start(folder.path(), &[]) else {
        return;
    };
    let sensor = sensor();
    // A sensor that an earlier run has had.
    let buffer = folder.path().join("buffer");
    std::fs::create_dir(&buffer).expect("a folder");
    let known = buffer.join("sensors");
    std::fs::write(&known, "yard/crane/99/availability\n").expect("a file");
    let mut subscriber = Subscriber::new(&broker, "#");
    let bridge = start(&sensor, folder.path(), &format!("--mqtt {}", broker.url()));
    let mut all = Collected::default();
    until("all topics", || {
        subscriber.collect(&mut all);
        all.numbers.len() >= 3 && all.newest.len() >= 9
    });
    let text = |topic: &str| all.newest.get(topic).cloned().unwrap_or_default();
    let document = |topic: &str| serde_json::from_str(&text(topic)).unwrap_or(Value::Null);
    assert_eq!(text("yard/crane/bridge/availability"), "online");
    assert_eq!(text("yard/crane/1/availability"), "online");
    assert_eq!(text("yard/crane/99/availability"), "offline");
    let known = std::fs::read_to_string(known).expect("a file");
    assert_eq!(
        known,
        "yard/crane/1/availability\tGEMAC\nyard/crane/99/availability\t\n"
    );
    assert_eq!(document("yard/crane/1/status"), json!({"errors": []}));
    let identity = document("yard/crane/1/identity");
    for (name, value) in [
        ("maker", json!("GEMAC")),
        ("product", json!("is2")),
        ("serial", json!(1)),
        ("rate_kbits", json!(250)),
    ] {
        assert_eq!(identity[name], value, "{identity}");
    }
    let angle = document("yard/crane/1/angle");
    assert_eq!(
        (&angle["angle_x_deg"], &angle["angle_y_deg"]),
        (&json!(0.0), &json!(0.0))
    );
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let age = now.expect("a time").as_secs_f64() - angle["time_unix_s"].as_f64().unwrap_or(0.0);
    assert!((0.0..600.0).contains(&age), "{angle}");
    let entity = document("homeassistant/sensor/plumbline-yard-crane-1/angle_x/config");
    assert_eq!(entity["state_topic"], "yard/crane/1/angle");
    assert_eq!(entity["value_template"], "{{ value_json.angle_x_deg }}");
    assert_eq!(entity["unit_of_measurement"], "°");
    assert_eq!(entity["device"]["serial_number"], "1");
    let problem = document("homeassistant/binary_sensor/plumbline-yard-crane-1/status/config");
    assert_eq!(problem["device_class"], "problem");
    kill(bridge);
    until("the last will", || {
        subscriber.collect(&mut all);
        all.newest["yard/crane/bridge/availability"] == "offline"
    });
    // The end by SIGTERM says it for the sensors too.
    let bridge = start(&sensor, folder.path(), &format!("--mqtt {}", broker.url()));
    until("the next connection", || {
        subscriber.collect(&mut all);
        all.newest["yard/crane/bridge/availability"] == "online"
    });
    terminate(&bridge);
    let output = bridge.wait_with_output().expect("the program ends");
    assert!(output.status.success(), "{output:?}");
    until("the end of the sensor", || {
        subscriber.collect(&mut all);
        all.newest["yard/crane/1/availability"] == "offline"
    });
}

#[test]
fn password_and_certificate_that_the_broker_does_not_take_end_the_bridge() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some(broker) = Mosquitto::start(folder.path(), &["password", "tls"]) else {
        return;
    };
    let sensor = sensor();
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(
        path("good.toml"),
        "username = \"crane\"\npassword = \"right\"\n",
    )
    .expect("a file");
    std::fs::write(
        path("bad.toml"),
        "username = \"crane\"\npassword = \"secret\"\n",
    )
    .expect("a file");
    let (good, bad, ca, other) = (
        path("good.toml"),
        path("bad.toml"),
        path("ca.pem"),
        path("other.pem"),
    );
    let (url, plain) = (broker.url(), broker.url().replace("mqtts", "mqtt"));
    for (words, code, part) in [
        (
            format!("--mqtt {url} --ca {ca} --credentials {good}"),
            None,
            "connected with mqtts://localhost",
        ),
        (
            format!("--mqtt {url} --ca {ca} --credentials {bad}"),
            Some(4),
            "refuses user or password",
        ),
        (
            format!("--mqtt {url} --ca {other} --credentials {good}"),
            Some(4),
            "is not accepted",
        ),
        (
            format!("--mqtt {url} --credentials {good}"),
            Some(4),
            "--ca",
        ),
        (
            format!("--mqtt {plain} --credentials {good}"),
            None,
            "next try in 1 s",
        ),
    ] {
        // The time is only a limit for a test that fails.
        let words = format!("--seconds 120 {words}");
        let mut bridge = start(&sensor, folder.path(), &words);
        let notes = noted(&mut bridge, part);
        match code {
            Some(_) => {
                let status = bridge.wait().expect("the program ends");
                assert_eq!(status.code(), code, "{words}: {notes}");
            }
            None => kill(bridge),
        }
        assert!(!notes.contains("secret"), "{notes}");
    }
}

#[test]
fn broker_that_wants_a_certificate_takes_only_one_of_its_authority() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some(broker) = Mosquitto::start(folder.path(), &["tls", "certificate"]) else {
        return;
    };
    let sensor = sensor();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let own = |name: &str| {
        let (certificate, key) = (path(&format!("{name}.pem")), path(&format!("{name}.key")));
        format!("--certificate {certificate} --key {key}")
    };
    for (words, code, part) in [
        (own("client"), None, "connected with mqtts://localhost"),
        (own("other"), Some(4), "check --certificate and --key"),
        (String::new(), Some(4), "check --certificate and --key"),
    ] {
        let words = format!(
            "--seconds 120 --mqtt {} --ca {} {words}",
            broker.url(),
            path("ca.pem")
        );
        let mut bridge = start(&sensor, folder.path(), words.trim());
        let notes = noted(&mut bridge, part);
        match code {
            Some(_) => {
                let status = bridge.wait().expect("the program ends");
                assert_eq!(status.code(), code, "{words}: {notes}");
            }
            None => kill(bridge),
        }
    }
}

#[test]
fn pauses_grow_with_a_broker_that_accepts_each_connection_and_closes_it() {
    const ACCEPTED: &[u8] = &[0x20, 2, 0, 0];
    let folder = tempfile::tempdir().expect("a folder");
    let broker = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let url = format!("mqtt://{}", broker.local_addr().expect("an address"));
    std::thread::spawn(move || {
        for mut client in broker.incoming().flatten() {
            // The bridge can be killed at any time.
            let _ = client.read(&mut [0; 512]);
            let _ = client.write_all(ACCEPTED);
        }
    });
    let sensor = sensor();
    // The time is only a limit for a test that fails.
    let mut bridge = start(
        &sensor,
        folder.path(),
        &format!("--seconds 120 --mqtt {url}"),
    );
    noted(&mut bridge, "next try in 4 s");
    kill(bridge);
}

#[test]
fn wrong_option_of_a_bridge_ends_it_before_the_search() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("a file");
        path.display().to_string()
    };
    let (key, unknown) = (file("a.pem", "nonsense"), file("a.toml", "user = \"a\"\n"));
    let number = file("b.toml", "username = \"a\"\npassword = 4711\n");
    for (words, code) in [
        ("bridge".to_owned(), "no-destination"),
        ("bridge --mqtt broker".to_owned(), "bad-url"),
        (
            "bridge --mqtt mqtt://a:b@broker".to_owned(),
            "secret-in-url",
        ),
        (
            "bridge --mqtt mqtt://broker --site a/b".to_owned(),
            "bad-topic",
        ),
        (
            format!("bridge --mqtt mqtt://broker --site {}", "s".repeat(101)),
            "bad-topic",
        ),
        (
            "bridge --mqtt mqtt://broker --ca missing.pem".to_owned(),
            "no-tls",
        ),
        (
            "bridge --mqtt mqtts://broker --ca missing.pem".to_owned(),
            "no-file",
        ),
        (
            format!("bridge --mqtt mqtts://broker --ca {key}"),
            "bad-file",
        ),
        (
            format!("bridge --mqtt mqtt://broker --credentials {unknown}"),
            "bad-file",
        ),
        (
            format!("bridge --mqtt mqtt://broker --credentials {number}"),
            "bad-file",
        ),
    ] {
        let output = plumbline("demo:jn2101", &format!("--json {words}"));
        let document: Value = serde_json::from_slice(&output.stdout).expect("one document");
        assert_eq!(document["error"]["code"], code, "{words}: {document}");
        assert!(
            !document.to_string().contains("4711"),
            "the password: {document}"
        );
    }
}

#[test]
fn agopengps_gets_the_roll_and_its_end_when_the_bus_is_lost() {
    const LEVEL: &[u8] = &[0x80, 0x81, 0x79, 0xD3, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0x54];
    const CLOSED: &[u8] = &[0x80, 0x81, 0x7C, 0xD4, 2, 1, 0, 0x53];
    let folder = tempfile::tempdir().expect("a folder");
    let sensor = sensor();
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    socket
        .set_read_timeout(Some(Duration::from_secs(60)))
        .expect("a time-out");
    let to = socket.local_addr().expect("an address");
    let words = format!("--every 50 --agopengps imu --agopengps-to {to}");
    let bridge = start(&sensor, folder.path(), &words);
    let mut bytes = [0; 64];
    let mut next = || {
        let length = socket.recv(&mut bytes).expect("a message");
        bytes[..length].to_vec()
    };
    for _ in 0..3 {
        assert_eq!(next(), LEVEL);
    }
    drop(sensor);
    while let message = next()
        && message != CLOSED
    {
        assert_eq!(message, LEVEL);
    }
    let output = bridge.wait_with_output().expect("the program ends");
    assert_eq!(output.status.code(), Some(4), "{output:?}");
}
