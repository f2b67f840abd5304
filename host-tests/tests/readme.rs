//! What the README says of the models is what their tables say.

use host_tests::descriptors::parameters;
use host_tests::models::MODELS;
use plumbline::model::is2::TwoAxes;

const README: &str = include_str!("../../README.md");

#[test]
fn the_parameter_table_is_the_models_own() {
    let (_, rest) = README
        .split_once("checked by host-tests/tests/readme.rs -->\n")
        .expect("the table's beginning");
    let (table, _) = rest.split_once("<!-- end -->").expect("the table's end");
    let expected = parameters::<TwoAxes>();
    assert_eq!(
        table, expected,
        "the README should have this table:\n\n{expected}"
    );
}

#[test]
fn every_model_is_listed() {
    for model in MODELS {
        assert!(
            README.contains(&format!("| `{}` |", model.name)),
            "{}",
            model.name
        );
    }
}
