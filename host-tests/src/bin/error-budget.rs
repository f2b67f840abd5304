//! Prints the error budget of the measuring elements, as in `firmware-stm32/ELEMENTS.md`.

fn main() {
    print!("{}", host_tests::error_budget::tables());
}
