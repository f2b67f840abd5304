//! Clients on TCP, with correct and incorrect behaviour.

use crate::process::client::{BEL, Client, POLL, REPLY};
use crate::process::sensor::{PATIENCE, Sensor};
use std::io::Write;
use std::time::Instant;

#[test]
fn server_sends_nothing_before_channel_is_open() {
    let sensor = Sensor::start(&[]);
    let mut silent = Client::connect(&sensor);
    let mut talker = Client::awake(&sensor);
    talker.poll();
    // The answer comes after all that was sent before.
    silent.expect("V", "V1010");
    silent.expect("O", "");
    talker.poll();
    assert_eq!(silent.find("t300"), POLL);
    assert!(silent.find("t301").starts_with(REPLY));
    silent.expect("C", "");
    talker.poll();
    silent.expect("V", "V1010");
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
fn malformed_line_gets_bel_and_is_not_sent() {
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
fn client_may_disconnect_within_line() {
    let sensor = Sensor::start(&[]);
    let mut witness = Client::awake(&sensor);
    for _ in 0..20 {
        let mut client = Client::connect(&sensor);
        client.stream.write_all(b"O\rt123").expect("it listens");
        client.leave();
    }
    witness.expect_nothing();
}

#[test]
fn frames_of_disconnected_client_are_sent() {
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
fn reconnect_of_client_does_not_restart_sensor() {
    let sensor = Sensor::start(&[]);
    drop(Client::awake(&sensor));
    let mut client = Client::open(&sensor);
    client.say(POLL);
    assert_eq!(client.next().as_deref(), Some("z"));
    assert!(client.next().is_some_and(|line| line.starts_with(REPLY)));
}

#[test]
fn client_that_never_reads_does_not_block_others() {
    let sensor = Sensor::start(&[]);
    let mut reader = Client::awake(&sensor);
    let mut idle = Client::open(&sensor);
    let mut greedy = Client::open(&sensor);
    // Its answers alone fill every buffer, so it is dropped.
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
        reader.poll();
    }
    flood.join().expect("it was dropped");
    reader.poll();
    // The other client, which has not read so far, is only slow.
    reader.settle();
    idle.catch_up();
    reader.poll();
    assert_eq!(idle.next().as_deref(), Some(POLL));
}

#[cfg(target_os = "linux")]
#[test]
fn endless_line_uses_no_memory() {
    let sensor = Sensor::start(&[]);
    let mut client = Client::open(&sensor);
    let before = sensor.memory();
    let piece = vec![b't'; 1 << 20];
    for _ in 0..64 {
        client.stream.write_all(&piece).expect("it is accepted");
    }
    client.expect("", BEL);
    let after = sensor.memory();
    assert!(after < before + 16 * 1024, "{before} KiB, then {after} KiB");
}

#[test]
fn fixed_bus_rate_excludes_client_with_other_rate() {
    let sensor = Sensor::start(&["--bus-rate", "125"]);
    let mut right = Client::connect(&sensor);
    right.expect("S4", "");
    right.expect("O", "");
    right.wake();
    let mut wrong = Client::connect(&sensor);
    wrong.expect("S6", "");
    wrong.expect("O", "");
    wrong.expect("t300100", "z");
    right.expect_nothing();
    wrong.expect("V", "V1010");
}

#[test]
fn rates_of_clients_have_no_effect_without_bus_rate() {
    let sensor = Sensor::start(&[]);
    drop(Client::awake(&sensor));
    for setting in ["S0", "S8", "s031C"] {
        let mut client = Client::connect(&sensor);
        client.expect(setting, "");
        client.expect("O", "");
        client.poll();
    }
}
