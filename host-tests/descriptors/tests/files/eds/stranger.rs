//! The data sheet of a product that is not in the catalogue, with another manufacturer, numbers of 64 bits and real numbers.

#[path = "../../../../../core/tests/wire/stranger/product.rs"]
mod product;

use super::NOTHING;
use super::rules::complaints;
use super::sheet::Sheet;
use descriptors::describe;
use plumbline::model::listing::{Article, Product};
use product::StrangerProduct;

fn text() -> String {
    let article = Article {
        name: "TILT-1",
        number: "4711",
    };
    describe(&Product::canopen::<StrangerProduct>(
        "stranger", "Stranger", article,
    ))
    .text
}

#[test]
fn eds_of_a_product_outside_the_catalogue_is_valid() {
    assert_eq!(complaints(&text()), NOTHING);
}

#[test]
fn eds_has_types_and_factory_values_of_64_bits_and_real_numbers() {
    let text = text();
    let sheet = Sheet::parse(&text);
    for (section, data_type, default) in [
        ("2200", "0x001B", Some("0x10000000000")),
        ("2201", "0x0015", Some("-5")),
        ("2202", "0x0008", Some("2.0")),
        ("2203", "0x0011", Some("0.25")),
        ("5000", "0x0008", None),
        ("5002", "0x0011", None),
    ] {
        assert_eq!(sheet.get(section, "DataType"), Some(data_type), "{section}");
        assert_eq!(sheet.get(section, "DefaultValue"), default, "{section}");
    }
    assert_eq!(sheet.number("2202", "LowLimit"), Some(-90));
    assert_eq!(sheet.number("2202", "HighLimit"), Some(90));
    assert_eq!(sheet.get("1A01sub1", "DefaultValue"), Some("0x50010040"));
}

#[test]
fn eds_has_groups_heartbeat_consumer_and_lss() {
    let text = text();
    let sheet = Sheet::parse(&text);
    assert_eq!(sheet.number("1010sub0", "DefaultValue"), Some(5));
    assert_eq!(sheet.number("1011sub5", "DefaultValue"), None);
    assert_eq!(sheet.number("1016", "SubNumber"), Some(4));
    assert_eq!(sheet.number("1016sub3", "HighLimit"), Some(0x00FF_FFFF));
    assert_eq!(sheet.number("DeviceInfo", "LSS_Supported"), Some(1));
    assert_eq!(sheet.number("2000", "HighLimit"), Some(127));
}
