//! What the README says of the models is what their tables say.

use descriptors::{object_table, parameters};
use plumbline::model::catalog::{PRODUCTS, Protocol, find};

const README: &str = include_str!("../../README.md");

/// Asserts that the README's block of this name is what the tables give.
#[track_caller]
fn assert_block(name: &str, expected: &str) {
    let head = format!(
        "<!-- {name}: written from the model's table, checked by host-tests/tests/readme.rs -->\n"
    );
    let block = README
        .split_once(&head)
        .and_then(|(_, rest)| rest.split_once("<!-- end -->"))
        .map(|(block, _)| block);
    assert_eq!(
        block,
        Some(expected),
        "the README should have this block:\n\n{head}{expected}<!-- end -->"
    );
}

#[test]
fn the_parameter_table_is_the_models_own() {
    let product = find("is2").expect("a product");
    let Protocol::Fsc(tables) = &product.protocol else {
        panic!("it speaks FSC")
    };
    assert_block("parameters of is2", &parameters(product, tables));
}

#[test]
fn the_object_table_is_the_models_own() {
    let product = find("jn2101").expect("a product");
    let Protocol::Canopen(tables) = &product.protocol else {
        panic!("it speaks CANopen")
    };
    assert_block("objects of jn2101", &object_table(product, tables));
}

#[test]
fn every_model_is_listed() {
    for product in PRODUCTS {
        assert!(
            README.contains(&format!("| `{}` |", product.name)),
            "{}",
            product.name
        );
    }
}
