//! The description of a number of a product: name, type, unit, limits, names of values.

use plumbline::param::{DataType, Meaning, Parameter, Permitted, Quantity};

/// The description of a parameter, of a published value, or of another number on the bus.
#[derive(Clone, Debug)]
pub struct Number {
    pub name: &'static str,
    pub data_type: DataType,
    pub unit: &'static str,
    /// Digits after the decimal point.
    pub decimals: u8,
    /// The lowest and the highest value.
    pub limits: (i64, i64),
    pub meanings: &'static [Meaning],
}

impl Number {
    /// A number with the full range of this type.
    pub fn any(name: &'static str, data_type: DataType) -> Self {
        Self {
            name,
            data_type,
            unit: "",
            decimals: 0,
            limits: data_type.range(),
            meanings: &[],
        }
    }

    /// The displayed value of a number, for example `-90.00` for -9000 with two decimals.
    pub fn value(&self, number: i64) -> String {
        let decimals = usize::from(self.decimals);
        let value = number as f64 / 10f64.powi(self.decimals.into());
        format!("{value:.decimals$}")
    }
}

impl From<&Parameter> for Number {
    fn from(parameter: &Parameter) -> Self {
        let Parameter {
            name,
            data_type,
            unit,
            decimals,
            meanings,
            ..
        } = *parameter;
        Self {
            name,
            data_type,
            unit,
            decimals,
            limits: limits(parameter),
            meanings,
        }
    }
}

impl From<&Quantity> for Number {
    fn from(quantity: &Quantity) -> Self {
        Self {
            unit: quantity.unit,
            decimals: quantity.decimals,
            limits: quantity.range,
            ..Self::any(quantity.name, quantity.data_type)
        }
    }
}

/// The lowest and the highest permitted value of a parameter.
fn limits(parameter: &Parameter) -> (i64, i64) {
    let ends = |numbers: &mut dyn Iterator<Item = u32>| {
        let numbers: Vec<u32> = numbers.collect();
        let (low, high) = (numbers.iter().min(), numbers.iter().max());
        (
            low.map_or(0, |low| i64::from(*low)),
            high.map_or(0, |high| i64::from(*high)),
        )
    };
    match parameter.permitted {
        Permitted::Any => parameter.data_type.range(),
        Permitted::Range(low, high) => (low, high),
        Permitted::Named => ends(&mut parameter.meanings.iter().map(|(number, _)| *number)),
        Permitted::OneOf(list) => ends(&mut list.iter().copied()),
        Permitted::Ranges(ranges) => {
            let (low, high) = ends(&mut ranges.ranges.iter().flat_map(|(low, high)| [*low, *high]));
            // Including the ignored bits.
            let counted = u32::MAX >> ranges.ignored_bits;
            (low, high | i64::from(!counted))
        }
    }
}

/// The permitted values as text; empty when the type or the names of the values define them.
pub fn permitted(parameter: &Parameter) -> String {
    match parameter.permitted {
        Permitted::Any | Permitted::Named => String::new(),
        Permitted::Range(low, high) => format!("{low}..{high}"),
        Permitted::OneOf(list) => {
            let list: Vec<String> = list.iter().map(u32::to_string).collect();
            list.join(", ")
        }
        Permitted::Ranges(ranges) if !ranges.text.is_empty() => ranges.text.to_owned(),
        Permitted::Ranges(ranges) => {
            let ranges: Vec<String> = ranges
                .ranges
                .iter()
                .map(|(low, high)| format!("{low}..{high}"))
                .collect();
            ranges.join(", ")
        }
    }
}

/// The names of values, for example `0 = off, 1 = on`.
pub fn named(meanings: &[Meaning]) -> String {
    let names: Vec<String> = meanings
        .iter()
        .map(|(number, name)| format!("{number} = {name}"))
        .collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::param::Ranges;

    #[test]
    fn value_has_the_decimals_of_the_number() {
        let angle = Number {
            decimals: 2,
            ..Number::any("Angle", DataType::I16)
        };
        assert_eq!(angle.value(-9000), "-90.00");
        assert_eq!(Number::any("Counter", DataType::U16).value(7), "7");
    }

    #[test]
    fn limits_are_those_of_the_permitted_values() {
        let of = |permitted| {
            limits(&Parameter {
                permitted,
                meanings: &[(3, "three"), (1, "one")],
                data_type: DataType::I8,
                ..Parameter::plain()
            })
        };
        assert_eq!(of(Permitted::Any), (-128, 127));
        assert_eq!(of(Permitted::Range(-5, 7)), (-5, 7));
        assert_eq!(of(Permitted::Named), (1, 3));
        assert_eq!(of(Permitted::OneOf(&[10, 2])), (2, 10));
        const RANGES: Ranges = Ranges {
            text: "",
            ignored_bits: 1,
            ranges: &[(5, 7), (1, 2)],
        };
        assert_eq!(of(Permitted::Ranges(&RANGES)), (1, 0x8000_0007));
    }

    #[test]
    fn permitted_values_are_listed_unless_they_have_names() {
        let of = |permitted| permitted_of(permitted);
        fn permitted_of(permitted: Permitted) -> String {
            super::permitted(&Parameter {
                permitted,
                ..Parameter::plain()
            })
        }
        assert_eq!(of(Permitted::Named), "");
        assert_eq!(of(Permitted::Range(1, 127)), "1..127");
        assert_eq!(of(Permitted::OneOf(&[1, 10])), "1, 10");
        const RANGES: Ranges = Ranges {
            text: "",
            ignored_bits: 0,
            ranges: &[(0, 240), (252, 255)],
        };
        assert_eq!(of(Permitted::Ranges(&RANGES)), "0..240, 252..255");
        assert_eq!(named(&[(0, "off"), (1, "on")]), "0 = off, 1 = on");
    }
}
