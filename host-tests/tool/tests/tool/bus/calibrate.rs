//! `calibrate`: a shell script is the command of the log. It prints 3 s of the position in a file again and again, and the answers
//! to the questions turn the sensor.

mod board;

use bench::{Flash, Geometry, STORE_BUFFER};
use board::{Board, Ended, RATE, raw, wait_for_prints};
use plumbline::measure::calibration::Part;
use plumbline::measure::{I32x3, ONE_G};
use plumbline::model::catalog::find;
use plumbline::store::Store;
use std::path::Path;

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
    assert!(failure.to_string().len() > 20, "{failure}");
    (failure.kind().exit_code(), failure.code())
}

/// The store of a unit corrects the raw acceleration of each side.
#[track_caller]
fn assert_corrects(path: &Path, serial: u32, corrects: bool) {
    let flash = Flash::in_file(Geometry::STM32F103, path).expect("a store file");
    let owner = find("is2").expect("a product").owner(serial);
    let mut store = Store::<_, [u8; STORE_BUFFER]>::open(flash, owner);
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
    let rate = RATE.map(|rate| (i64::from(rate) * 65_536 / 1000) as i32);
    let [x, y, z] = rate;
    let still = calibration.apply_to_rate(I32x3 { x, y, z }, 25_10);
    let is_still = still.to_array().iter().all(|rate| rate.abs() < 20);
    assert_eq!(is_still, corrects, "{still:?}");
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
        "up,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps,temp_c",
        "# serial number 7",
        "+z,0.025000,-0.030000,1.060000,0.3100,-0.0200,0.0050,25.10",
        "-z,0.015000,-0.030000,-0.960000,0.3100,-0.0200,0.0050,25.10",
        "+x,1.040000,-0.020000,0.050000,0.3100,-0.0200,0.0050,25.10",
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
fn calibration_belongs_to_the_measuring_element_in_the_log() {
    let mut board = Board::new("element");
    board.element = Some("adxl355");
    board.turn("+z");
    let options = board.store_options();
    let options: Vec<&str> = options.iter().map(String::as_str).collect();
    let ended = board.run(&options, &mut take);
    assert_eq!(ended.result, Ok(()), "{ended:?}");
    assert_eq!(board.rows()[1], "# element adxl355");
    let flash = Flash::in_file(Geometry::STM32F103, &board.store).expect("a store file");
    let owner = find("is2").expect("a product").owner(7);
    let mut store = Store::<_, [u8; STORE_BUFFER]>::open(flash, owner);
    assert_eq!(store.boot().calibration.part(), Part::Adxl355);
    for (other, expected) in [("ism330dhcx", "wrong-file"), ("newer", "unknown-element")] {
        board.element = Some(other);
        board.turn("+z");
        let ended = board.run(&[], &mut |_, _, _| panic!("no question"));
        assert_eq!(code(&ended), (2, expected), "{other}");
    }
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
    const WRONG_SIDE: &str = "-y is up, not +z: x ";
    const MOTION: &str = "it moves: x ";
    let board = Board::new("wrong");
    board.turn("-y");
    // The user moves the unit all the time when the tool says that the side is wrong, and puts it right when it says that it moves.
    board
        .reactions
        .borrow_mut()
        .extend([(WRONG_SIDE, &["+z", "+x"][..]), (MOTION, &["+z"])]);
    let ended = board.run(&[], &mut |_, _, _| false);
    assert_eq!(code(&ended), (2, "not-confirmed"));
    for note in [WRONG_SIDE, MOTION] {
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
