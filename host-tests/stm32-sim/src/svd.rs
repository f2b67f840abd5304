//! The registers of a chip as the public SVD has them, with the corrections of the stm32-rs project: read from the source of the
//! peripheral access crate, which svd2rust has generated from it. Cargo downloads the crate for the firmware.

use std::collections::BTreeMap;
use std::fs::read_to_string;
use std::path::{Path, PathBuf};

/// A register of the peripheral access crate.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Register {
    /// Peripheral and register, for example `RCC.cr`.
    pub name: String,
    /// Its address.
    pub address: u32,
    /// Its value after a reset.
    pub reset: u32,
    /// The bits of all fields that can be read; None: it is write-only.
    pub readable: Option<u32>,
    /// The bits of all fields that can be written; None: it is read-only.
    pub writable: Option<u32>,
}

/// The source of a device in a peripheral access crate.
pub struct Device {
    folder: PathBuf,
    /// The module and the base address of each peripheral.
    peripherals: BTreeMap<String, (String, u32)>,
}

impl Device {
    /// The device `device` of the crate `package`, with the version in the lock file.
    pub fn open(package: &str, device: &str) -> Self {
        let metadata = cargo_metadata::MetadataCommand::new()
            .manifest_path(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"))
            // Each board is a feature of the firmware.
            .features(cargo_metadata::CargoOpt::AllFeatures)
            .other_options(["--locked".to_owned()])
            .exec()
            .expect("cargo metadata");
        let mut packages = metadata.packages.iter();
        let package = packages.find(|it| it.name == package);
        let manifest = &package.expect("the crate is a dependency").manifest_path;
        let folder = manifest.with_file_name("src").join(device);
        let source = read(folder.join("mod.rs").as_std_path());
        let peripherals = source.lines().filter_map(peripheral).collect();
        Self {
            folder: folder.into(),
            peripherals,
        }
    }

    /// The base address of a peripheral.
    pub fn base(&self, peripheral: &str) -> u32 {
        self.peripherals[peripheral].1
    }

    /// The registers of a peripheral, also those of its clusters.
    pub fn registers(&self, peripheral: &str) -> Vec<Register> {
        let (module, base) = &self.peripherals[peripheral];
        let mut found = Vec::new();
        self.block(
            &self.folder.join(module),
            "RegisterBlock",
            peripheral,
            *base,
            &mut found,
        );
        assert!(!found.is_empty(), "{peripheral}");
        found
    }

    /// Adds the registers of the block `block` in the file of `module`.
    fn block(&self, module: &Path, block: &str, name: &str, base: u32, found: &mut Vec<Register>) {
        let source = read(&module.with_extension("rs"));
        let start = format!("impl {block} {{");
        let body = source.split_once(&start).expect("a register block").1;
        let body = body.split("\n}").next().unwrap_or_default();
        let mut offsets = None;
        for line in body.lines().map(str::trim) {
            if let Some(text) = line.strip_prefix("///0x") {
                offsets = text
                    .split_once(" - ")
                    .and_then(|(offsets, _)| self::offsets(offsets));
            } else if let Some((register, kind)) = accessor(line)
                && let Some((from, to)) = offsets.take()
            {
                let file = self.file(&source, module, &kind.to_lowercase());
                let count = array(&source, register);
                let step = to.map_or(0, |to| (to - from) / count);
                let is_cluster =
                    read(&file.with_extension("rs")).contains(&format!("impl {kind} {{"));
                for index in 0..to.map_or(1, |_| count) {
                    let name = format!("{name}.{register}");
                    let name = to.map_or(name.clone(), |_| format!("{name}[{index}]"));
                    let address = base + from + index * step;
                    if is_cluster {
                        self.block(&file, kind, &name, address, found);
                    } else {
                        found.push(self::register(&file, name, address));
                    }
                }
            }
        }
    }
}

impl Device {
    /// The file of a register, without its extension: in the folder of the module, or of another one with the same register:
    /// `pub use crate::stm32f446::gpioa::otyper;`.
    fn file(&self, source: &str, module: &Path, register: &str) -> PathBuf {
        let end = format!("::{register};");
        let mut others = source
            .lines()
            .filter_map(|line| line.strip_prefix("pub use crate::")?.strip_suffix(&end));
        let other = others.find_map(|path| path.split_once("::"));
        let folder = other.map(|(_, module)| self.folder.join(module.replace("::", "/")));
        folder.as_deref().unwrap_or(module).join(register)
    }
}

fn read(file: &Path) -> String {
    read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

/// `pub type RCC = crate::Periph<rcc::RegisterBlock, 0x4002_1000>;`
fn peripheral(line: &str) -> Option<(String, (String, u32))> {
    let (name, rest) = line
        .strip_prefix("pub type ")?
        .split_once(" = crate::Periph<")?;
    let (module, rest) = rest.split_once("::RegisterBlock, ")?;
    let base = number(rest.strip_suffix(">;")?)?;
    Some((name.to_owned(), (module.to_owned(), base)))
}

/// `00` or `180..1b0`, hexadecimal.
fn offsets(text: &str) -> Option<(u32, Option<u32>)> {
    let hex = |text: &str| u32::from_str_radix(text.trim_start_matches("0x"), 16).ok();
    match text.split_once("..") {
        Some((from, to)) => Some((hex(from)?, Some(hex(to)?))),
        None => Some((hex(text)?, None)),
    }
}

/// The name and the type of `pub const fn cr(&self) -> &CR {`, also of an array; not of one element of an array.
fn accessor(line: &str) -> Option<(&str, &str)> {
    let (name, rest) = line.strip_prefix("pub const fn ")?.split_once("(&self")?;
    let kind = rest.split_once("-> &")?.1.strip_suffix(" {")?;
    Some((name, kind))
}

/// The number of elements of the field `tx: [TX; 3],` of the block; 1 without an array.
fn array(source: &str, register: &str) -> u32 {
    let field = format!("    {register}: [");
    let length = source.split_once(&field).and_then(|(_, rest)| {
        let length = rest.split_once("; ")?.1.split_once(']')?.0;
        number(length)
    });
    length.unwrap_or(1)
}

fn number(text: &str) -> Option<u32> {
    let text = text.replace('_', "");
    match text.strip_prefix("0x") {
        Some(hex) => u32::from_str_radix(hex, 16).ok(),
        None => text.parse().ok(),
    }
}

/// The register that a file describes.
fn register(file: &Path, name: String, address: u32) -> Register {
    let source = read(&file.with_extension("rs"));
    let fields = |kind: &str, access: &str| {
        source
            .contains(&format!("impl crate::{access} for "))
            .then(|| {
                let body = source
                    .split_once(&format!("\nimpl {kind} {{"))
                    .map_or("", |it| it.1);
                let body = body.split("\n}").next().unwrap_or_default();
                body.lines()
                    .map(str::trim)
                    .filter_map(field)
                    .fold(0, |mask, bits| mask | bits)
            })
    };
    let reset = source
        .split_once("const RESET_VALUE")
        .and_then(|(_, rest)| number(rest.split_once("= ")?.1.split_once(';')?.0));
    Register {
        name,
        address,
        reset: reset.unwrap_or_default(),
        readable: fields("R", "Readable"),
        writable: fields("W", "Writable"),
    }
}

/// The bits of `///Bit 3 - ` or `///Bits 4:5 - `.
fn field(line: &str) -> Option<u32> {
    let (bits, _) = line
        .strip_prefix("///Bit")?
        .trim_start_matches('s')
        .trim_start()
        .split_once(' ')?;
    let (low, high) = bits.split_once(':').unwrap_or((bits, bits));
    let (low, high): (u32, u32) = (low.parse().ok()?, high.parse().ok()?);
    Some((u32::MAX >> (31 - high)) & (u32::MAX << low))
}
