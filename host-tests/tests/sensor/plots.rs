//! The plots beside the model are those of the filters. `cargo run -p host-tests --bin plots` writes them.

use host_tests::plots::{folder, plots};

#[test]
fn plots_in_the_tree_are_up_to_date() {
    let plots = plots();
    for plot in &plots {
        let path = folder().join(&plot.file);
        let text = std::fs::read_to_string(&path)
            .unwrap_or_else(|error| panic!("cannot read {}: {error}", path.display()));
        assert!(
            text == plot.svg,
            "{} is out of date: cargo run -p host-tests --bin plots",
            path.display()
        );
    }
    let files = folder().read_dir().expect("the folder of the plots exists");
    assert_eq!(files.count(), plots.len(), "a file is not a plot");
}

#[test]
fn every_plot_names_its_axes_and_lines() {
    for plot in plots() {
        for text in [
            ">time / s<",
            ">longitudinal angle / deg<",
            ">true angle<",
            ">low-pass, critically damped, 3 Hz:",
            ">Kalman filter, R = 10, Q = 0.001:",
        ] {
            assert!(plot.svg.contains(text), "{}: {text}", plot.file);
        }
    }
}
