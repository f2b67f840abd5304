//! The virtual sensor as its users meet it: the program's lines, files and exit codes, and clients that misbehave.

mod process;

use process::client::{BOOT_UP, Client, POLL, REPLY};
use process::sensor::{PATIENCE, Sensor, fails};
use std::fs;
use std::io::{Read, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Long enough for what must not come.
const QUIET: Duration = Duration::from_millis(200);

const BEL: &str = "\x07";

/// A path for a file of this test, which is not there yet.
fn new_path(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    // Fails when it is not there.
    let _ = fs::remove_file(&path);
    path
}

fn text(path: &std::path::Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}

/// Shortens reads, so that silence can be noticed.
fn impatient(client: &Client<std::net::TcpStream>) {
    client
        .stream
        .set_read_timeout(Some(Duration::from_millis(20)))
        .expect("a socket");
}

#[test]
fn nothing_is_said_before_the_channel_is_open() {
    let sensor = Sensor::start(&[]);
    let mut silent = Client::connect(&sensor);
    let mut talker = Client::awake(&sensor);
    talker.poll();
    impatient(&silent);
    assert_eq!(silent.next_within(QUIET), None);
    silent.expect("O", "");
    talker.poll();
    assert_eq!(silent.find("t300"), POLL);
    assert!(silent.find("t301").starts_with(REPLY));
    silent.say("C");
    silent.find("");
    talker.poll();
    assert_eq!(silent.next_within(QUIET), None);
}

#[test]
fn clients_share_one_bus() {
    let sensor = Sensor::start(&[]);
    let mut first = Client::awake(&sensor);
    let mut second = Client::open(&sensor);
    first.expect("T1ABCDEF02BEEF", "Z");
    assert_eq!(second.next().as_deref(), Some("T1ABCDEF02BEEF"));
    second.expect("r7FF8", "z");
    assert_eq!(first.next().as_deref(), Some("r7FF8"));
    first.poll();
    assert_eq!(second.next().as_deref(), Some(POLL));
    assert!(second.next().is_some_and(|line| line.starts_with(REPLY)));
}

#[test]
fn the_tilt_is_what_the_sensor_tells() {
    let sensor = Sensor::start(&["--scene", "tilt=12.34,-5.67"]);
    let mut client = Client::awake(&sensor);
    let end = Instant::now() + PATIENCE;
    loop {
        let (x, y) = client.poll();
        if (x - 1234).abs() <= 1 && (y + 567).abs() <= 1 {
            break;
        }
        assert!(Instant::now() < end, "{x} {y}");
    }
}

#[test]
fn a_malformed_line_gets_bel_and_reaches_nobody() {
    let sensor = Sensor::start(&[]);
    let mut witness = Client::awake(&sensor);
    let mut client = Client::open(&sensor);
    for line in [
        "t1239112233445566778899",
        "t12321",
        "x",
        "\n",
        "O\n",
        "t8000",
        "\0",
        "t1230 ",
        "t12",
    ] {
        client.expect(line, BEL);
    }
    client.expect(&"t".repeat(100_000), BEL);
    client.expect("t124101", "z");
    assert_eq!(witness.next().as_deref(), Some("t124101"));
}

#[test]
fn a_client_may_vanish_in_the_middle_of_a_line() {
    let sensor = Sensor::start(&[]);
    let mut witness = Client::awake(&sensor);
    for _ in 0..20 {
        let mut client = Client::connect(&sensor);
        client.stream.write_all(b"O\rt123").expect("it listens");
        drop(client);
    }
    witness.poll();
    impatient(&witness);
    assert_eq!(witness.next_within(QUIET), None);
}

#[test]
fn what_a_client_sends_before_it_goes_is_sent() {
    let sensor = Sensor::start(&[]);
    let mut witness = Client::awake(&sensor);
    for ending in ["", "C\r"] {
        let mut client = Client::connect(&sensor);
        let lines = format!("O\rt700101\rt700102\rt700103\r{ending}");
        client
            .stream
            .write_all(lines.as_bytes())
            .expect("it listens");
        drop(client);
        for frame in ["t700101", "t700102", "t700103"] {
            assert_eq!(witness.next().as_deref(), Some(frame));
        }
    }
}

#[test]
fn a_client_that_reconnects_is_no_power_cycle() {
    let sensor = Sensor::start(&[]);
    drop(Client::awake(&sensor));
    let mut client = Client::open(&sensor);
    client.say(POLL);
    assert_eq!(client.next().as_deref(), Some("z"));
    assert!(client.next().is_some_and(|line| line.starts_with(REPLY)));
}

#[test]
fn answers_do_not_wait_for_anything() {
    let sensor = Sensor::start(&[]);
    let mut client = Client::awake(&sensor);
    let mut times: Vec<Duration> = (0..50)
        .map(|_| {
            let start = Instant::now();
            client.poll();
            start.elapsed()
        })
        .collect();
    times.sort();
    assert!(
        times[25] < Duration::from_millis(10),
        "median {:?}",
        times[25]
    );
}

#[test]
fn a_client_that_never_reads_does_not_hold_up_the_others() {
    let sensor = Sensor::start(&[]);
    let mut reader = Client::awake(&sensor);
    let mut idle = Client::open(&sensor);
    let mut greedy = Client::open(&sensor);
    // Its answers alone fill every buffer; in the end it is dropped.
    let question = b"V\r".repeat(2000);
    greedy
        .stream
        .set_write_timeout(Some(PATIENCE))
        .expect("a socket");
    let flood = std::thread::spawn(move || {
        let end = Instant::now() + 3 * PATIENCE;
        while greedy.stream.write_all(&question).is_ok() {
            assert!(Instant::now() < end, "it was not dropped");
        }
    });
    while !flood.is_finished() {
        let start = Instant::now();
        reader.poll();
        assert!(start.elapsed() < Duration::from_secs(5));
    }
    flood.join().expect("it was dropped");
    reader.poll();
    // The other one that has not read so far was only slow.
    impatient(&idle);
    while idle.next_within(QUIET).is_some() {}
    reader.poll();
    assert_eq!(idle.next().as_deref(), Some(POLL));
}

#[cfg(target_os = "linux")]
#[test]
fn a_line_without_end_costs_no_memory() {
    let sensor = Sensor::start(&[]);
    let mut client = Client::open(&sensor);
    let before = sensor.memory();
    let piece = vec![b't'; 1 << 20];
    for _ in 0..64 {
        client.stream.write_all(&piece).expect("it is swallowed");
    }
    client.expect("", BEL);
    let after = sensor.memory();
    assert!(after < before + 16 * 1024, "{before} KiB, then {after} KiB");
}

#[test]
fn a_fixed_bus_rate_leaves_out_who_is_set_to_another() {
    let sensor = Sensor::start(&["--bus-rate", "125"]);
    let mut right = Client::connect(&sensor);
    right.expect("S4", "");
    right.expect("O", "");
    right.wake();
    let mut wrong = Client::connect(&sensor);
    wrong.expect("S6", "");
    wrong.expect("O", "");
    wrong.expect("t300100", "z");
    right.poll();
    impatient(&wrong);
    impatient(&right);
    assert_eq!(wrong.next_within(QUIET), None);
    assert_eq!(right.next_within(QUIET), None);
}

#[test]
fn without_a_bus_rate_the_clients_rates_mean_nothing() {
    let sensor = Sensor::start(&[]);
    drop(Client::awake(&sensor));
    for setting in ["S0", "S8", "s031C"] {
        let mut client = Client::connect(&sensor);
        client.expect(setting, "");
        client.expect("O", "");
        client.poll();
    }
}

#[test]
fn the_log_is_candumps_and_can_be_followed() {
    let path = new_path("followed.log");
    let sensor = Sensor::start(&["--log", text(&path)]);
    let mut client = Client::awake(&sensor);
    client.poll();
    client.expect("R123456788", "Z");
    client.poll();
    // It is written before the client hears of it, or just after.
    let end = Instant::now() + PATIENCE;
    let log = loop {
        let log = fs::read_to_string(&path).expect("it is there");
        if log.lines().rev().take(2).any(|line| line.ends_with(" R")) && log.contains("#R8") {
            break log;
        }
        assert!(Instant::now() < end, "{log}");
    };
    let mut last = 0.0;
    for line in log.lines() {
        let fields: Vec<&str> = line.split(' ').collect();
        let [time, "can0", frame, direction] = fields[..] else {
            panic!("{line}");
        };
        let time = time
            .strip_prefix('(')
            .and_then(|time| time.strip_suffix(')'))
            .expect("(time)");
        assert_eq!(
            time.split_once('.').map(|(_, fraction)| fraction.len()),
            Some(6),
            "{line}"
        );
        let time: f64 = time.parse().expect("a number");
        assert!(time >= last, "{line}");
        last = time;
        let expected = if frame.starts_with("301#") { "R" } else { "T" };
        assert_eq!(direction, expected, "{line}");
    }
    let now = std::time::UNIX_EPOCH
        .elapsed()
        .expect("a clock")
        .as_secs_f64();
    assert!((now - last).abs() < 60.0);
    assert!(log.contains(" can0 300#00 T\n") && log.contains(" can0 12345678#R8 T\n"));
    assert!(log.contains(" can0 301#FF"));
}

#[test]
fn a_save_is_in_the_store_file() {
    let path = new_path("saved.store");
    let sensor = Sensor::start(&["--store", text(&path)]);
    let mut client = Client::awake(&sensor);
    client.say("t300550534156" /* 50h 'S' 'A' 'V' */);
    client.find(BEL);
    client.say("t30055053415645" /* 50h 'S' 'A' 'V' 'E' */);
    client.find("t301250");
    let stored = fs::read(&path).expect("it is there");
    assert!(stored.iter().any(|byte| *byte != 0xFF));
    drop(sensor);
    // The same file again.
    let sensor = Sensor::start(&["--store", text(&path)]);
    Client::awake(&sensor).poll();
}

/// It ends with this exit code and one sentence that contains these words.
#[track_caller]
fn assert_fails(arguments: &[&str], code: i32, words: &[&str]) {
    let output = fails(arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
    for word in words {
        assert!(
            error.contains(word),
            "{arguments:?}: {error:?} lacks {word:?}"
        );
    }
    assert!(
        !error.contains("panicked") && !error.contains("RUST_BACKTRACE"),
        "{error}"
    );
    assert!(output.stdout.is_empty(), "{arguments:?}");
}

#[test]
fn a_wrong_command_line_is_told_what_would_be_right() {
    assert_fails(&["--model", "is3"], 2, &["is3", "is1", "is2"]);
    let rates = "10, 20, 50, 62.5, 100, 125, 250, 500, 800, 1000";
    for rate in ["33", "0", "fast", "nan", "-125"] {
        assert_fails(&[&format!("--bus-rate={rate}")], 2, &[rates]);
    }
    assert_fails(&["--scene", "tilt=1"], 2, &["tilt=X,Y"]);
    assert_fails(&["--scene", "tilt=80,80"], 2, &["80,80", "sines"]);
    assert_fails(&["--scene", "tilt=91,0"], 2, &["-90 to 90"]);
    assert_fails(&["--nonsense"], 2, &["--nonsense"]);
}

#[test]
fn files_that_do_not_work_are_named() {
    let scene = new_path("bad.csv");
    fs::write(&scene, "t_s,ax_g,ay_g,az_g\n0,0,0,1\n0,0,0,1\n").expect("a folder");
    let place = format!("{}:3: ", text(&scene));
    assert_fails(
        &["--scene", text(&scene)],
        1,
        &[&place, "the time must rise"],
    );
    let nowhere = new_path("no").join("such");
    let nowhere = text(&nowhere);
    assert_fails(&["--scene", nowhere], 1, &["cannot read", nowhere]);
    assert_fails(&["--store", nowhere], 1, &["cannot use the store", nowhere]);
    assert_fails(&["--log", nowhere], 1, &["cannot write the log", nowhere]);
    let foreign = new_path("foreign.store");
    fs::write(&foreign, "a letter").expect("a folder");
    assert_fails(
        &["--store", text(&foreign)],
        1,
        &["cannot use the store", text(&foreign)],
    );
    assert_eq!(fs::read(&foreign).expect("it is there"), b"a letter");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_ends_the_log_with_a_sentence() {
    let mut sensor = Sensor::start(&["--log", "/dev/full"]);
    let mut client = Client::open(&sensor);
    client.say("t1230");
    assert_eq!(sensor.exit_code(), Some(1));
    let errors = sensor.errors();
    assert!(
        errors.starts_with("virtual-sensor: cannot write the log /dev/full: "),
        "{errors}"
    );
}

#[test]
fn a_port_that_is_taken_is_named() {
    let sensor = Sensor::start(&[]);
    let address = format!("127.0.0.1:{}", sensor.port);
    assert_fails(&["--listen", &address], 1, &["cannot listen at", &address]);
    assert_fails(&["--listen", "nonsense"], 1, &["cannot listen at nonsense"]);
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_it_cleanly_and_nothing_but_the_address_was_printed() {
    let mut sensor = Sensor::start(&[]);
    let mut client = Client::awake(&sensor);
    client.poll();
    assert_eq!(sensor.interrupt(), Some(0));
    assert_eq!(sensor.rest(), Vec::<String>::new());
    assert_eq!(sensor.errors(), "");
    let mut rest = Vec::new();
    // The connection is over, one way or the other.
    let _ = client.stream.read_to_end(&mut rest);
    assert!(rest.is_empty());
}

#[test]
fn python_can_works_with_it() {
    let log = new_path("python-can.log");
    let mut arguments = vec!["--log", text(&log)];
    if cfg!(unix) {
        arguments.push("--pty");
    }
    let mut sensor = Sensor::start(&arguments);
    let socket = sensor.channel();
    let mut script = vec![
        "--log".into(),
        text(&log).to_owned(),
        socket.clone(),
        socket,
    ];
    if cfg!(unix) {
        let line = sensor.line();
        script.push(
            line.strip_prefix("slcan ")
                .expect("slcan /dev/...")
                .to_owned(),
        );
    }
    let script: Vec<&str> = script.iter().map(String::as_str).collect();
    process::python::run("smoke.py", &["can", "serial"], &script);
}

#[cfg(unix)]
mod terminals {
    use super::*;
    use rustix::fs::{Mode, OFlags};
    use rustix::process::{Pid, Signal, kill_process};
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    use rustix::termios::{LocalModes, OutputModes, tcgetattr};
    use std::fs::File;
    use std::process::Stdio;

    fn open(path: &str) -> Client<File> {
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let terminal = rustix::fs::open(path, flags, Mode::empty()).expect("it is there");
        Client::on(File::from(terminal))
    }

    fn sensor_with_terminal(arguments: &[&str]) -> (Sensor, String) {
        let mut sensor = Sensor::start(&[arguments, &["--pty"]].concat());
        let line = sensor.line();
        let path = line
            .strip_prefix("slcan ")
            .expect("slcan /dev/...")
            .to_owned();
        (sensor, path)
    }

    #[test]
    fn a_terminal_is_raw_and_speaks_the_same() {
        let (sensor, path) = sensor_with_terminal(&[]);
        let mut witness = Client::awake(&sensor);
        let mut client = open(&path);
        let settings = tcgetattr(&client.stream).expect("a terminal");
        assert!(
            !settings
                .local_modes
                .intersects(LocalModes::ECHO | LocalModes::ICANON | LocalModes::ISIG)
        );
        assert!(!settings.output_modes.contains(OutputModes::OPOST));
        client.expect("C", "");
        client.expect("V", "V1010");
        client.expect("t1230", BEL);
        client.expect("O", "");
        client.expect("\x03", BEL);
        client.expect("\n", BEL);
        client.poll();
        assert_eq!(witness.next().as_deref(), Some(POLL));
        witness.find(REPLY);
        witness.expect("t1230", "z");
        assert_eq!(client.next().as_deref(), Some("t1230"));
    }

    #[test]
    fn a_terminal_can_be_opened_again() {
        let (sensor, path) = sensor_with_terminal(&[]);
        let mut witness = Client::awake(&sensor);
        for _ in 0..5 {
            let mut client = open(&path);
            // The channel of the client before is closed.
            client.expect("t1230", BEL);
            client.expect("O", "");
            client.poll();
            // Left unread, in the middle of a line and without C.
            client.say("V");
            client.stream.write_all(b"t12").expect("a terminal");
            drop(client);
            std::thread::sleep(Duration::from_millis(100));
            // Nobody is there to hear this one.
            witness.poll();
        }
        impatient(&witness);
        while let Some(line) = witness.next_within(QUIET) {
            assert!(!line.starts_with(BOOT_UP));
        }
    }

    #[test]
    fn what_is_written_and_left_alone_is_done() {
        let (sensor, path) = sensor_with_terminal(&[]);
        let mut witness = Client::awake(&sensor);
        open(&path)
            .stream
            .write_all(b"O\rt7E6155\r")
            .expect("a terminal");
        assert_eq!(witness.next().as_deref(), Some("t7E6155"));
    }

    #[test]
    fn a_terminal_client_that_never_reads_does_not_hold_up_the_others() {
        let (sensor, path) = sensor_with_terminal(&[]);
        let mut reader = Client::awake(&sensor);
        let mut idle = open(&path);
        idle.say("O");
        // More than a terminal's buffers hold.
        let frames = 10_000;
        let mut sender = Client::open(&sensor);
        for _ in 0..frames / 100 {
            sender
                .stream
                .write_all("t12381122334455667788\r".repeat(100).as_bytes())
                .expect("it listens");
        }
        reader.poll();
        drop(idle);
        std::thread::sleep(Duration::from_millis(100));
        let mut next = open(&path);
        next.expect("V", "V1010");
        drop(sender);
        reader.poll();
    }

    #[test]
    fn on_a_terminal_a_line_tells_what_it_is_doing() {
        let screen = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)
            .expect("a terminal");
        grantpt(&screen).expect("a terminal");
        unlockpt(&screen).expect("a terminal");
        let path = ptsname(&screen, Vec::new()).expect("a terminal");
        let output = rustix::fs::open(
            path.as_c_str(),
            OFlags::RDWR | OFlags::NOCTTY,
            Mode::empty(),
        )
        .expect("it is there");
        let before = format!("{:?}", tcgetattr(&screen).expect("a terminal"));
        let mut child = process::sensor::program()
            .args(["--listen", "127.0.0.1:0", "--scene", "tilt=30,-10"])
            .stdin(Stdio::null())
            .stdout(output)
            .spawn()
            .expect("the program starts");
        let mut screen = File::from(screen);
        let mut shown = String::new();
        let end = Instant::now() + PATIENCE;
        while !(shown.contains("clients 0")
            && shown.contains("30.00°")
            && shown.contains("-10.00°"))
        {
            assert!(Instant::now() < end, "{shown}");
            let mut buffer = [0; 4096];
            let length = screen.read(&mut buffer).expect("a terminal");
            shown += &String::from_utf8_lossy(&buffer[..length]);
        }
        assert!(shown.starts_with("slcan socket://127.0.0.1:"));
        assert!(shown.contains("is2 ") && shown.contains("run") && shown.contains("kbit/s"));
        kill_process(Pid::from_child(&child), Signal::INT).expect("it runs");
        assert_eq!(child.wait().expect("a child").code(), Some(0));
        assert_eq!(
            format!("{:?}", tcgetattr(&screen).expect("a terminal")),
            before
        );
        let mut rest = [0; 65536];
        let length = screen.read(&mut rest).expect("a terminal");
        assert!(rest[..length].ends_with(b"\n"));
        // Whatever was switched off in a line is on again at its end.
        shown += &String::from_utf8_lossy(&rest[..length]);
        assert_eq!(
            shown.matches("\x1b[?7l").count(),
            shown.matches("\x1b[?7h").count()
        );
    }
}
