//! The part of the project that a byte of flash or static RAM belongs to.

use super::{Image, Symbol};
use object::SectionKind;
use plumbline::model::catalog;
use std::fmt;

/// A part of the project.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Part {
    /// The crate plumbline: sensors, protocols, measurement, store.
    Core,
    /// The code of the firmware around it.
    Driver,
    /// Hardware drivers and other dependencies.
    Libraries,
    /// The compiler's runtime, and the startup code.
    Runtime,
    /// The vector table at the start of flash.
    Vectors,
    /// Constants that the compiler has merged or that have no name.
    Constants,
    /// Gaps that no symbol covers.
    Padding,
}

impl Part {
    /// All parts, in the order of tables.
    pub const ALL: [Self; 7] = [
        Self::Core,
        Self::Driver,
        Self::Libraries,
        Self::Runtime,
        Self::Vectors,
        Self::Constants,
        Self::Padding,
    ];

    /// The part of a symbol, by its demangled name.
    fn of(name: &str) -> Self {
        // Generic code of the standard library belongs to the crate that instantiated it.
        let mut crates = crates(name).filter(|name| !matches!(*name, "core" | "alloc" | "std"));
        match crates.next() {
            Some("plumbline") => Self::Core,
            // The panic handler belongs to the firmware but has a name of the compiler.
            Some("firmware_stm32" | "__rustc") => Self::Driver,
            // The program of a product.
            Some(name) if catalog::find(name).is_some() => Self::Driver,
            Some("compiler_builtins" | "cortex_m_rt") => Self::Runtime,
            Some(_) => Self::Libraries,
            None if name.contains("::") => Self::Runtime,
            None => Self::of_plain(name),
        }
    }

    /// The part of a symbol with an unmangled name.
    fn of_plain(name: &str) -> Self {
        match name {
            "CORE_PERIPHERALS" | "DEVICE_PERIPHERALS" | "_SEGGER_RTT" => Self::Libraries,
            // cortex-m-rt
            "Reset"
            | "HardFault"
            | "HardFault_"
            | "HardFaultTrampoline"
            | "DefaultHandler"
            | "DefaultHandler_"
            | "DefaultPreInit" => Self::Runtime,
            _ if name.starts_with(".Lanon") => Self::Constants,
            _ if name.starts_with("__") || name.starts_with("mem") => Self::Runtime,
            // main and the interrupts
            _ => Self::Driver,
        }
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Core => "core",
            Self::Driver => "driver",
            Self::Libraries => "libraries",
            Self::Runtime => "runtime",
            Self::Vectors => "vectors",
            Self::Constants => "constants",
            Self::Padding => "padding",
        })
    }
}

/// The crates in a name, in order: words at the start of a path.
fn crates(name: &str) -> impl Iterator<Item = &str> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    name.match_indices("::").filter_map(move |(end, _)| {
        let before = &name[..end];
        let word = before.trim_end_matches(is_word);
        let is_first = !word.ends_with("::") && word.len() < before.len();
        is_first.then(|| &before[word.len()..])
    })
}

/// The bytes of flash and RAM of each part.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Shares {
    flash: [u64; Part::ALL.len()],
    ram: [u64; Part::ALL.len()],
}

impl Shares {
    pub(super) fn of(image: &Image) -> Self {
        let mut shares = Self::default();
        for segment in &image.segments {
            let length = segment.bytes.len() as u32;
            add(&mut shares.flash, image, segment.address, length);
        }
        for section in image.sections.iter().filter(|section| section.is_ram()) {
            add(&mut shares.ram, image, section.address, section.size);
        }
        shares
    }

    /// The bytes of a part in flash.
    pub fn flash(&self, part: Part) -> u64 {
        self.flash[part as usize]
    }

    /// The bytes of a part in static RAM.
    pub fn ram(&self, part: Part) -> u64 {
        self.ram[part as usize]
    }
}

/// Adds each byte of an area to its part.
fn add(counts: &mut [u64; Part::ALL.len()], image: &Image, address: u32, length: u32) {
    let mut parts = vec![None; length as usize];
    // A byte covered by two symbols belongs to the one that begins first, then to the larger one.
    for Symbol {
        address: start,
        size,
        name,
    } in &image.symbols
    {
        let first = start.saturating_sub(address).min(length) as usize;
        let end = (start + size).saturating_sub(address).min(length) as usize;
        for part in &mut parts[first..end.max(first)] {
            part.get_or_insert_with(|| Part::of(name));
        }
    }
    for (address, part) in (address..).zip(parts) {
        counts[part_in_section(image, address, part) as usize] += 1;
    }
}

/// The kinds of sections that contain constants only.
const CONSTANTS: [SectionKind; 2] = [SectionKind::ReadOnlyData, SectionKind::ReadOnlyString];

/// The section determines the part of the vectors and of bytes without a symbol.
fn part_in_section(image: &Image, address: u32, part: Option<Part>) -> Part {
    let section = image.sections.iter().find(|section| {
        // Sections that are not loaded have address 0.
        section.address != 0
            && address
                .checked_sub(section.address)
                .is_some_and(|offset| offset < section.size)
    });
    match section {
        Some(section) if section.name == ".vector_table" => Part::Vectors,
        Some(section) if CONSTANTS.contains(&section.kind) => part.unwrap_or(Part::Constants),
        _ => part.unwrap_or(Part::Padding),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_by_name() {
        for (name, part) in [
            ("plumbline::fsc::protocol::Fsc<P>::send", Part::Core),
            (
                "<plumbline::node::can_node::CanNode<A,P> as plumbline::node::Node>::sample",
                Part::Core,
            ),
            (
                "core::ptr::drop_in_place<plumbline::store::Boot>",
                Part::Core,
            ),
            ("firmware_stm32::app::run", Part::Driver),
            ("is2::__cortex_m_rt_main", Part::Driver),
            (
                "jn2101::__cortex_m_rt_main_trampoline::SENSOR",
                Part::Driver,
            ),
            ("plumbline::model::jn2101::TABLE", Part::Core),
            ("main", Part::Driver),
            ("__rustc::rust_begin_unwind", Part::Driver),
            ("USB_LP_CAN_RX0", Part::Driver),
            (
                "<bxcan::IdReg as core::cmp::PartialOrd>::partial_cmp",
                Part::Libraries,
            ),
            (
                "heapless::vec::Vec<plumbline::can::Frame>::push",
                Part::Libraries,
            ),
            ("cortex_m::peripheral::TAKEN", Part::Libraries),
            ("compiler_builtins::mem::memcpy", Part::Runtime),
            ("core::panicking::panic", Part::Runtime),
            ("__aeabi_memcpy4", Part::Runtime),
            ("memcmp", Part::Runtime),
            ("Reset", Part::Runtime),
            (
                ".Lanon.d88e9db38adf23af0a01fef8aedd97a8.23",
                Part::Constants,
            ),
            (
                ".Lswitch.table.plumbline::param::projection::permits",
                Part::Core,
            ),
        ] {
            assert_eq!(Part::of(name), part, "{name}");
        }
    }
}
