//! A line chart as an SVG document.

use std::fmt::Write;

/// The size of the document in pixels.
const SIZE: (f64, f64) = (760.0, 420.0);

/// The edges of the area of the lines: left, right, top, bottom.
const AREA: [f64; 4] = [64.0, 744.0, 92.0, 372.0];

/// The maximum number of intervals between the marks of an axis.
const INTERVALS: f64 = 10.0;

/// A line of a chart.
pub struct Line<'a> {
    /// Its text in the legend.
    pub label: String,
    /// The attributes of its stroke.
    pub style: &'static str,
    /// A value for each time.
    pub values: &'a [f64],
}

/// A chart over time, with its axes and curves.
pub struct Chart<'a> {
    /// The title above the chart.
    pub title: &'a str,
    /// The title of the time axis.
    pub x: &'a str,
    /// The title of the axis of the values.
    pub y: &'a str,
    /// The times of the values, increasing.
    pub times: &'a [f64],
    /// The lines. A later one covers the earlier ones.
    pub lines: &'a [Line<'a>],
}

/// An axis: the values at its ends, and the distance of its marks.
struct Axis {
    first: f64,
    last: f64,
    interval: f64,
}

impl Axis {
    /// An axis for values from `lowest` to `highest` that ends at marks.
    fn of(lowest: f64, highest: f64) -> Self {
        let span = (highest - lowest).max(1e-3);
        let power = 10_f64.powf((span / INTERVALS).log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
        let fits = |step: &f64| span / step <= INTERVALS;
        let interval = steps.into_iter().find(fits).unwrap_or(10.0 * power);
        Self {
            first: (lowest / interval).floor() * interval,
            last: (highest / interval).ceil() * interval,
            interval,
        }
    }

    fn marks(&self) -> impl Iterator<Item = f64> {
        let count = ((self.last - self.first) / self.interval).round() as i32;
        (0..=count).map(|n| self.first + f64::from(n) * self.interval)
    }

    fn text(&self, mark: f64) -> String {
        let decimals = if self.interval < 1.0 { 1 } else { 0 };
        // Adding 0 turns -0 into 0.
        format!(
            "{:.decimals$}",
            (mark / self.interval).round() * self.interval + 0.0
        )
    }

    /// The place of a value between `from` and `to`.
    fn place(&self, value: f64, from: f64, to: f64) -> f64 {
        from + (value - self.first) / (self.last - self.first) * (to - from)
    }
}

impl Chart<'_> {
    /// The chart as an SVG document.
    pub fn svg(&self) -> String {
        let mut svg = String::new();
        self.write(&mut svg).expect("a String takes everything");
        svg
    }

    fn write(&self, svg: &mut String) -> std::fmt::Result {
        let (width, height) = SIZE;
        let [left, right, top, bottom] = AREA;
        let middle = (left + right) / 2.0;
        let values = || self.lines.iter().flat_map(|line| line.values).copied();
        let x_axis = Axis::of(0.0, self.times.iter().copied().fold(0.0, f64::max));
        let y_axis = Axis::of(
            values().fold(f64::INFINITY, f64::min),
            values().fold(f64::NEG_INFINITY, f64::max),
        );
        let x = |time| x_axis.place(time, left, right);
        let y = |value| y_axis.place(value, bottom, top);

        writeln!(
            svg,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
             font-family=\"sans-serif\" font-size=\"13\">"
        )?;
        writeln!(svg, "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>")?;
        writeln!(
            svg,
            "<text x=\"{left}\" y=\"20\" font-size=\"15\" font-weight=\"bold\">{}</text>",
            self.title
        )?;

        for mark in x_axis.marks() {
            let x = x(mark);
            writeln!(
                svg,
                "<path d=\"M{x:.1} {top}V{bottom}\" stroke=\"#ddd\"/><text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                bottom + 18.0,
                x_axis.text(mark)
            )?;
        }
        for mark in y_axis.marks() {
            let y = y(mark);
            writeln!(
                svg,
                "<path d=\"M{left} {y:.1}H{right}\" stroke=\"#ddd\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                left - 8.0,
                y + 4.5,
                y_axis.text(mark)
            )?;
        }
        writeln!(
            svg,
            "<path d=\"M{left} {top}V{bottom}H{right}\" fill=\"none\" stroke=\"#444\"/>"
        )?;
        writeln!(
            svg,
            "<text x=\"{middle}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            bottom + 40.0,
            self.x
        )?;
        let centre = (top + bottom) / 2.0;
        writeln!(
            svg,
            "<text transform=\"translate(18 {centre}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            self.y
        )?;

        for (place, line) in (0..).zip(self.lines) {
            write!(svg, "<polyline fill=\"none\" {} points=\"", line.style)?;
            for (time, value) in self.times.iter().zip(line.values) {
                write!(svg, "{:.1},{:.1} ", x(*time), y(*value))?;
            }
            writeln!(svg, "\"/>")?;
            let row = 40.0 + 18.0 * f64::from(place);
            writeln!(
                svg,
                "<path d=\"M{left} {row}h32\" {}/><text x=\"{}\" y=\"{}\">{}</text>",
                line.style,
                left + 42.0,
                row + 4.5,
                line.label
            )?;
        }
        writeln!(svg, "</svg>")
    }
}
