//! Mistakes in a driver are errors of the compiler, as the page of `node::driver` says.

use crate::compile_with;

const ONE_THREAD: &str = include_str!("../../../core/examples/driver_one_thread.rs");
const TWO_PRIORITIES: &str = include_str!("../../../core/examples/driver_two_priorities.rs");

/// Texts of an example, and the other texts in their place.
type Changes = &'static [(&'static str, &'static str)];

/// The changes and the message.
#[rustfmt::skip]
const ONE: &[(Changes, &str)] = &[
    (&[("    fn recover(&mut self) {\n        self.event = Some(BusEvent::State(BusState::Active));\n    }\n", "")], "error[E0046]: not all trait items implemented, missing: `recover`"),
    (&[("    fn event(&mut self) -> Option<BusEvent> {\n        self.event.take()\n    }\n", "")], "error[E0046]: not all trait items implemented, missing: `event`"),
    (&[("    fn stored(&mut self) -> Option<Result<(), StoreError>> {\n        Some(Err(StoreError))\n    }\n", "")], "error[E0046]: not all trait items implemented, missing: `stored`"),
    (&[("    fn restart(&mut self, _kept: u32) {}\n", "")], "error[E0046]: not all trait items implemented, missing: `restart`"),
    (&[("        Some(Err(StoreError))\n", "")], "error[E0308]: mismatched types"),
    (&[("println!(\"{output:?}\");", "match output { Output::Leds(_) | Output::Termination(_) | Output::Heater(_) => {} }")], "error[E0004]: non-exhaustive patterns: `plumbline::node::driver::Output::SelfTest` not covered"),
    (&[("while driver.turn(&mut Board) {}", "driver.turn(&mut Board);")], "error: unused return value of `Driver::<S>::turn` that must be used"),
    (&[("let mut driver", "plumbline::node::Node::poll(&mut node, Instant::from_ticks(0));\n    let mut driver")], "error: unused return value of `plumbline::node::Node::poll` that must be used"),
    (&[("fn main() {", "fn main() {\n    Controller::change(&mut Wire::default());")], "error: unused `Change` that must be used"),
    (&[("fn main() {", "fn main() {\n    Wire::default().event().unwrap();")], "error: unused `BusEvent` that must be used"),
];

#[rustfmt::skip]
const TWO: &[(Changes, &str)] = &[
    (&[("let mut driver = Driver::new(TwoPriorities::new(acquisition, &memory, Board));",
        "let other = Box::leak(Box::new(plumbline::model::gemac::is2::Is2::INITIAL));\n    let (_, other) = other.halves();\n    let mut driver = Driver::new(TwoPriorities::new(other, &memory, Board));")],
        "error[E0271]: type mismatch resolving `<N as ProductNode>::Application"),
    (&[("Mutex<(", "std::cell::RefCell<("), ("self.0.lock().expect(\"no panic\")", "self.0.borrow_mut()"), ("Mutex::new(", "std::cell::RefCell::new("), ("use std::sync::Mutex;", "")],
        "error[E0277]: `RefCell<"),
];

fn check(name: &str, driver: &str, mistakes: &[(Changes, &str)]) {
    let errors = compile_with(name, driver, "-Dunused-must-use");
    assert!(!errors.contains("error"), "without mistakes: {errors}");
    for (number, (changes, message)) in mistakes.iter().enumerate() {
        let mistaken = changes
            .iter()
            .fold(driver.to_string(), |driver, (text, other)| {
                assert!(driver.contains(text), "{text}");
                driver.replacen(text, other, 1)
            });
        let errors = compile_with(&format!("{name}_{number}"), &mistaken, "-Dunused-must-use");
        assert!(errors.contains(message), "{message}\n{errors}");
    }
}

#[test]
fn each_mistake_of_a_driver_with_one_thread_is_an_error() {
    check("driver", ONE_THREAD, ONE);
}

#[test]
fn each_mistake_of_a_driver_with_two_priorities_is_an_error() {
    check("drivers", TWO_PRIORITIES, TWO);
}
