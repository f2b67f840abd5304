//! `calibrate`: a shell script is the command of the log. It prints 3 s of the position in a file again and again, and the answers
//! to the questions turn the sensor.

use super::files::file;
use bench::{Flash, Geometry, STORE_BUFFER};
use clap::Parser;
use plumbline::measure::{I32x3, ONE_G};
use plumbline::model::catalog::find;
use plumbline::store::Store;
use plumbline_tool::cli::Cli;
use plumbline_tool::command::run_with;
use plumbline_tool::failure::Failure;
use plumbline_tool::output::Terminal;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::{Duration, Instant};

/// The offset of the accelerometer in g.
const OFFSET: [f64; 3] = [0.02, -0.03, 0.05];

/// Its response to 1 g along each axis.
const RESPONSE: [[f64; 3]; 3] = [[1.02, 0.01, 0.0], [-0.01, 0.97, 0.02], [0.005, 0.0, 1.01]];

/// The raw acceleration in 10^-6 g with a side up.
fn raw(side: &str) -> [i32; 3] {
    let axis = ["x", "y", "z"].iter().position(|name| side.ends_with(name));
    let axis = axis.expect("an axis");
    let sign = if side.starts_with('-') { -1.0 } else { 1.0 };
    std::array::from_fn(|i| ((OFFSET[i] + sign * RESPONSE[axis][i]) * 1e6).round() as i32)
}

/// 3 s of the log at a temperature in 0.01 degC.
fn log(serial: u32, side: &str, temperature: i32) -> String {
    let [x, y, z] = raw(side);
    let mut text = format!("0.000012 [INFO ] serial number {serial}\nnot a message\n");
    for place in 0..600 {
        // Noise with a mean of 0.
        let noise = if place % 2 == 0 { 900 } else { -900 };
        let (x, y) = (x + noise, y - noise);
        text += &format!(
            "0.06 [DEBUG] acceleration {x} {y} {z} ug, {temperature} 0.01 degC (app.rs:330)\n"
        );
    }
    text
}

/// A unit on a bench: the sides to which it is turned, one after the other.
struct Board {
    serial: u32,
    temperature: i32,
    position: PathBuf,
    measurement: PathBuf,
    store: PathBuf,
}

/// The file to which the log adds a byte each time that it has printed a position.
fn count(position: &Path) -> PathBuf {
    position.with_extension("count")
}

/// Waits until the log has printed the position this many more times.
fn wait_for_prints(position: &Path, times: u64) {
    let path = count(position);
    let printed = || std::fs::metadata(&path).map_or(0, |own| own.len());
    let end = printed() + times;
    let start = Instant::now();
    while printed() < end {
        assert!(start.elapsed() < PATIENCE, "the log has ended");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// How long the log can take.
const PATIENCE: Duration = Duration::from_secs(60);

/// The end of a run.
#[derive(Debug)]
struct Ended {
    result: Result<(), Failure>,
    out: String,
    notes: String,
    questions: Vec<String>,
}

impl Board {
    fn new(name: &str) -> Self {
        Self {
            serial: 7,
            temperature: 25_10,
            position: file(&format!("calibrate-{name}.log")),
            measurement: file(&format!("calibrate-{name}.csv")),
            store: file(&format!("calibrate-{name}.bin")),
        }
    }

    /// Turns the unit.
    fn turn(&self, side: &str) {
        let part = self.position.with_extension("part");
        std::fs::write(&part, log(self.serial, side, self.temperature)).expect("a file");
        std::fs::rename(&part, &self.position).expect("a file");
    }

    /// Runs the program with a log. `answer` takes the question and its number, and turns the unit.
    fn run(&self, options: &[&str], answer: &mut dyn FnMut(&Self, &str, usize) -> bool) -> Ended {
        let script = format!(
            "while cat '{}' 2>/dev/null; do echo >>'{}'; sleep 0.02; done",
            self.position.display(),
            count(&self.position).display()
        );
        self.run_with(options, &["--", "sh", "-c", &script], answer)
    }

    fn run_with(
        &self,
        options: &[&str],
        log: &[&str],
        answer: &mut dyn FnMut(&Self, &str, usize) -> bool,
    ) -> Ended {
        let measurement = self.measurement.display().to_string();
        let mut all = vec!["plumbline", "calibrate", &measurement];
        all.extend(options);
        all.extend(log);
        let cli = Cli::try_parse_from(all).unwrap_or_else(|error| panic!("{error}"));
        let (mut out, mut notes, mut questions) = (Vec::new(), Vec::new(), Vec::new());
        let mut confirm = |question: &str| {
            questions.push(question.to_owned());
            answer(self, question, questions.len())
        };
        let mut terminal = Terminal {
            json: cli.options.json,
            out: &mut out,
            notes: &mut notes,
            confirm: &mut confirm,
            stopped: Rc::new(|| false),
            bar: None,
        };
        let result = run_with(&cli, &mut terminal, &mut |_| panic!("no adapter is needed"));
        Ended {
            result,
            out: String::from_utf8(out).expect("UTF-8"),
            notes: String::from_utf8(notes).expect("UTF-8"),
            questions,
        }
    }

    /// The options that write the store file.
    fn store_options(&self) -> [String; 4] {
        let store = self.store.display().to_string();
        ["--product".into(), "is2".into(), "--store".into(), store]
    }

    /// Turns the unit; the log does not tell its serial number.
    fn turn_untold(&self, side: &str) {
        let told = log(self.serial, side, self.temperature);
        let (_, untold) = told.split_once('\n').expect("lines");
        let part = self.position.with_extension("part");
        std::fs::write(&part, untold).expect("a file");
        std::fs::rename(&part, &self.position).expect("a file");
    }

    fn rows(&self) -> Vec<String> {
        let text = std::fs::read_to_string(&self.measurement).unwrap_or_default();
        text.lines().map(str::to_owned).collect()
    }
}

const SIDES: [&str; 6] = ["+z", "-z", "+x", "-x", "+y", "-y"];

/// Takes the position, and turns the unit to the next side.
fn take(board: &Board, question: &str, _: usize) -> bool {
    let place = SIDES.iter().position(|side| question.starts_with(side));
    let place = place.unwrap_or_else(|| panic!("{question}"));
    board.turn(SIDES[(place + 1) % 6]);
    true
}

/// The code of a run that must have failed.
#[track_caller]
fn code(ended: &Ended) -> (u8, &'static str) {
    let failure = ended.result.as_ref().expect_err("a failure");
    assert!(failure.message.len() > 20, "{failure}");
    (failure.kind.exit_code(), failure.code)
}

/// The store of a unit corrects the raw acceleration of each side.
#[track_caller]
fn assert_corrects(path: &Path, serial: u32, corrects: bool) {
    let flash = Flash::in_file(Geometry::STM32F103, path).expect("a store file");
    let owner = find("is2").expect("a product").owner(serial);
    let mut store = Store::<_, STORE_BUFFER>::open(flash, owner);
    let calibration = store.boot().calibration;
    for (axis, side) in ["+x", "+y", "+z"].iter().enumerate() {
        let g = |value: i32| (f64::from(value) * 1e-6 * f64::from(ONE_G)).round() as i32;
        let [x, y, z] = raw(side).map(g);
        let I32x3 { x, y, z } = calibration.apply(I32x3 { x, y, z }, 25_10);
        let is_right = [x, y, z].into_iter().enumerate().all(|(i, value)| {
            let expected = if i == axis { 1.0 } else { 0.0 };
            (f64::from(value) / f64::from(ONE_G) - expected).abs() < 2e-5
        });
        assert_eq!(is_right, corrects, "{side}: {x} {y} {z}");
    }
}

#[test]
fn six_positions_give_the_calibration_of_the_unit_in_the_log() {
    let board = Board::new("six");
    board.turn("+z");
    let options = board.store_options();
    let options: Vec<&str> = options.iter().map(String::as_str).collect();
    let ended = board.run(&options, &mut take);
    assert_eq!(ended.result, Ok(()), "{ended:?}");
    assert_eq!(ended.questions.len(), 6, "{ended:?}");
    for part in [
        "spread 0.00 mg",
        "z 1060.0 mg",
        "25.10 degC",
        "Take this position?",
    ] {
        assert!(ended.questions[0].contains(part), "{part}: {ended:?}");
    }
    assert!(
        ended
            .out
            .contains("offset  x 20.000 mg, y -30.000 mg, z 50.000 mg"),
        "{ended:?}"
    );
    assert!(
        ended.notes.contains("is2 with serial number 7"),
        "{ended:?}"
    );
    let rows = board.rows();
    let expected = [
        "up,ax_g,ay_g,az_g,temp_c",
        "# serial number 7",
        "+z,0.025000,-0.030000,1.060000,25.10",
        "-z,0.015000,-0.030000,-0.960000,25.10",
        "+x,1.040000,-0.020000,0.050000,25.10",
    ];
    assert_eq!(rows[..5], expected);
    assert_eq!(rows.len(), 8);
    assert_corrects(&board.store, 7, true);
    assert_corrects(&board.store, 8, false);
    // The complete file needs no log.
    let again = board.run_with(&["--json"], &[], &mut |_, _, _| panic!("no question"));
    let document: serde_json::Value = serde_json::from_str(&again.out).expect("a document");
    let offset = document["offset_mg"][1].as_f64().expect("a number");
    assert!((offset + 30.0).abs() < 1e-3, "{document}");
}

#[test]
fn position_that_was_stopped_is_not_taken_and_the_same_command_goes_on() {
    let board = Board::new("stopped");
    board.turn("+z");
    // Two positions are taken; the third one is measured again, then the user stops.
    let ended = board.run(&[], &mut |board, question, number| match number {
        1 | 2 => take(board, question, number),
        3 => false,
        4 => {
            assert_eq!(question, "Measure this position again?");
            true
        }
        _ => false,
    });
    assert_eq!(code(&ended), (2, "not-confirmed"));
    assert_eq!(ended.questions.len(), 6, "{ended:?}");
    assert_eq!(board.rows().len(), 4, "heading, serial number, two rows");
    // An incomplete file gives no calibration.
    let early = board.run_with(&[], &[], &mut |_, _, _| false);
    assert_eq!(code(&early), (2, "bad-file"));
    let ended = board.run(&[], &mut take);
    assert_eq!(ended.result, Ok(()), "{ended:?}");
    assert_eq!(ended.questions.len(), 4, "{ended:?}");
    assert!(ended.notes.contains("position 3 of 6"), "{ended:?}");
    assert_eq!(board.rows().len(), 8);
}

#[test]
fn six_positions_at_another_temperature_are_added() {
    let mut board = Board::new("warm");
    board.turn("+z");
    let ended = board.run(&[], &mut take);
    assert_eq!(ended.result, Ok(()), "{ended:?}");
    let ended = board.run(&[], &mut take);
    assert_eq!((ended.result, ended.questions.len()), (Ok(()), 0));
    board.temperature = 60_00;
    board.turn("+z");
    let ended = board.run(&[], &mut take);
    assert_eq!(
        (ended.result.clone(), ended.questions.len()),
        (Ok(()), 6),
        "{ended:?}"
    );
    assert_eq!(board.rows().len(), 14);
    // Another unit must not be mixed with it.
    board.serial = 8;
    board.turn("+z");
    let ended = board.run(&[], &mut take);
    assert_eq!(code(&ended), (2, "wrong-file"));
    assert_eq!(board.rows().len(), 14);
}

#[test]
fn log_without_serial_number_is_not_measured_into_the_file_of_a_unit() {
    let board = Board::new("untold");
    board.turn("+z");
    let stop_after_one = &mut |board: &Board, question: &str, number: usize| match number {
        1 => take(board, question, number),
        _ => false,
    };
    let ended = board.run(&[], stop_after_one);
    assert_eq!(code(&ended), (2, "not-confirmed"));
    board.turn_untold("-z");
    let ended = board.run(&[], &mut |_, question, _| panic!("{question}"));
    assert_eq!(code(&ended), (2, "no-serial"));
    assert_eq!(board.rows().len(), 3);
    // The user says which unit it is.
    let ended = board.run(&["--serial", "7"], stop_after_one);
    assert_eq!(code(&ended), (2, "not-confirmed"));
    assert_eq!(board.rows().len(), 4);
}

#[test]
fn unit_that_is_exchanged_while_a_question_is_open_is_not_measured() {
    for (name, is_told, options, expected) in [
        ("exchanged-told", true, &[][..], "wrong-unit"),
        ("exchanged-named", false, &["--serial", "7"], "wrong-file"),
        ("exchanged-unknown", false, &[], "wrong-unit"),
    ] {
        let board = Board::new(name);
        let other = Board {
            serial: 8,
            ..Board::new(name)
        };
        if is_told {
            board.turn("+z");
        } else {
            board.turn_untold("+z");
        }
        let ended = board.run(options, &mut |_, question, number| {
            assert_eq!(number, 1, "{name}: {question}");
            // The other unit tells its serial number once, at its start.
            other.turn("-z");
            wait_for_prints(&other.position, 2);
            other.turn_untold("-z");
            wait_for_prints(&other.position, 2);
            true
        });
        assert_eq!(code(&ended), (2, expected), "{name}");
        let rows = board.rows();
        assert!(rows[rows.len() - 1].starts_with("+z,"), "{name}: {rows:?}");
    }
}

#[test]
fn wrong_side_and_motion_are_reported_and_not_measured() {
    let board = Board::new("wrong");
    board.turn("-y");
    let (position, serial) = (board.position.clone(), board.serial);
    // The user turns the unit later: to a wrong side first, then it moves all the time, then it is right.
    let turning = std::thread::spawn(move || {
        let pause = || std::thread::sleep(std::time::Duration::from_millis(700));
        let put = |text: &str| {
            let part = position.with_extension("turned");
            std::fs::write(&part, text).expect("a file");
            std::fs::rename(&part, &position).expect("a file");
        };
        pause();
        put(&(log(serial, "+z", 25_10) + &log(serial, "+x", 25_10)));
        pause();
        put(&log(serial, "+z", 25_10));
    });
    let ended = board.run(&[], &mut |_, _, _| false);
    turning.join().expect("the thread ends");
    assert_eq!(code(&ended), (2, "not-confirmed"));
    for note in ["-y is up, not +z: x ", "it moves: x "] {
        assert!(ended.notes.contains(note), "{note}: {ended:?}");
    }
    assert!(
        ended.questions[0].starts_with("+z is up and at rest: "),
        "{ended:?}"
    );
    assert!(!board.measurement.exists());
}

#[test]
fn log_that_ends_and_wrong_options_are_refused_with_a_next_step() {
    let board = Board::new("refused");
    let none = &mut |_: &Board, _: &str, _: usize| panic!("no question");
    let run = |options: &[&str], log: &[&str]| board.run_with(options, log, &mut *none);
    let mut run = run;
    assert_eq!(code(&run(&[], &["--", "true"])), (4, "log-ended"));
    assert_eq!(
        code(&run(&[], &["--", "/nonexistent/probe"])),
        (4, "no-log")
    );
    assert_eq!(
        code(&run(&["--yes"], &["--", "true"])),
        (2, "needs-answers")
    );
    assert_eq!(
        code(&run(&["--store", "unit.bin"], &["--", "true"])),
        (2, "unknown-product")
    );
    assert_eq!(code(&run(&[], &[])), (4, "no-file"));
    assert!(!board.measurement.exists());
    for text in ["", "up,x\n", "up,ax_g,ay_g,az_g,temp_c\n+x,1,0,zero,25\n"] {
        std::fs::write(&board.measurement, text).expect("a file");
        assert_eq!(code(&run(&[], &[])), (2, "bad-file"), "{text}");
    }
}
