use super::*;
use plumbline::model::catalog::{PRODUCTS, find};
use std::collections::BTreeSet;

#[test]
fn names_are_unique_and_short_names_are_used() {
    for product in PRODUCTS {
        let sheet = Sheet::of(product);
        let names: BTreeSet<&str> = sheet
            .entries
            .iter()
            .map(|entry| entry.name.as_str())
            .collect();
        assert_eq!(names.len(), sheet.entries.len(), "{}", product.name);
        assert!(
            names.iter().all(|name| !name.is_empty()),
            "{}",
            product.name
        );
        for (id, name) in product.guide.short_names {
            assert_eq!(
                sheet.parameter(*id).map(|entry| entry.name.as_str()),
                Some(*name),
                "{}",
                product.name
            );
        }
    }
}

#[test]
fn guide_names_parameters_and_values_of_the_sheet() {
    for product in PRODUCTS {
        let sheet = Sheet::of(product);
        let guide = product.guide;
        assert!(!guide.angles.is_empty(), "{}", product.name);
        assert!(
            guide.angles.iter().all(|id| sheet.value(*id).is_some()),
            "{}",
            product.name
        );
        let groups = guide.groups.iter().flat_map(|(_, ids)| ids.iter());
        let writes = guide
            .zero
            .iter()
            .chain(guide.teach)
            .flat_map(|adjustment| adjustment.writes);
        let ids = groups.chain(writes.map(|(id, _)| id));
        for id in ids {
            assert!(
                sheet.parameter(*id).is_some_and(|entry| entry.writable),
                "{}",
                product.name
            );
        }
    }
}

#[test]
fn parameters_of_one_code_have_the_places_of_their_bytes() {
    let sheet = Sheet::of(find("is2").unwrap());
    let at = |name: &str| {
        sheet
            .entries
            .iter()
            .find(|entry| entry.name == name)
            .unwrap()
            .address
    };
    let filter = |offset| Address::Fsc {
        read: 0x17,
        write: Some(0x27),
        offset,
    };
    assert_eq!((at("cut-off"), at("filter-type")), (filter(0), filter(2)));
    let angles = |offset| Address::Fsc {
        read: 0x00,
        write: None,
        offset,
    };
    assert_eq!((at("angle-x"), at("angle-y")), (angles(0), angles(2)));
}

#[test]
fn settings_contain_no_commands_and_no_values() {
    let names = |product: &str| {
        let sheet = Sheet::of(find(product).unwrap());
        sheet
            .settings()
            .map(|entry| entry.name.clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(names("is2").len(), 11);
    let jn2101 = names("jn2101");
    for name in [
        "zero",
        "teach",
        "programming-key",
        "activate-self-test",
        "temperature",
        "serial-number",
    ] {
        assert!(!jn2101.iter().any(|own| own == name), "{name}");
    }
    assert!(jn2101.iter().any(|own| own == "node-id"));
    assert!(names("tiltix080").iter().any(|own| own == "mac-id"));
}
