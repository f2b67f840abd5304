//! The report of a replacement: a document, and a text that a user signs.

use super::old::Measured;
use serde::Serialize;

/// The largest difference of the angles of both sensors in degrees: two sensors with an accuracy of 0.25 deg.
const AGREES: f64 = 0.5;

/// A value of both sensors.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Compared {
    /// Its name.
    pub name: String,
    /// That of the old sensor; None: it has none.
    pub old: Option<String>,
    /// That of the new sensor; None: it has none.
    pub new: Option<String>,
}

impl Compared {
    /// Whether both are the same.
    pub fn is_equal(&self) -> bool {
        self.old == self.new
    }

    fn line(&self) -> String {
        let shown = |value: &Option<String>| value.clone().unwrap_or_else(|| "-".to_owned());
        let mark = if self.is_equal() { "" } else { "   DIFFERENT" };
        let (old, new) = (shown(&self.old), shown(&self.new));
        format!("  {:<36} {old:<28} {new:<28}{mark}", self.name)
    }
}

/// A setting that the new sensor does not take.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct NotCarried {
    /// Its name.
    pub name: String,
    /// The value of the old sensor.
    pub value: String,
    /// Why the new sensor does not take it.
    pub why: String,
}

/// An angle of both sensors at rest, in degrees.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Angle {
    /// Its name.
    pub name: String,
    /// Of the old sensor.
    pub old: f64,
    /// Of the new sensor.
    pub new: f64,
    /// The larger spread.
    pub spread: f64,
    /// The new one minus the old one.
    pub difference: f64,
}

impl Angle {
    /// The angle of both sensors.
    pub fn new(old: &Measured, new: &Measured, difference: f64) -> Self {
        Self {
            name: old.name.clone(),
            old: old.angle,
            new: new.angle,
            spread: old.spread.max(new.spread),
            difference,
        }
    }

    /// Whether both sensors agree.
    pub fn is_equal(&self) -> bool {
        self.difference.abs() <= AGREES
    }
}

/// A replacement.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Replaced {
    /// The old sensor.
    pub old: String,
    /// The new sensor.
    pub new: String,
    /// The settings.
    pub settings: Vec<Compared>,
    /// The settings that the new sensor does not take.
    pub not_carried: Vec<NotCarried>,
    /// The identity, which a master can compare. A unit record gives the new sensor that of the old one.
    pub identity: Vec<Compared>,
    /// The values that are no settings. They can differ.
    pub replies: Vec<Compared>,
    /// The angles.
    pub angles: Vec<Angle>,
    /// The angles that are not compared, because one of both sensors had no valid one.
    pub not_compared: Vec<String>,
}

impl Replaced {
    /// The differences: settings, settings that are not carried, missing replies, angles, angles that are not compared.
    pub fn differences(&self) -> usize {
        let settings = self.settings.iter().filter(|own| !own.is_equal()).count();
        let replies = self.replies.iter();
        let missing = replies.filter(|own| own.new.is_none()).count();
        let angles = self.angles.iter().filter(|own| !own.is_equal()).count();
        settings + self.not_carried.len() + missing + angles + self.not_compared.len()
    }

    /// The text that a user signs.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![
            "Replacement of a sensor".to_owned(),
            format!("old: {}", self.old),
            format!("new: {}", self.new),
        ];
        let mut section = |title: &str, rows: Vec<String>| {
            lines.extend([String::new(), title.to_owned()]);
            match rows.is_empty() {
                true => lines.push("  none".to_owned()),
                false => lines.extend(rows),
            }
        };
        let compared = |rows: &[Compared]| rows.iter().map(Compared::line).collect();
        section("Settings (old, new)", compared(&self.settings));
        let rows = self.not_carried.iter();
        let rows = rows.map(|NotCarried { name, value, why }| format!("  {name} = {value}: {why}"));
        section("Not carried", rows.collect());
        section("Identity (old, new)", compared(&self.identity));
        section(
            "Replies (old, new); they can differ",
            compared(&self.replies),
        );
        let rows = self.angles.iter().map(|own| {
            let mark = if own.is_equal() { "" } else { "   DIFFERENT" };
            format!(
                "  {:<36} {:.2} deg, {:.2} deg, difference {:.2} deg, spread {:.2} deg{mark}",
                own.name, own.old, own.new, own.difference, own.spread
            )
        });
        let none = self.not_compared.iter();
        let none = none.map(|name| {
            format!("  {name:<36} not compared: one of both sensors had no valid angle   DIFFERENT")
        });
        section("Angles at rest (old, new)", rows.chain(none).collect());
        lines.push(String::new());
        lines.push(match self.differences() {
            0 => format!("Result: no differences; angles within {AGREES} deg"),
            count => format!("Result: differences: {count}"),
        });
        lines
    }

    /// The file with the report.
    pub fn text(&self) -> String {
        let lines = self.lines().into_iter();
        let sign = [
            "",
            "",
            "Date, name, signature: ________________________________",
        ];
        let lines = lines.chain(sign.map(str::to_owned));
        lines
            .map(|line| line.trim_end().to_owned() + "\n")
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn replaced() -> Replaced {
        let compared = |name: &str, old: &str, new: Option<&str>| Compared {
            name: name.to_owned(),
            old: Some(old.to_owned()),
            new: new.map(str::to_owned),
        };
        let measured = |angle| Measured {
            name: "angle-x".to_owned(),
            angle,
            spread: 0.01,
        };
        Replaced {
            old: "is2d".to_owned(),
            new: "is2".to_owned(),
            settings: vec![compared("cyclic-time", "250 ms", Some("250 ms"))],
            not_carried: Vec::new(),
            identity: Vec::new(),
            replies: vec![compared("software-version", "3.44", Some("3.45"))],
            angles: vec![Angle::new(&measured(1.0), &measured(1.4), 0.4)],
            not_compared: Vec::new(),
        }
    }

    #[test]
    fn differences_are_settings_missing_replies_and_angles() {
        assert_eq!(replaced().differences(), 0, "{:?}", replaced());
        let mut other = replaced();
        other.settings[0].new = Some("100 ms".to_owned());
        assert_eq!(other.differences(), 1);
        assert!(other.text().contains("100 ms"), "{}", other.text());
        assert!(other.text().contains("DIFFERENT"), "{}", other.text());
        let mut other = replaced();
        other.replies[0].new = None;
        assert_eq!(other.differences(), 1);
        let mut other = replaced();
        other.angles[0].difference = -0.6;
        assert_eq!(other.differences(), 1);
        let mut other = replaced();
        other.not_carried.push(NotCarried {
            name: "teach".to_owned(),
            value: "1".to_owned(),
            why: "it has no such setting".to_owned(),
        });
        assert_eq!(other.differences(), 1);
        assert!(replaced().text().contains("signature"));
    }
}
