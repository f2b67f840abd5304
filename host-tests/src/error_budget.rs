//! The error budget of the measuring elements: what each error of the acceleration is as an angle. The page
//! `firmware-stm32/ELEMENTS.md` contains the tables.

use std::fmt::Write as _;

/// A figure of a part.
#[derive(Clone, Copy, Debug)]
enum Figure {
    /// From its datasheet, or from a driver of its manufacturer.
    Given(f64),
    /// From a second source: to be confirmed with the datasheet.
    Unconfirmed(f64),
    /// The datasheet has none.
    None,
}

impl Figure {
    fn value(self) -> Option<f64> {
        match self {
            Self::Given(value) | Self::Unconfirmed(value) => Some(value),
            Self::None => None,
        }
    }

    /// The figure, or another one calculated from it, with this many decimals.
    fn shown(self, decimals: usize, of: impl Fn(f64) -> f64) -> String {
        match self {
            Self::Given(value) => format!("{:.decimals$}", of(value)),
            Self::Unconfirmed(value) => format!("{:.decimals$} (?)", of(value)),
            Self::None => "-".to_owned(),
        }
    }
}

/// The figures of a part.
struct Element {
    name: &'static str,
    /// Noise density in ug per square root of Hz, typical.
    noise: Figure,
    /// Offset in mg, typical.
    offset: Figure,
    /// Drift of the offset in mg/K, typical and maximum.
    drift: [Figure; 2],
    /// The largest deviation from a straight line in percent of this range in g.
    linearity: (Figure, f64),
}

const ELEMENTS: [Element; 2] = [
    Element {
        name: "ISM330DHCX",
        noise: Figure::Given(60.0),
        offset: Figure::Unconfirmed(10.0),
        drift: [Figure::Unconfirmed(0.1), Figure::None],
        linearity: (Figure::None, 8.0),
    },
    // Datasheet, revision 0, table 2. Its noise density is 25 ug/rtHz there, and 22.5 ug/rtHz in the later revisions.
    Element {
        name: "ADXL355",
        noise: Figure::Given(22.5),
        offset: Figure::Given(25.0),
        drift: [Figure::Given(0.02), Figure::Given(0.15)],
        linearity: (Figure::Given(0.1), 2.0),
    },
];

/// The filters for the noise, in Hz.
const CUTOFFS: [f64; 3] = [25.0, 10.0, 2.0];

/// The change of the temperature in K.
const WARMTH: f64 = 30.0;

/// The level surface of the calibration, in degrees: the same error is in all angles.
const SURFACE: f64 = 0.01;

/// What GEMAC promises: the error up to 60 deg, and the drift per K without and with a heated cell.
const PROMISED: f64 = 0.05;
const PROMISED_DRIFT: [f64; 2] = [0.008, 0.0008];

/// An error of the acceleration in mg as an angle near level, in degrees.
fn angle(milli_g: f64) -> f64 {
    (milli_g / 1000.0).asin().to_degrees()
}

/// The rms noise in mg behind a Butterworth filter of order 8, whose noise bandwidth is 1 % above its cut-off frequency.
fn noise(density: f64, cutoff: f64) -> f64 {
    density * (cutoff * 1.01).sqrt() / 1000.0
}

/// The deviation from a straight line in mg at 1 g: it grows with the square of the acceleration.
fn linearity(percent: f64, range: f64) -> f64 {
    percent * 10.0 * range / (range * range)
}

/// The tables as Markdown.
pub fn tables() -> String {
    let mut text = String::new();
    let mut row = |what: String, cells: [String; 2]| {
        let [first, second] = cells;
        let _ = writeln!(text, "| {what} | {first} | {second} |");
    };
    let all = |cell: &dyn Fn(&Element) -> String| {
        let [first, second] = &ELEMENTS;
        [cell(first), cell(second)]
    };
    row("figure".to_owned(), all(&|part| part.name.to_owned()));
    row("---".to_owned(), all(&|_| "---".to_owned()));
    let same = |value| value;
    row(
        "noise density, typical, ug/rtHz".to_owned(),
        all(&|part| part.noise.shown(1, same)),
    );
    row(
        "offset before calibration, typical, mg".to_owned(),
        all(&|part| part.offset.shown(0, same)),
    );
    for (kind, place) in [("typical", 0), ("maximum", 1)] {
        row(
            format!("drift, {kind}, mg/K"),
            all(&|part| part.drift[place].shown(2, same)),
        );
    }
    row(
        "non-linearity, percent of the range".to_owned(),
        all(&|part| match part.linearity {
            (figure @ Figure::None, _) => figure.shown(1, same),
            (figure, range) => format!("{} of {range:.0} g", figure.shown(1, same)),
        }),
    );
    text.push('\n');
    let mut row = |what: String, promised: String, cells: [String; 2]| {
        let [first, second] = cells;
        let _ = writeln!(text, "| {what} | {promised} | {first} | {second} |");
    };
    let dash = || "---".to_owned();
    row(
        "angle near level, in deg".to_owned(),
        "GEMAC".to_owned(),
        all(&|part| part.name.to_owned()),
    );
    row(dash(), dash(), all(&|_| dash()));
    row(
        "offset before calibration".to_owned(),
        String::new(),
        all(&|part| part.offset.shown(2, angle)),
    );
    for cutoff in CUTOFFS {
        row(
            format!("noise behind {cutoff:.0} Hz, rms"),
            String::new(),
            all(&|part| part.noise.shown(4, |density| angle(noise(density, cutoff)))),
        );
    }
    for (kind, place) in [("typical", 0), ("maximum", 1)] {
        row(
            format!("drift per K, {kind}"),
            format!("{:.3}", PROMISED_DRIFT[0]),
            all(&|part| part.drift[place].shown(4, angle)),
        );
    }
    for (kind, place) in [("typical", 0), ("maximum", 1)] {
        row(
            format!("drift in {WARMTH:.0} K, {kind}"),
            format!("{:.2}", PROMISED_DRIFT[0] * WARMTH),
            all(&|part| part.drift[place].shown(3, |drift| angle(drift * WARMTH))),
        );
    }
    row(
        "share of a change of temperature that may reach a heated part, typical".to_owned(),
        format!("{:.4} per K", PROMISED_DRIFT[1]),
        all(&|part| {
            let share = |drift| 100.0 * (PROMISED_DRIFT[1] / angle(drift)).min(1.0);
            format!("{} %", part.drift[0].shown(0, share))
        }),
    );
    row(
        "non-linearity up to 1 g".to_owned(),
        String::new(),
        all(&|part| {
            let (figure, range) = part.linearity;
            figure.shown(3, |percent| angle(linearity(percent, range)))
        }),
    );
    row(
        "mounting: the surface of the calibration".to_owned(),
        String::new(),
        all(&|_| format!("{SURFACE:.3}")),
    );
    row(
        "sum at the temperature of the calibration, behind 2 Hz".to_owned(),
        format!("{PROMISED:.2}"),
        all(&|part| {
            let (figure, range) = part.linearity;
            let noise = part.noise.value().map_or(0.0, |it| angle(noise(it, 2.0)));
            let sum = |bow| 3.0 * noise + SURFACE + bow;
            match figure {
                Figure::None => format!("{:.3} without non-linearity", sum(0.0)),
                _ => figure.shown(3, |percent| sum(angle(linearity(percent, range)))),
            }
        }),
    );
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angle_of_one_milli_g_is_0_057_deg() {
        assert!((angle(1.0) - 0.0573).abs() < 1e-4);
        // 22.5 ug in 25 Hz, and the acceleration that GEMAC's 0.05 deg are.
        assert!((noise(22.5, 25.0) - 0.113).abs() < 1e-3);
        assert!((angle(0.873) - PROMISED).abs() < 1e-4);
    }

    #[test]
    fn bow_of_a_part_falls_with_the_square_of_the_acceleration() {
        // 0.1 % of 2 g are 2 mg at 2 g, a quarter of it at 1 g.
        assert!((linearity(0.1, 2.0) - 0.5).abs() < 1e-9);
    }
}
