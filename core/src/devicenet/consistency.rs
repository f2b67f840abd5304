//! Checks that the description of a product is consistent. The compiler evaluates them where the tables are written. A mistake is a compile
//! error that names the row.

use super::fragment::{PRODUCED, SHORTEST};
use super::identifiers::MAC_MAX;
use super::projection::WORDS;
use super::table::{Assembly, Attribute, Identity, Object, Own, Product, Roles, Source};
use crate::application::{Application, Values};
use crate::can::BitRate;
use crate::mistake::Mistake;
use crate::param::projection::{check_quantities, exists, has_quantity, highest, permits};
use crate::param::{DataType, Parameter, ParameterId, Persistence, Quantity, Table};
use crate::walk::{at, each};

/// The longest product name: its response has the service and the length besides the characters.
const NAME_MAX: usize = PRODUCED - 2;

/// The bit rates of DeviceNet by their codes.
const BIT_RATES: [BitRate; 3] = [BitRate::K125, BitRate::K250, BitRate::K500];

/// Checks the tables of a product.
#[track_caller]
pub const fn check<P: Product>() {
    let parameters = <<P::Application as Application>::Table as Table>::PARAMETERS;
    let quantities = <P::Application as Application>::QUANTITIES;
    check_quantities(
        quantities,
        <<P::Application as Application>::Values as Values>::CAPACITY,
    );
    check_identity(&P::IDENTITY);
    check_objects(P::OBJECTS, parameters, quantities);
    check_own(P::OBJECTS, P::OWN);
    check_assemblies(P::ASSEMBLIES, quantities);
    check_roles(&P::ROLES, P::ASSEMBLIES, parameters);
}

#[track_caller]
const fn check_identity(identity: &Identity) {
    let name = identity.name;
    Mistake::item("IDENTITY").unless(
        name.len() >= SHORTEST && name.len() <= NAME_MAX && name.is_ascii(),
        "a product name has 5 to 32 characters of ASCII",
    );
    Mistake::item("IDENTITY").unless(identity.product_code > 0, "the product code is at least 1");
    let (major, minor) = identity.revision;
    Mistake::item("IDENTITY").unless(
        major >= 1 && major <= 127 && minor >= 1,
        "the revision is 1 to 127, 1 to 255",
    );
}

/// Checks the objects of the vendor and their attributes.
#[track_caller]
const fn check_objects(objects: &[Object], parameters: &[Parameter], quantities: &[Quantity]) {
    let mut count = 0;
    each!(place, object in objects => {
        let mistake = object.mistake();
        mistake.unless(
            object.class >= 0x64 && object.class <= 0xC7,
            "the class of a vendor is 64h to C7h",
        );
        mistake.unless(
            object.revision >= 1 && object.revision <= 255,
            "the revision of a class is 1 to 255",
        );
        each!(other in objects.split_at(place).0 => {
            mistake.unless(other.class != object.class, "another object has this class");
        });
        let mut last = 0;
        each!(attribute in object.attributes => {
            let mistake = attribute.mistake(object.class);
            mistake.unless(
                attribute.number > last,
                "the attributes of an object must be sorted by number, from 1 on",
            );
            last = attribute.number;
            check_attribute(mistake, attribute, parameters, quantities);
        });
        count += object.attributes.len();
        mistake.unless(count < 256, "all objects have at most 255 attributes");
    });
}

#[track_caller]
const fn check_attribute(
    mistake: Mistake,
    attribute: &Attribute,
    parameters: &[Parameter],
    quantities: &[Quantity],
) {
    match attribute.source {
        Source::Parameter(id) => exists(mistake, parameters, id),
        Source::Value(id) => has_quantity(mistake, quantities, id),
        Source::Constant(data_type, number) => {
            let size = data_type.size();
            mistake.unless(
                size >= 4 || size > 0 && number >> (8 * size) == 0,
                "the constant must fit its type",
            );
        }
        Source::Own(_) => {}
    }
    let data_type = attribute.source.data_type(parameters, quantities);
    mistake.unless(data_type.size() > 0, "an attribute is a number");
    mistake.unless(!data_type.is_wide(), "an attribute has at most 32 bits");
    mistake.unless(
        !attribute.settable || matches!(attribute.source, Source::Parameter(_) | Source::Own(_)),
        "only a parameter or an own attribute is settable",
    );
}

/// Checks that each attribute with [`Source::Own`] has its functions.
#[track_caller]
const fn check_own<A: Application>(objects: &[Object], own: &[Own<A>]) {
    let mut rest = own;
    each!(object in objects => {
        each!(attribute in object.attributes => {
            if let Source::Own(_) = attribute.source {
                let mistake = attribute.mistake(object.class);
                let text = "OWN has no functions for this attribute, or not in the order of OBJECTS";
                let [first, others @ ..] = rest else {
                    mistake.text(text).fail();
                };
                mistake.unless(
                    first.class == object.class && first.attribute == attribute.number,
                    text,
                );
                rest = others;
            }
        });
    });
    if let [first, ..] = rest {
        Mistake::attribute(first.class, first.attribute)
            .text("OBJECTS has no own attribute for these functions")
            .fail();
    }
}

#[track_caller]
const fn check_assemblies(assemblies: &[Assembly], quantities: &[Quantity]) {
    Mistake::item("ASSEMBLIES").unless(!assemblies.is_empty(), "a product needs an assembly");
    each!(place, assembly in assemblies => {
        let mistake = assembly.mistake();
        mistake.unless(assembly.instance >= 1, "the instance is 1 to 255");
        mistake.unless(
            !assembly.words.is_empty() && assembly.words.len() <= WORDS,
            "an assembly has one to four words",
        );
        each!(other in assemblies.split_at(place).0 => {
            mistake.unless(
                other.instance != assembly.instance,
                "another assembly has this instance",
            );
        });
        each!(id in assembly.words => {
            has_quantity(mistake, quantities, *id);
            mistake.unless(
                at(quantities, id.0 as usize).data_type.size() == 2,
                "its words have 16 bits",
            );
        });
    });
}

/// Checks the parameters of the protocol, and the persistence of all parameters.
#[track_caller]
const fn check_roles(roles: &Roles, assemblies: &[Assembly], parameters: &[Parameter]) {
    Mistake::item("ROLES").unless(!roles.bit_rates.is_empty(), "a product needs a bit rate");
    each!(code, rate in roles.bit_rates => {
        Mistake::row("bit rate", code).unless(
            code < BIT_RATES.len() && *rate as u8 == *at(&BIT_RATES, code) as u8,
            "DeviceNet has the bit rates 125, 250 and 500 kbit/s with the codes 0, 1 and 2",
        );
    });
    check_role(parameters, roles.mac_id, MAC_MAX as u32);
    check_role(
        parameters,
        roles.baud_rate,
        roles.bit_rates.len() as u32 - 1,
    );
    check_role(parameters, roles.bus_off_interrupt, 1);
    check_role(parameters, roles.cos_delta, 255);
    check_selection(parameters, roles.polled_assembly, assemblies);
    check_selection(parameters, roles.cyclic_assembly, assemblies);
    each!(parameter in parameters => {
        parameter.mistake().unless(
            !matches!(parameter.persistence, Persistence::OnSave),
            "a parameter is stored when it is written, or never",
        );
    });
}

/// Checks that a parameter of the protocol is a byte that permits numbers up to `most` only.
#[track_caller]
const fn check_role(parameters: &[Parameter], id: ParameterId, most: u32) {
    exists(Mistake::item("ROLES"), parameters, id);
    let parameter = at(parameters, id.0 as usize);
    let mistake = parameter.mistake();
    mistake.unless(
        matches!(parameter.data_type, DataType::U8),
        "a parameter of the protocol is a byte",
    );
    if most < 255 && highest(parameter) != most {
        mistake
            .text("the highest permitted number is ")
            .number(highest(parameter))
            .text(", the protocol needs ")
            .number(most)
            .fail();
    }
}

/// Checks that a parameter permits exactly the instances of the assemblies.
#[track_caller]
const fn check_selection(parameters: &[Parameter], id: ParameterId, assemblies: &[Assembly]) {
    exists(Mistake::item("ROLES"), parameters, id);
    let parameter = at(parameters, id.0 as usize);
    let mut number = 0;
    while number <= 255 {
        let mut exists = false;
        each!(assembly in assemblies => { exists |= assembly.instance as u32 == number });
        if permits(parameter, number) != exists {
            parameter
                .mistake()
                .text("it must permit exactly the instances of ASSEMBLIES, see ")
                .number(number)
                .fail();
        }
        number += 1;
    }
}
