//! The identity of a unit as a sheet of values.
//!
//! ```text
//! product = "tiltix080"
//! vendor = 354
//! device-type = 0
//! product-code = 8
//! revision = "1.2"
//! serial = 0x00A1B2C3
//! name = "INCLINOMETER 080 degree"
//! ```
//!
//! A sheet is TOML without sections. Only the product is mandatory. A missing value stays as the product has it.

use super::{Value, fields};
use plumbline::model::catalog::{Product, find};
use plumbline::store::Unit;

/// What a sheet can contain besides the product.
const KEYS: [&str; 9] = [
    "vendor",
    "device-type",
    "product-code",
    "revision",
    "serial",
    "article",
    "name",
    "hardware-version",
    "software-version",
];

/// A sheet of values that are not checked yet.
#[derive(Clone, Debug, Default)]
pub struct Sheet {
    /// The product that the sheet names, if it names one.
    pub product: Option<&'static Product>,
    /// The values by their keys.
    pub values: Vec<(&'static str, Value)>,
}

impl Sheet {
    /// Reads a sheet.
    ///
    /// # Errors
    /// One sentence: the text is not a sheet, or a key or product is unknown.
    pub fn parse(text: &str) -> Result<Self, String> {
        let table: toml::Table = text.parse().map_err(|error: toml::de::Error| {
            let line = error
                .span()
                .map_or(1, |span| 1 + text[..span.start].matches('\n').count());
            format!("line {line}: {}", error.message())
        })?;
        let mut sheet = Self::default();
        for (key, value) in table {
            if key == "product" {
                let name = value.as_str().unwrap_or_default();
                let product = find(name).ok_or_else(|| format!("there is no product {value}"))?;
                sheet.product = Some(product);
                continue;
            }
            let own = KEYS.iter().find(|own| **own == key).ok_or_else(|| {
                format!("{key} is unknown: a sheet has product, {}", KEYS.join(", "))
            })?;
            let value = match value {
                toml::Value::Integer(number) => Value::Number(number),
                toml::Value::String(text) => Value::Text(text),
                other => return Err(format!("{key} = {other} is neither a number nor a text")),
            };
            sheet.values.push((own, value));
        }
        Ok(sheet)
    }

    /// The identity of a unit of this product.
    ///
    /// # Errors
    /// One sentence that names the key, the value and what the product takes.
    pub fn unit(&self, product: &Product) -> Result<Unit, String> {
        if let Some(own) = self.product.filter(|own| own.name != product.name) {
            return Err(format!(
                "the sheet is for {}, not for {}",
                own.name, product.name
            ));
        }
        let fields = fields(product);
        let mut unit = Unit::NONE;
        for (key, value) in &self.values {
            let field = fields.iter().find(|field| field.key == *key);
            let field = field.ok_or_else(|| {
                let own: Vec<&str> = fields.iter().map(|field| field.key).collect();
                format!("{} has no {key}: it has {}", product.name, own.join(", "))
            })?;
            field.set(&mut unit, value)?;
        }
        Ok(unit)
    }
}

/// The text of a sheet: a line for each value that the unit has, with its place on the bus.
pub fn sheet(product: &Product, unit: &Unit) -> String {
    let mut text = format!(
        "# The identity of a unit: `plumbline identity --from` and `descriptors --unit` take it. A line that is left out\n# stays as the product has it.\nproduct = \"{}\"\n",
        product.name
    );
    for field in fields(product) {
        if let Some(value) = field.shown(unit) {
            text += &format!("{} = {value} # {}\n", field.key, field.place);
        }
    }
    text
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub fn unit_of(name: &str, text: &str) -> Result<Unit, String> {
        Sheet::parse(text)?.unit(find(name).unwrap())
    }

    /// A sheet with everything that the product has.
    pub const FULL: [(&str, &str); 4] = [
        (
            "is2",
            "product = \"is2\"\narticle = \"PR-23022-20\"\nrevision = 3\nserial = 0xA1B2C3\n",
        ),
        (
            "jn2101",
            "product = \"jn2101\"\nvendor = 0x195\nproduct-code = 0x1234\nrevision = 0x10002\nserial = 77\nname = \"Old one\"\nhardware-version = \"7\"\nsoftware-version = \"8\"\n",
        ),
        (
            "ims360",
            "product = \"ims360\"\nvendor = 1\nproduct-code = 0\nrevision = 0\nserial = 0\nname = \"Old\"\nhardware-version = \"7\"\nsoftware-version = \"8\"\n",
        ),
        (
            "tiltix080",
            "product = \"tiltix080\"\nvendor = 9\ndevice-type = 34\nproduct-code = 12\nrevision = \"3.4\"\nserial = 5\nname = \"Old TILTIX\"\n",
        ),
    ];

    #[test]
    fn sheet_written_for_a_unit_is_read_as_the_same_unit() {
        for (name, text) in FULL {
            let product = find(name).unwrap();
            let unit = unit_of(name, text).unwrap();
            let own = sheet(product, &unit);
            assert_eq!(unit_of(name, &own), Ok(unit), "{own}");
            let given = fields(product)
                .iter()
                .filter(|field| field.shown(&unit).is_some())
                .count();
            assert_eq!(given, fields(product).len(), "{own}");
        }
        let unit = unit_of("tiltix080", FULL[3].1).unwrap();
        assert_eq!((unit.revision, unit.device_type), (Some(0x304), Some(34)));
        assert_eq!(unit_of("is2", FULL[0].1).unwrap().article, Some(2_302_220));
    }

    #[test]
    fn value_out_of_range_is_refused_with_key_value_and_limit() {
        let long = "x".repeat(33);
        for (name, line, parts) in [
            (
                "jn2101",
                "vendor = 0",
                ["vendor = 0", "1018h:01", "1 to 4294967295"],
            ),
            (
                "jn2101",
                "serial = 4294967296",
                ["serial = 4294967296", "1018h:04", "0 to 4294967295"],
            ),
            (
                "jn2101",
                "revision = -1",
                ["revision = -1", "1018h:03", "0 to 4294967295"],
            ),
            (
                "jn2101",
                "name = 5",
                ["name = 5", "1008h", "1 to 32 characters"],
            ),
            (
                "jn2101",
                "vendor = \"ifm\"",
                ["vendor = \"ifm\"", "1018h:01", "1 to 4294967295"],
            ),
            (
                "ims360",
                "name = \"a*b\"",
                ["name = \"a*b\"", "1008h", "without *"],
            ),
            (
                "tiltix080",
                "product-code = 65536",
                ["product-code = 65536", "attribute 3", "1 to 65535"],
            ),
            (
                "tiltix080",
                "vendor = 0",
                ["vendor = 0", "attribute 1", "1 to 65535"],
            ),
            (
                "tiltix080",
                "device-type = 65536",
                ["device-type = 65536", "attribute 2", "0 to 65535"],
            ),
            (
                "tiltix080",
                "revision = \"128.1\"",
                ["revision = \"128.1\"", "attribute 4", "1 to 127"],
            ),
            (
                "tiltix080",
                "revision = \"1.0\"",
                ["revision = \"1.0\"", "attribute 4", "1 to 255"],
            ),
            (
                "is2",
                "revision = 65536",
                ["revision = 65536", "code 03h", "0 to 65535"],
            ),
            (
                "is2",
                "article = \"IS2\u{e4}\"",
                ["article = ", "code 03h", "1 to 9 digits"],
            ),
            (
                "is2",
                "article = 1000000000",
                ["article = 1000000000", "code 03h", "1 to 9 digits"],
            ),
        ] {
            let error = unit_of(name, line).unwrap_err();
            for part in parts {
                assert!(error.contains(part), "{line}: {error}");
            }
        }
        let error = unit_of("tiltix080", &format!("name = \"{long}\"")).unwrap_err();
        assert!(error.contains("1 to 32 characters"), "{error}");
    }

    #[test]
    fn sheet_with_a_wrong_line_is_refused() {
        for (line, part) in [
            ("vendor 1", "line 1"),
            ("serial = 1\nvendor = ", "line 2"),
            ("producer = 1", "producer is unknown"),
            ("product = \"is9\"", "no product \"is9\""),
            ("product = \"is1\"", "is for is1, not for is2"),
            (
                "vendor = 1",
                "is2 has no vendor: it has article, revision, serial",
            ),
            ("serial = 1.5", "neither a number nor a text"),
            ("[unit]\nserial = 1", "unit is unknown"),
        ] {
            let error = unit_of("is2", line).unwrap_err();
            assert!(error.contains(part), "{line}: {error}");
        }
        assert_eq!(unit_of("is2", ""), Ok(Unit::NONE));
    }
}
