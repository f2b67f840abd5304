//! An adapter without listen-only mode: it takes part in the bus only after a yes.

use super::files::file;
use super::rig::Rig;
use adapter::Mode;

/// The modes in which the adapter was opened since the last call.
fn modes(rig: &Rig) -> Vec<Mode> {
    rig.modes.take()
}

fn without_listen_only() -> Rig {
    let mut rig = Rig::with("is2");
    rig.only_active = true;
    rig.says_yes = false;
    rig.witnessed();
    rig
}

#[test]
fn adapter_without_listen_only_mode_is_opened_for_listening_only_after_a_yes() {
    let mut rig = without_listen_only();
    let failed = (2, "no-listen-only".to_owned());
    assert_eq!(rig.fails("--rate 250 get"), failed);
    assert_eq!((modes(&rig), rig.witnessed().len()), (Vec::new(), 0));
    assert_eq!(rig.questions.len(), 1);
    assert!(rig.questions[0].contains("at 250 kbit/s"));
    rig.says_yes = true;
    let ended = rig.tool("--rate 250 get");
    assert_eq!(ended.code, 0, "{ended:?}");
    assert_eq!(rig.questions.len(), 2);
    let is_note = |line: &&str| line.contains("it acknowledges the messages of other devices");
    assert_eq!(ended.notes.lines().filter(is_note).count(), 1, "{ended:?}");
}

#[test]
fn adapter_without_listen_only_mode_is_asked_about_once() {
    let mut rig = Rig::with("tiltix080");
    rig.only_active = true;
    // A slave of another master is listened to twice: to find it, and for its angles.
    let master = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(master, None, false);
    let response = plumbline::can::Frame::data(plumbline::can::standard(0x3FF), &[0; 8]);
    rig.cyclic = response.map(|response| (50, response));
    rig.tool("--mac 63 --product tiltix080 watch --cyclic --every 50 --seconds 1");
    let asked = rig.questions.iter();
    let asked = asked.filter(|question| question.contains("listen-only"));
    assert_eq!(asked.count(), 1, "{:?}", rig.questions);
}

#[test]
fn commands_that_need_no_listening_ask_nothing_and_scan_and_log_are_refused() {
    let mut rig = without_listen_only();
    rig.done("--rate 250 --id 300 get");
    assert_eq!(rig.questions.len(), 0);
    modes(&rig);
    rig.says_yes = true;
    let log = format!(
        "--rate 250 log {} --seconds 1",
        file("active.log").display()
    );
    for (command, step) in [
        ("scan", "no listen-only mode"),
        ("--rate 250 scan", "no listen-only mode"),
        (&log, "use another adapter"),
    ] {
        let failed = (4, "no-listen-only".to_owned());
        assert_eq!(rig.fails(command), failed, "{command}");
        assert_eq!(modes(&rig), [], "{command}");
        let ended = rig.tool(command);
        assert!(ended.notes.contains(step), "{ended:?}");
    }
    rig.done("scan --active");
}
