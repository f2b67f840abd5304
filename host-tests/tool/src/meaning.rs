//! The German names of values. The compiler checks that no name of the catalogue is missing.

use plumbline::model::catalog::PRODUCTS;
use plumbline::param::Permitted;
use std::fmt::{self, Display, Formatter};
use texts::Text;

/// What a value is in English and in German. A quantity, for example `250 kbit/s`, is the same in both.
const NAMES: &[(&str, &str)] = &[
    ("off", "aus"),
    ("on", "ein"),
    ("disabled", "ausgeschaltet"),
    ("enabled", "eingeschaltet"),
    ("automatic detection", "automatische Erkennung"),
    ("stays in bus-off", "bleibt in Bus-off"),
    ("recovers", "erholt sich"),
    ("filter disabled", "Filter ausgeschaltet"),
    ("Butterworth", "Butterworth"),
    ("Butterworth 8th order", "Butterworth 8. Ordnung"),
    ("critically damped", "kritisch gedämpft"),
    (
        "critically damped 8th order",
        "kritisch gedämpft 8. Ordnung",
    ),
    ("low-pass filter", "Tiefpassfilter"),
    ("sensor fusion filter", "Sensorfusionsfilter"),
    ("perpendicular", "Lotwinkel"),
    ("Euler", "Euler"),
    ("gimbal X", "Kardan X"),
    ("gimbal Y", "Kardan Y"),
    ("+-180 deg", "+-180 deg"),
    ("0 to 360 deg", "0 bis 360 deg"),
    ("no change", "keine Änderung"),
    ("unchanged", "unverändert"),
    ("relative measurement", "relative Messung"),
    ("absolute measurement", "absolute Messung"),
    ("inversion", "Invertierung"),
    ("scaling", "Skalierung"),
    ("inversion and scaling", "Invertierung und Skalierung"),
    (
        "1-axis sensor (0 to 360 deg)",
        "1-achsiger Sensor (0 bis 360 deg)",
    ),
    ("2-axis sensor (+-90 deg)", "2-achsiger Sensor (+-90 deg)"),
    ("CANopen", "CANopen"),
    ("SAE J1939", "SAE J1939"),
    ("pre-operational", "pre-operational"),
    ("no change of state", "keine Änderung des Zustands"),
    ("stopped", "stopped"),
    ("slave only", "nur Slave"),
    ("NMT start command", "NMT-Startbefehl"),
    ("autostart", "Autostart"),
    ("slope long16", "slope long16"),
    ("slope lateral16", "slope lateral16"),
    (
        "slope long16, slope lateral16",
        "slope long16, slope lateral16",
    ),
    ("a text", "ein Text"),
    ("0, 10..65535", "0, 10..65535"),
    ("1..127; 255 by LSS only", "1..127; 255 nur mit LSS"),
    ("1..126; 255 by LSS only", "1..126; 255 nur mit LSS"),
    (
        "11-bit identifier that is free",
        "freier Identifier mit 11 Bit",
    ),
    ("11 or 29 bit", "11 oder 29 Bit"),
];

/// The German name of a value; the same name if it has no other, as in a data sheet.
pub fn german(name: &'static str) -> &'static str {
    let own = NAMES.iter().find(|(english, _)| *english == name);
    own.map_or(name, |(_, german)| german)
}

/// A text with names of values, in English and in German. It is in a box, because it is a part of errors, which are small.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Named(Box<[String; 2]>);

/// The name of a value in a language.
pub type Language = fn(&'static str) -> &'static str;

impl Named {
    /// The text that is made with the names of a language.
    pub fn of(text: impl Fn(Language) -> String) -> Self {
        Self(Box::new([text(|name| name), text(german)]))
    }
}

impl Display for Named {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0[0])
    }
}

impl Text for Named {
    fn german(&self) -> String {
        self.0[1].clone()
    }
}

const _: () = {
    let mut product = 0;
    while product < PRODUCTS.len() {
        let parameters = PRODUCTS[product].parameters;
        let mut parameter = 0;
        while parameter < parameters.len() {
            let mut meaning = 0;
            while meaning < parameters[parameter].meanings.len() {
                let name = parameters[parameter].meanings[meaning].1;
                assert!(is_known(name), "a name of a value has no German name");
                meaning += 1;
            }
            if let Permitted::Ranges(ranges) = parameters[parameter].permitted {
                assert!(is_known(ranges.text), "a range has no German text");
            }
            parameter += 1;
        }
        product += 1;
    }
};

const fn is_known(name: &str) -> bool {
    let mut place = 0;
    while place < NAMES.len() {
        if is_same(NAMES[place].0, name) {
            return true;
        }
        place += 1;
    }
    name.is_empty() || is_quantity(name.as_bytes())
}

const fn is_same(one: &str, other: &str) -> bool {
    let (one, other) = (one.as_bytes(), other.as_bytes());
    let mut place = 0;
    while place < one.len() && place < other.len() && one[place] == other[place] {
        place += 1;
    }
    place == one.len() && place == other.len()
}

/// A number and a unit.
const fn is_quantity(name: &[u8]) -> bool {
    let (mut place, mut spaces) = (0, 0);
    while place < name.len() {
        if name[place] == b' ' {
            spaces += 1;
        }
        place += 1;
    }
    name[0].is_ascii_digit() && spaces == 1
}
