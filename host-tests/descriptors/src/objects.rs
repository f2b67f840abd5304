//! The description of a CANopen object as text: name, unit, permitted values, limits and factory value.

use super::number::{Number, named, permitted};
use plumbline::canopen::dictionary::{Access, Object, Service, Target, Use};
use plumbline::canopen::lss::UNCONFIGURED;
use plumbline::model::catalog::{Product, Protocol};
use plumbline::model::listing::canopen::Variant;
use plumbline::param::{DataType, Parameter, Permitted, Persistence, Ranges};

/// An object with its description in the tables of the product.
#[derive(Clone, Copy, Debug)]
pub struct Described<'a> {
    pub object: &'a Object,
    product: &'a Product,
    variant: Option<&'a Variant>,
}

/// The object with the COB-ID of emergency messages, which can have 29 bits.
const EMCY_COB_ID: u16 = 0x1014;

impl<'a> Described<'a> {
    /// All objects of a product, or of a variant of it, each with its description.
    pub fn all(
        objects: &'a [Object],
        product: &'a Product,
        variant: Option<&'a Variant>,
    ) -> Vec<Self> {
        let of = |object| Self {
            object,
            product,
            variant,
        };
        objects.iter().map(of).collect()
    }

    /// The parameter that a write changes.
    pub fn parameter(&self) -> Option<&'a Parameter> {
        match self.object.target {
            Target::Parameter(id)
            | Target::CobId(id)
            | Target::FreeCobId(id)
            | Target::Command(id, _) => self.product.parameters.get(usize::from(id.0)),
            _ => None,
        }
    }

    /// The description of the number; empty for services and constants.
    fn number(&self) -> Number {
        let value = match self.object.target {
            Target::Value(id) => self.product.quantities.get(usize::from(id.0)),
            _ => None,
        };
        let number = self
            .parameter()
            .map(Number::from)
            .or(value.map(Number::from));
        number.unwrap_or_else(|| Number::any(self.object.name, self.object.data_type))
    }

    /// The name of the parameter or the quantity, or else of the object.
    pub fn name(&self) -> &'static str {
        self.number().name
    }

    /// The unit; empty without one.
    pub fn unit(&self) -> &'static str {
        self.number().unit
    }

    /// The unit of the number 1 on the bus, for example `0.01 deg`; empty without a unit.
    pub fn unit_of_one(&self) -> String {
        let number = self.number();
        match number.decimals {
            0 => number.unit.to_owned(),
            _ => format!("{} {}", number.value(1), number.unit)
                .trim_end()
                .to_owned(),
        }
    }

    /// The type in the object dictionary.
    pub fn data_type(&self) -> DataType {
        let Product {
            parameters,
            quantities,
            ..
        } = self.product;
        self.object.data_type(parameters, quantities)
    }

    /// The permitted values and their meaning; empty when the type is sufficient.
    pub fn permitted(&self) -> String {
        if matches!(self.object.target, Target::CobId(_)) && self.object.access.is_writable() {
            return "this identifier, with or without bits 31 and 30".to_owned();
        }
        if matches!(self.object.target, Target::FreeCobId(_)) {
            return match self.object.index {
                EMCY_COB_ID => {
                    "11-bit identifier that is free, or with bit 29 any of 29 bits; bit 31 = off"
                }
                _ => "11-bit identifier that is free; bit 31 = off, bit 30 = no remote frames",
            }
            .to_owned();
        }
        let Some(parameter) = self.parameter() else {
            return service(self.object.target).0.to_owned();
        };
        let parts = [permitted(parameter), named(parameter.meanings)];
        let parts: Vec<_> = parts
            .iter()
            .filter(|part| !part.is_empty())
            .cloned()
            .collect();
        parts.join("; ")
    }

    /// The lowest and the highest value that can be written; None for the limits of the type.
    ///
    /// The factory value is within these limits, because it can be read, though not always written.
    pub fn limits(&self) -> Option<(i64, i64)> {
        if !self.object.access.is_writable() {
            return None;
        }
        let Some(parameter) = self.parameter() else {
            return service(self.object.target).1;
        };
        if let Permitted::Ranges(ranges) = parameter.permitted
            && self.is_assigned_by_lss(parameter)
        {
            return assigned(ranges);
        }
        if matches!(parameter.permitted, Permitted::Any | Permitted::Ranges(_)) {
            return None;
        }
        let (low, high) = Number::from(parameter).limits;
        if parameter.data_type.is_real() {
            return Some((low, high));
        }
        let factory = parameter.data_type.value(parameter.factory);
        Some((low.min(factory), high.max(factory)))
    }

    /// True for the node-ID of a product with layer setting services, of which SDO cannot write every value.
    fn is_assigned_by_lss(&self, parameter: &Parameter) -> bool {
        match &self.product.protocol {
            Protocol::Canopen(tables) => tables.lss && tables.node_id == parameter.id,
            _ => false,
        }
    }

    /// The factory value of a parameter, which a variant can replace.
    fn factory_of(&self, parameter: &Parameter) -> u32 {
        let own = self.variant.and_then(|variant| {
            let mut values = [variant.selector, variant.mark]
                .into_iter()
                .chain(variant.defaults.iter().copied());
            values.find(|(id, _)| *id == parameter.id)
        });
        own.map_or(parameter.factory, |(_, value)| value)
    }

    /// The bits of the factory value of a parameter of 64 bits or with a real number; None for others.
    pub fn bits(&self) -> Option<u64> {
        let parameter = self.parameter()?;
        let lower = u64::from(self.factory_of(parameter));
        if !parameter.data_type.is_wide() {
            return parameter.data_type.is_real().then_some(lower);
        }
        let upper = self
            .product
            .parameters
            .get(usize::from(parameter.id.0) + 1)?;
        Some(u64::from(self.factory_of(upper)) << 32 | lower)
    }

    /// The factory value, without the node-ID; None for texts, for measured or derived values and for values that differ between units.
    pub fn factory(&self) -> Option<u32> {
        match self.object.target {
            Target::Constant(number) | Target::NodeRelative(number) => Some(number),
            Target::Value(id) => {
                let quantity = self.product.quantities.get(usize::from(id.0))?;
                // A state, not a measured value: no operation has been started yet.
                quantity.unit.is_empty().then_some(0)
            }
            Target::Text(_) | Target::Service(Service::SerialNumber) | Target::Own(Use::Data) => {
                None
            }
            // The device makes it on command.
            Target::Service(service) | Target::Own(Use::Service(service))
                if matches!(service, Service::StoreGroup | Service::RestoreGroup) =>
            {
                Some(1)
            }
            // There is no error yet, and no save is running.
            Target::Service(_) | Target::Own(_) => Some(0),
            Target::Parameter(_)
            | Target::CobId(_)
            | Target::FreeCobId(_)
            | Target::Command(..) => self.parameter().map(|parameter| self.factory_of(parameter)),
        }
    }

    /// False when a tool must not write it by itself: for a command, and for what moves the node to another address, bit rate or
    /// protocol.
    pub fn is_downloaded(&self) -> bool {
        !self.is_command() && !self.moves_the_node()
    }

    fn moves_the_node(&self) -> bool {
        let Protocol::Canopen(tables) = &self.product.protocol else {
            return false;
        };
        let selector = tables.j1939.and_then(|tables| tables.selector);
        let ids = [
            Some(tables.node_id),
            Some(tables.bit_rate),
            selector.map(|(id, _)| id),
        ];
        self.parameter()
            .is_some_and(|parameter| ids.contains(&Some(parameter.id)))
    }

    /// True when a write does more than to change the value.
    fn is_command(&self) -> bool {
        // It cannot be read, so nothing can be written back.
        if self.object.access == Access::Wo {
            return true;
        }
        match self.object.target {
            Target::Service(_) | Target::Own(_) => self.object.access.is_writable(),
            Target::Command(..) => true,
            // A write refers to the present position.
            Target::Parameter(_) => self
                .parameter()
                .is_some_and(|parameter| parameter.persistence == Persistence::AtOnce),
            _ => false,
        }
    }

    /// True when the node-ID is added to the factory value.
    pub fn is_node_relative(&self) -> bool {
        matches!(
            self.object.target,
            Target::NodeRelative(_) | Target::CobId(_) | Target::FreeCobId(_)
        )
    }

    /// True when it is stored.
    pub fn is_stored(&self) -> bool {
        let stored = |parameter: &Parameter| parameter.persistence != Persistence::Volatile;
        self.parameter().is_some_and(stored)
    }
}

/// The lowest and the highest node-ID that SDO can write.
fn assigned(ranges: &Ranges) -> Option<(i64, i64)> {
    let is_written = |(low, _): &&(u32, u32)| *low != u32::from(UNCONFIGURED);
    let written = ranges.ranges.iter().filter(is_written);
    let low = written.clone().map(|(low, _)| *low).min()?;
    let high = written.map(|(_, high)| *high).max()?;
    Some((low.into(), high.into()))
}

/// The values that can be written to a service, as text, and the limits.
fn service(target: Target) -> (&'static str, Option<(i64, i64)>) {
    let service = match target {
        Target::Service(service) | Target::Own(Use::Service(service)) => service,
        Target::Own(Use::Command(command)) => return (command.numbers, Some(command.limits)),
        _ => return ("", None),
    };
    match service {
        Service::ErrorCount => ("0 clears", None),
        Service::Store | Service::StoreGroup => ("\"save\"", None),
        Service::RestoreCommunication | Service::RestoreGroup => ("\"load\"", None),
        Service::ErrorRegister
        | Service::ErrorHistory
        | Service::ErrorHistoryOrZero
        | Service::SerialNumber => ("", None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::model::catalog::{Protocol, find};

    fn jn2101(index: u16, sub: u8, judge: impl Fn(Described)) {
        described("jn2101", index, sub, judge);
    }

    fn described(name: &str, index: u16, sub: u8, judge: impl Fn(Described)) {
        let product = find(name).unwrap();
        let Protocol::Canopen(tables) = &product.protocol else {
            panic!("{name} speaks CANopen")
        };
        let objects = Described::all(tables.objects, product, None);
        let at =
            |described: &&Described| (described.object.index, described.object.sub) == (index, sub);
        judge(*objects.iter().find(at).unwrap());
    }

    #[test]
    fn factory_value_is_within_limits() {
        // 1 requests a factory reset; 0 means that none has been made.
        jn2101(0x207F, 0, |object| {
            assert_eq!((object.limits(), object.factory()), (Some((0, 1)), Some(0)));
        });
        jn2101(0x2000, 0, |object| {
            assert_eq!(object.limits(), Some((1, 127)));
            assert_eq!(object.factory(), Some(10));
        });
        jn2101(0x100C, 0, |object| assert_eq!(object.limits(), None));
    }

    #[test]
    fn permitted_values_are_listed_unless_named() {
        jn2101(0x1010, 1, |object| {
            assert_eq!(object.permitted(), "\"save\"")
        });
        jn2101(0x6000, 0, |object| {
            assert_eq!(object.permitted(), "1, 10, 100, 1000")
        });
        jn2101(0x1014, 0, |object| assert_eq!(object.permitted(), ""));
        jn2101(0x1800, 1, |object| {
            let expected = "this identifier, with or without bits 31 and 30";
            assert_eq!(object.permitted(), expected);
        });
        jn2101(0x1029, 1, |object| {
            let expected = "0 = pre-operational, 1 = no change of state, 2 = stopped";
            assert_eq!(object.permitted(), expected);
        });
    }

    #[test]
    fn free_cob_id_is_described_by_its_flags() {
        for (index, sub, expected) in [
            (
                0x1801,
                1,
                "11-bit identifier that is free; bit 31 = off, bit 30 = no remote frames",
            ),
            (
                0x1014,
                0,
                "11-bit identifier that is free, or with bit 29 any of 29 bits; bit 31 = off",
            ),
        ] {
            described("ims360", index, sub, |object| {
                assert_eq!(object.permitted(), expected);
            });
        }
    }

    #[test]
    fn read_only_parameter_has_no_limits() {
        described("ims360", 0x1000, 0, |object| {
            assert_eq!(object.limits(), None);
        });
        described("ims360", 0x2002, 0, |object| {
            assert_eq!(object.limits(), Some((1, 126)));
        });
    }

    #[test]
    fn unit_of_one_has_the_decimals_of_the_number() {
        described("ims360", 0x6110, 0, |object| {
            assert_eq!(object.unit_of_one(), "0.01 deg");
        });
        jn2101(0x6000, 0, |object| {
            assert_eq!(object.unit_of_one(), "0.001 deg");
        });
    }

    #[test]
    fn measured_value_has_no_factory_value() {
        jn2101(0x6010, 0, |object| assert_eq!(object.factory(), None));
        jn2101(0x4004, 2, |object| assert_eq!(object.factory(), Some(0)));
    }
}
