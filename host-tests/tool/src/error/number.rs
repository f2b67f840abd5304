//! Errors of values.

use super::Meant;
use crate::meaning::Named;
use texts::errors;

errors! {
    /// Why a text is no value of an entry.
    NumberError {
        NoInteger: Usage "bad-value" = "raw: needs an integer", "raw: braucht eine ganze Zahl";
        NoIdentifier: Usage "bad-value" = "an identifier is 300h (11 bits) or 8 digits as 00000361h (29 bits)",
            "ein Identifier ist 300h (11 Bit) oder 8 Ziffern wie 00000361h (29 Bit)";
        Hexadecimal(text: String): Usage "bad-value" = "a hexadecimal number ends with h: write {text}h",
            "eine hexadezimale Zahl endet mit h: Schreiben Sie {text}h";
        NoNumber: Usage "bad-value" = "it is no number", "es ist keine Zahl";
        NoUnit: Usage "bad-value" = "it has no unit", "der Wert hat keine Einheit";
        Unit(unit: &'static str): Usage "bad-value" = "its unit is {unit}", "die Einheit ist {unit}";
        Step(step: String): Usage "bad-value" = "its step is {step}", "die Schrittweite ist {step}";
        TooLarge: Usage "out-of-range" = "it is too large", "der Wert ist zu groß";
        RawOrName(text: String, raw: i64, names: Named): Usage "bad-value" = "{text} is ambiguous: write raw:{raw} or one of {names}",
            "{text} ist nicht eindeutig: Schreiben Sie raw:{raw} oder eines von {names}";
        Names(names: Named): Usage "bad-value" = "its values are {names}", "die Werte sind {names}";
        Ambiguous(text: String, names: Named): Usage "bad-value" = "{text} is ambiguous: its values are {names}",
            "{text} ist nicht eindeutig: Die Werte sind {names}";
        NoValue(name: String, text: String, why: Box<NumberError>, range: Named, meant: Meant): Usage "bad-value" = "{name} = {text:?}: {why}; it takes {range}{meant}",
            "{name} = {text:?}: {why}; erlaubt sind {range}{meant}";
        NotPermitted(value: String, name: String, range: Named): Usage "out-of-range" = "{value} is not permitted: {name} takes {range}",
            "{value} ist nicht erlaubt: {name} kann {range} sein";
        ReadOnly(name: String): Usage "read-only" = "{name} can only be read: `plumbline get {name}` shows it",
            "{name} ist nur lesbar";
        NotInFile(name: String): Usage "not-in-a-file" = "{name} cannot be stored in a file; `plumbline set {name}=...` writes it to the sensor",
            "{name} gehört nicht in eine Datei; im Sensor kann es gesetzt werden";
        NoSetting(product: &'static str, name: String): Usage "unknown-name" = "{product} has no setting {name:?}: `plumbline parameters` lists the names",
            "{product} hat keine Einstellung {name:?}";
        First(why: Box<NumberError>): Usage "out-of-range" = "{why}; change it first", "{why}; ändern Sie das zuerst";
        Resolution(text: String, why: Box<NumberError>): Usage "out-of-range" = "with the resolution of the sensor, {text}: {why}; nothing was written",
            "mit der Auflösung des Sensors, {text}: {why}; nichts wurde geschrieben";
        Same(one: String, other: String, value: String): Usage "out-of-range" = "{one} and {other} must differ: both would be {value}",
            "{one} und {other} müssen verschieden sein: Beide wären {value}";
        AtMost(name: String, limit: String, other: String, value: Named): Usage "out-of-range" = "{name} is at most {limit} with {other} {value}",
            "{name} ist höchstens {limit} mit {other} {value}";
        NoCobId(name: String, value: String): Usage "out-of-range" = "{value} is not permitted: {name} takes an 11-bit identifier that is free (CiA 301, table 81)",
            "{value} ist nicht erlaubt: {name} braucht einen freien Identifier mit 11 Bit (CiA 301, Tabelle 81)";
        NotMappable(name: String, value: String): Usage "out-of-range" = "{value} is not permitted: {name} takes index, sub-index and length in bits of an object that can be mapped",
            "{value} ist nicht erlaubt: {name} braucht Index, Subindex und Länge in Bit eines Objekts, das gemappt werden kann";
        NotMapped(count: String, entry: String): Usage "out-of-range" = "{count} includes {entry}, which is 0: change it first",
            "{count} zählt {entry} mit, das 0 ist: Ändern Sie das zuerst";
        TooManyMapped(count: String): Usage "out-of-range" = "{count} is too large: a TPDO has 8 objects with 64 bits together at the most",
            "{count} ist zu groß: Ein TPDO hat höchstens 8 Objekte mit zusammen 64 Bit";
        SameIdentifier(name: String): Usage "out-of-range" = "{name} must differ from the other identifiers",
            "{name} muss von den anderen Identifiern verschieden sein";
        NoAddress(number: u8, kind: &'static str, low: u8, high: u8): Usage "out-of-range" = "{number} is no {kind}: choose one from {low} to {high}",
            "{number} ist keine {kind}: Wählen Sie eine von {low} bis {high}";
        TooLong(name: String, text: String, longest: usize): Usage "bad-value" = "{name}={text:?}: it takes up to {longest} letters, digits and signs",
            "{name}={text:?}: Erlaubt sind bis zu {longest} Buchstaben, Ziffern und Zeichen";
        FitsNone(name: String, part: String, names: Named): Usage "bad-value" = "{name:?}: {part:?} fits none of {names}",
            "{name:?}: {part:?} passt zu keinem von {names}";
    }
}

impl NumberError {
    /// Whether the text is a number that is not permitted.
    pub(crate) fn is_out_of_range(&self) -> bool {
        matches!(self, Self::TooLarge | Self::NotPermitted(..))
    }
}
