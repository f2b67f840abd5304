//! Replays each recorded trace on the core. `tests/images/traces.rs` replays them on the images.
//!
//! `UPDATE=1 cargo test -p host-tests --test sensor traces::` writes the frames of the core into the traces. A new trace has only the frames
//! of the tester, the `T` lines.
#![cfg(target_os = "linux")]

use bench::NodeType;
use host_tests::trace::{Trace, recorded};
use plumbline::model::catalog::{PRODUCTS, bases};
use std::path::Path;

fn node_type(product: &str) -> NodeType {
    NodeType::find(product).expect("a product")
}

/// Writes the frames of the core into a trace.
fn record(path: &Path) {
    let text = std::fs::read_to_string(path).expect("a trace");
    let name = path.display();
    let trace: Trace = text
        .parse()
        .unwrap_or_else(|error| panic!("{name}: {error}"));
    let recorded = Trace::record(&text, &node_type(&trace.model), &recorded::scene);
    let recorded = recorded.unwrap_or_else(|error| panic!("{name}: {error}"));
    if recorded != text {
        std::fs::write(path, recorded).expect("the trace can be written");
    }
}

#[test]
fn core_passes_the_traces_of_each_product() {
    if std::env::var_os("UPDATE").is_some() {
        recorded::all().iter().for_each(|path| record(path));
    }
    for product in bases() {
        let traces = recorded::of(product.name);
        assert!(!traces.is_empty(), "{} has no trace", product.name);
    }
    for product in PRODUCTS {
        let node_type = node_type(product.name);
        let replay = |trace: Trace| trace.replay(&node_type, &recorded::scene);
        recorded::check(product.name, replay);
    }
}
