//! The reference line: active compensation of the thermal drift, and AccuracyWarning (manual 9.3 and 9.5.2).
//!
//! Section and table numbers refer to the English manual of 2021.

use crate::tester::fsc::*;
use plumbline::can::{Frame, standard};
use plumbline::fsc::{Article, Product};
use plumbline::measure::ONE_G;
use plumbline::model::gemac::{is1, is1dm, is1tk, is2, is2dm, is2tk};
use plumbline::node::Action;

/// Bit 6 of the status byte (tables 14 and 15).
const ACCURACY_WARNING: u8 = 0x40;

/// The constant temperature of the measuring cell, in 0.01 degC.
const SET_POINT: i16 = 82_00;

type Is2tk = FscTester<is2tk::TwoAxesHeated>;

fn status<P: Product>(tester: &mut FscTester<P>) -> u8 {
    tester.ask(&[0x02])[1]
}

/// Hands in samples with this temperature in 0.01 degC for `ms` milliseconds.
fn hold<P: Product>(tester: &mut FscTester<P>, temperature: i16, ms: u64) {
    tester.temperature = temperature;
    tester.wait(ms);
}

/// The duties in permille that were reported to the hardware since the last call.
fn duties<P: Product>(tester: &mut FscTester<P>) -> Vec<u16> {
    let duty = |action: Action| match action {
        Action::Heater(duty) => Some(duty),
        _ => None,
    };
    tester.actions.drain(..).filter_map(duty).collect()
}

/// A sensor whose cell has its constant temperature.
fn warm() -> Is2tk {
    let mut tester = online(&is2tk::METAL);
    hold(&mut tester, SET_POINT, 60_000);
    assert_eq!(status(&mut tester), DELIVERED);
    tester
}

#[test]
fn accuracy_warning_is_set_until_constant_temperature_is_reached() {
    fn check<P: Product>(product: &'static Article) {
        let mut tester = online::<P>(product);
        tester.rest(0, ONE_G / 2, ONE_G / 2);
        // All replies have the bit, not only the reply to 02h.
        assert_eq!(tester.ask(&[0xFF])[1], DELIVERED | ACCURACY_WARNING);
        assert_eq!(tester.ask(&[0x00])[1], DELIVERED | ACCURACY_WARNING);
        for temperature in (-20_00..SET_POINT).step_by(4_00) {
            hold(&mut tester, temperature, 1000);
            assert_eq!(status(&mut tester), DELIVERED | ACCURACY_WARNING);
        }
        hold(&mut tester, SET_POINT, 10_000);
        assert_eq!(status(&mut tester), DELIVERED | ACCURACY_WARNING);
        hold(&mut tester, SET_POINT, 30_000);
        assert_eq!(status(&mut tester), DELIVERED);
        assert_eq!(tester.ask(&[0x00])[1], DELIVERED);
        // The temperature falls and rises again.
        hold(&mut tester, SET_POINT - 2_00, 300);
        assert_eq!(status(&mut tester), DELIVERED | ACCURACY_WARNING);
        hold(&mut tester, SET_POINT, 60_000);
        assert_eq!(status(&mut tester), DELIVERED);
    }
    check::<is1tk::OneAxisHeated>(&is1tk::METAL);
    check::<is2tk::TwoAxesHeated>(&is2tk::METAL);
    check::<is1tk::OneAxisHeated>(&is1dm::METAL);
    check::<is2tk::TwoAxesHeated>(&is2dm::METAL);
}

/// "Independent of the operation temperature" (9.3), which is at most +80 degC (table 1).
#[test]
fn cell_is_heated_at_any_operating_temperature() {
    let mut tester = online::<is2tk::TwoAxesHeated>(&is2tk::METAL);
    for temperature in (-40_00..=80_00).step_by(10_00) {
        hold(&mut tester, temperature, 60_000);
        assert_eq!(status(&mut tester) & ACCURACY_WARNING, ACCURACY_WARNING);
        let reported = duties(&mut tester);
        assert!(reported.last().is_none_or(|duty| *duty > 0), "{reported:?}");
    }
    let mut tester = online::<is2tk::TwoAxesHeated>(&is2tk::METAL);
    hold(&mut tester, 84_00, 1000);
    assert_eq!(duties(&mut tester).last(), Some(&0));
}

#[test]
fn changed_duty_is_reported_at_most_every_200_ms() {
    let mut tester = power_up::<is2tk::TwoAxesHeated>(&is2tk::METAL);
    // Off before the first reading. 25 degC are cold.
    assert_eq!(duties(&mut tester), [0, 1000]);
    hold(&mut tester, -20_00, 5000);
    assert_eq!(duties(&mut tester), [], "constant full power");
    hold(&mut tester, 85_00, 1000);
    let reported = duties(&mut tester);
    assert_eq!(reported.last(), Some(&0));
    // After the derivative term has decayed, the integral increases the duty step by step.
    hold(&mut tester, SET_POINT - 5_00, 20_000);
    assert!((5..=100).contains(&duties(&mut tester).len()));
    hold(&mut tester, SET_POINT - 5_00, 10_000);
    let reported = duties(&mut tester);
    assert!((10..=51).contains(&reported.len()), "{reported:?}");
    assert!(
        reported.windows(2).all(|pair| pair[0] < pair[1]),
        "{reported:?}"
    );
}

#[test]
fn missing_samples_stop_heater_and_set_accuracy_warning() {
    let mut tester = warm();
    hold(&mut tester, SET_POINT - 30, 1000);
    assert!(duties(&mut tester).last().is_some_and(|duty| *duty > 0));
    assert_eq!(status(&mut tester), DELIVERED);
    tester.wait_without_samples(150);
    assert_eq!(duties(&mut tester), [0]);
    assert_eq!(status(&mut tester), DELIVERED | ACCURACY_WARNING | 0x30);
    tester.wait_without_samples(60_000);
    assert_eq!(duties(&mut tester), []);
    // The first sample switches the heater on again. The temperature must become steady again.
    hold(&mut tester, SET_POINT - 30, 100);
    assert!(duties(&mut tester).last().is_some_and(|duty| *duty > 0));
    assert_eq!(status(&mut tester), DELIVERED | ACCURACY_WARNING);
    hold(&mut tester, SET_POINT - 30, 31_000);
    assert_eq!(status(&mut tester), DELIVERED);
}

#[test]
fn restart_switches_heater_off_first() {
    let mut tester = online::<is2tk::TwoAxesHeated>(&is2tk::METAL);
    assert_eq!(duties(&mut tester), [0, 1000]);
    tester.silent(b"\xFFRESET");
    let off = tester.actions.iter().position(|a| *a == Action::Heater(0));
    let restart = tester.actions.iter().position(|a| *a == Action::Restart);
    assert!(
        off.is_some() && restart.is_some() && off < restart,
        "{:?}",
        tester.actions
    );
    tester.actions.clear();
    // Samples can continue until the hardware restarts.
    tester.wait(1000);
    assert_eq!(duties(&mut tester), []);
}

/// Restarts the sensor with RESET; the first reading has this temperature.
fn reset(tester: &mut Is2tk, temperature: i16) {
    tester.silent(b"\xFFRESET");
    tester.wait(0);
    assert!(tester.actions.contains(&Action::Restart));
    tester.temperature = temperature;
    tester.restart();
    tester.receive(Frame::data(standard(0x7FF), &[]).unwrap());
    assert_eq!(tester.sent().len(), 2, "two boot-up messages");
}

/// G32: a RESET does not cool the cell, so its temperature is steady as soon as it is read, and the duty has no step.
#[test]
fn warm_sensor_stays_warm_over_a_reset() {
    let mut tester = warm();
    hold(&mut tester, SET_POINT - 40, 60_000);
    hold(&mut tester, SET_POINT, 20_000);
    let before = *duties(&mut tester).last().unwrap();
    assert!((10..990).contains(&before), "{before}");
    for _ in 0..2 {
        reset(&mut tester, SET_POINT);
        let after = *duties(&mut tester).last().unwrap();
        assert!(before.abs_diff(after) <= 1, "{before} {after}");
        assert_eq!(status(&mut tester), DELIVERED);
        hold(&mut tester, SET_POINT, 60_000);
        assert_eq!(status(&mut tester), DELIVERED);
    }
    // A little colder: until the temperature is read at the set point.
    reset(&mut tester, SET_POINT - 60);
    assert_eq!(status(&mut tester), DELIVERED | ACCURACY_WARNING);
    hold(&mut tester, SET_POINT - 60, 1000);
    assert_eq!(status(&mut tester), DELIVERED | ACCURACY_WARNING);
    hold(&mut tester, SET_POINT - 40, 250);
    assert_eq!(status(&mut tester), DELIVERED);
    // Power-up begins anew.
    tester.power_cycle();
    tester.receive(Frame::data(standard(0x7FF), &[]).unwrap());
    tester.sent();
    hold(&mut tester, SET_POINT, 29_000);
    assert_eq!(status(&mut tester), DELIVERED | ACCURACY_WARNING);
}

#[test]
fn reset_during_the_warm_up_does_not_end_it() {
    let mut tester = online(&is2tk::METAL);
    hold(&mut tester, SET_POINT, 10_000);
    reset(&mut tester, SET_POINT);
    hold(&mut tester, SET_POINT, 29_000);
    assert_eq!(status(&mut tester), DELIVERED | ACCURACY_WARNING);
    hold(&mut tester, SET_POINT, 2_000);
    assert_eq!(status(&mut tester), DELIVERED);
}

#[test]
fn reset_after_missing_samples_begins_the_warm_up_anew() {
    let mut tester = warm();
    tester.wait_without_samples(150);
    reset(&mut tester, SET_POINT);
    assert_eq!(status(&mut tester), DELIVERED | ACCURACY_WARNING);
}

#[test]
fn product_without_heater_has_no_heater_actions_and_no_warning() {
    fn check<P: Product>(product: &'static Article) {
        let mut tester = online::<P>(product);
        for temperature in (-40_00..=85_00).step_by(5_00) {
            hold(&mut tester, temperature, 1000);
            assert_eq!(status(&mut tester) & ACCURACY_WARNING, 0);
        }
        tester.wait_without_samples(1000);
        tester.silent(b"\xFFRESET");
        assert_eq!(duties(&mut tester), []);
    }
    check::<is1::OneAxis>(&is1::BP_CL);
    check::<is2::TwoAxes>(&is2::MA_BL);
}
