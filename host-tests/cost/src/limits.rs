//! The limits that a user relies on. They are numbers that only a decision changes; growth below them is the business of
//! [`recorded`](super::recorded).

use super::Report;
use super::products::MeasuredProduct;
use super::scenario::Phases;
use plumbline::model::catalog::{Product, Protocol, find};

/// The largest program in the flash of the Blue Pill, in bytes: what is left beside a bootloader and the two pages of records.
pub const FLASH: u64 = 53 * 1024;
/// Without a bootloader: the product with two protocols.
pub const FLASH_ALONE: u64 = 62 * 1024;

/// The bootloader of the Blue Pill without signatures, in bytes.
pub const BOOTLOADER: u64 = 6 * 1024;

/// The limit of the program of a product.
pub fn flash(product: &Product) -> u64 {
    match product.protocol {
        Protocol::Canopen(tables) if tables.j1939.is_some() => FLASH_ALONE,
        _ => FLASH,
    }
}

/// The RAM of the Blue Pill in bytes, and the part of it that the linker script leaves to the stack.
pub const RAM: u64 = 20 * 1024;
const STACK: u64 = 12 * 1024;

/// The messages of a product whose answers have a limit, and the longest time from the end of the message to the start of the answer in
/// ns. At 500 kbit/s, the intermission takes 6 us of it.
fn answers(product: &Product) -> (Messages, u64) {
    match product.protocol {
        Protocol::Fsc(_) => (Messages::All, 15_000),
        Protocol::Canopen(tables) if tables.j1939.is_some() => (Messages::All, 22_000),
        Protocol::Canopen(_) | Protocol::J1939(_) => (Messages::All, 20_000),
        Protocol::Devicenet(_) => (Messages::Polls, 26_000),
    }
}

/// The longest time from power-up to the first frame in ns, which is sent with the first measurement, for each product.
const BOOT: u64 = 66_000_000;

/// The longest time that a half-word takes (DS5319, flash memory characteristics) in ns. An answer while a save programs is late by at
/// most the half-word that is being programmed.
const HALF_WORD: u64 = 70_000;

/// The messages whose answers have a limit.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Messages {
    /// All requests of the protocol, and SYNC.
    All,
    /// Polls, but no other requests.
    Polls,
}

/// The figures of this product that exceed their limit, and those with a limit that are not measured. The products on the Nucleo have
/// no limits.
pub fn exceeded(report: &Report) -> Vec<String> {
    let mut check = Check {
        report,
        complaints: Vec::new(),
    };
    let product = find(report.model);
    if let Some(product) = product {
        let measured = MeasuredProduct::of(product);
        check.size(product);
        check.starts();
        check.answers(product, &measured);
        check.saves(&measured);
    }
    check.complaints
}

struct Check<'a> {
    report: &'a Report,
    complaints: Vec<String>,
}

impl Check<'_> {
    fn complain(&mut self, what: String) {
        let complaint = format!("{}, {what}", self.report.model);
        self.complaints.push(complaint);
    }

    /// The figure of a row, which the product must have.
    fn figure(&mut self, row: &str) -> Option<u64> {
        let figure = self.report.figure(row);
        if figure.is_none() {
            self.complain(format!("{row}: not measured"));
        }
        figure
    }

    fn at_most(&mut self, row: &str, limit: u64) {
        if let Some(figure) = self.figure(row)
            && figure > limit
        {
            self.complain(format!("{row}: {figure} exceeds the limit {limit}"));
        }
    }

    fn size(&mut self, product: &Product) {
        self.at_most("flash", flash(product));
        self.at_most("ram", RAM);
        self.at_most("stack", STACK);
    }

    fn starts(&mut self) {
        self.at_most("boot_time", BOOT);
    }

    fn answers(&mut self, product: &Product, measured: &MeasuredProduct) {
        let (messages, limit) = answers(product);
        let mut rows = vec![("sync_worst", "read_worst")];
        if self.report.sweep == Phases::All {
            if measured.set_point.is_some() {
                rows.push(("heater_worst", "heater_read_worst"));
            }
            if measured.swept {
                rows.push(("led_worst", "led_read_worst"));
            }
        }
        for (sync, read) in rows {
            self.at_most(sync, limit);
            if messages == Messages::All {
                self.at_most(read, limit);
            }
        }
    }

    fn saves(&mut self, product: &MeasuredProduct) {
        if !product.swept || self.report.sweep == Phases::Few {
            return;
        }
        for (saving, otherwise) in [
            ("save_worst", "sync_worst"),
            ("save_read_worst", "read_worst"),
        ] {
            if let Some(otherwise) = self.figure(otherwise) {
                self.at_most(saving, otherwise + HALF_WORD);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::{ROWS, Unit};

    /// A report whose times and sizes are far below the limits.
    fn report(model: &'static str, sweep: Phases, changed: &[(&str, u64)]) -> Report {
        let figure = |key: &str| changed.iter().find(|(row, _)| *row == key);
        Report {
            model,
            figures: ROWS
                .iter()
                .filter(|row| row.unit != Unit::Saves)
                .map(|row| (row, figure(row.key).map_or(1_000, |(_, figure)| *figure)))
                .collect(),
            phases: Default::default(),
            sweep,
            speed: 1.0,
        }
    }

    #[test]
    fn figure_above_limit_is_reported() {
        for (model, row, limit) in [
            ("is2", "sync_worst", 15_000),
            ("is1tk", "heater_read_worst", 15_000),
            ("jn2101", "led_worst", 20_000),
            ("ims360", "read_worst", 22_000),
            ("tiltix080", "sync_worst", 26_000),
            ("is1", "flash", 54_272),
            ("ims360", "flash", 63_488),
            ("is1", "ram", 20_480),
            ("is1", "stack", 12_288),
            ("tiltix360", "boot_time", 66_000_000),
            ("ims360", "save_worst", 71_000),
        ] {
            let at = report(model, Phases::All, &[(row, limit)]);
            assert!(exceeded(&at).is_empty(), "{:?}", exceeded(&at));
            let above = report(model, Phases::All, &[(row, limit + 1)]);
            let complaint = format!("{model}, {row}: {} exceeds the limit {limit}", limit + 1);
            assert_eq!(exceeded(&above), [complaint]);
        }
    }

    #[test]
    fn figure_with_a_limit_must_be_measured() {
        let mut report = report("is2tk", Phases::All, &[]);
        report.figures.retain(|(row, _)| row.key != "heater_worst");
        assert_eq!(exceeded(&report), ["is2tk, heater_worst: not measured"]);
        report.sweep = Phases::Few;
        assert!(exceeded(&report).is_empty());
    }
}
