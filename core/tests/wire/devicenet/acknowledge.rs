//! DeviceNet: the acknowledge handler: repetitions of COS and cyclic messages, and what ends them.

use super::io::{establish, producing, times};
use crate::tester::devicenet::{LevelTester, allocated};

/// Sets the timer in ms and the number of retries.
fn set_handler(tester: &mut LevelTester, timer: u16, retries: u8) {
    let timer = format!("{:04X}", timer.swap_bytes());
    let response = tester.explicit(&format!("102B0101{timer}"));
    assert_eq!(response, format!("90{timer}"));
    assert_eq!(tester.explicit(&format!("102B0102{retries:02X}")), "90");
}

#[test]
fn message_without_acknowledge_is_repeated_as_often_as_set() {
    let mut tester = producing(0x10, 0);
    assert_eq!(times(&tester.wait_text(100)), [16], "as delivered");
    for (number, (timer, retries)) in [
        (16, 1),
        (16, 0),
        (16, 3),
        (1, 5),
        (50, 1),
        (50, 3),
        (100, 2),
        (1000, 1),
        (16, 255),
        (16, 1),
    ]
    .into_iter()
    .enumerate()
    {
        set_handler(&mut tester, timer, retries);
        let x = 2000 + number as i32;
        tester.force_milli(x, -567);
        let message = format!("343#{:04X}C9FD", (x as u16).swap_bytes());
        assert_eq!(tester.sent_text(), [message.as_str()]);
        let repeated = tester.wait_text(9000);
        assert!(repeated.iter().all(|(_, text)| *text == message));
        let expected: Vec<u64> = (1..=u64::from(retries))
            .map(|it| it * u64::from(timer))
            .collect();
        assert_eq!(times(&repeated), expected, "{timer} {retries}");
    }
    assert_eq!(tester.explicit("0E050401"), "8E03");
}

#[test]
fn acknowledge_ends_the_repetitions() {
    let mut tester = producing(0x10, 0);
    tester.wait(100);
    set_handler(&mut tester, 50, 3);
    for repetitions in 0..3 {
        tester.force_milli(repetitions, 0);
        assert_eq!(tester.sent_text().len(), 1);
        let wait = 50 * repetitions as u64;
        assert_eq!(tester.wait_text(wait + 49).len(), repetitions as usize);
        tester.ignores("41A#");
        assert_eq!(tester.wait_text(1000), []);
    }
    tester.ignores("41A#");
    assert_eq!(tester.wait_text(1000), [], "without a message");
    // With data, of another node, remote: they are no acknowledges.
    tester.force_milli(9, 0);
    assert_eq!(tester.sent_text().len(), 1);
    for text in ["41A#00", "412#", "41A#R", "0000041A#"] {
        tester.ignores(text);
    }
    assert_eq!(times(&tester.wait_text(1000)), [50, 100, 150]);
}

#[test]
fn cyclic_message_is_repeated_between_its_periods_until_it_is_acknowledged() {
    let mut tester = allocated(0x20);
    tester.set_rate(1, 0);
    establish(&mut tester, 200);
    set_handler(&mut tester, 60, 1);
    tester.wait(199);
    assert_eq!(times(&tester.wait_text(600)), [1, 61, 201, 261, 401, 461]);
    tester.wait(1);
    for _ in 0..10 {
        tester.ignores("41A#");
        assert_eq!(times(&tester.wait_text(200)), [200]);
    }
}

#[test]
fn message_without_acknowledges_is_sent_once() {
    for choice in [0x50, 0x52, 0x60] {
        let cyclic = choice & 0x20 != 0;
        let mut tester = producing(choice, if cyclic { 100 } else { 0 });
        for x in [1, 2, 1] {
            tester.force_milli(x, 0);
            if !cyclic {
                let message = format!("343#{:04X}0000", (x as u16).swap_bytes());
                assert_eq!(tester.sent_text(), [message]);
            }
            tester.ignores("41A#");
            let expected = if cyclic { &[100][..] } else { &[] };
            assert_eq!(times(&tester.wait_text(100)), expected);
        }
    }
}

#[test]
fn change_during_the_repetitions_replaces_the_message() {
    let mut tester = producing(0x10, 0);
    tester.wait(100);
    set_handler(&mut tester, 80, 2);
    tester.force_milli(1, 0);
    assert_eq!(tester.sent_text(), ["343#01000000"]);
    tester.wait(20);
    tester.force_milli(2, 0);
    assert_eq!(tester.sent_text(), ["343#02000000"]);
    let repeated = tester.wait_text(1000);
    assert_eq!(times(&repeated), [80, 160]);
    assert!(repeated.iter().all(|(_, text)| text == "343#02000000"));
}
