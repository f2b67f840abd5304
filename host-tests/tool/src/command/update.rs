//! `plumbline update`.

use super::bus::Bus;
use super::file;
use crate::backup::Backup;
use crate::connect::{self, Wanted};
use crate::error::{Differing, Error, FileError, RequestError};
use crate::identify::Found;
use crate::image::ImageFile;
use crate::link::Link;
use crate::master::{Target, factory_target};
use crate::note::Note;
use crate::ops::restore;
use crate::ops::update::{self, Before};
use crate::output::Terminal;
use crate::question::Name;
use crate::scan;
use crate::session::Session;
use adapter::Mode;
use plumbline::model::catalog::{PRODUCTS, Product};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use texts::Kind;

/// The node-ID of a bootloader without a boot record.
const BLANK: u8 = 127;

/// The longest image file that is read.
const LONGEST: u64 = 1 << 20;

/// How a file is loaded.
#[derive(Clone, Copy)]
pub(super) struct Wish {
    /// An older program is permitted.
    pub downgrade: bool,
    /// The settings are written into a file before.
    pub backup: bool,
}

/// Loads the program of an image file into the sensor.
///
/// # Errors
/// The file is not valid or for another sensor, the sensor has no bootloader, refuses the file, or does not answer.
pub(super) fn update(
    path: &Path,
    wish: Wish,
    bus: &mut Bus,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let image = read(path)?;
    if let Some(document) = blank(&image, wish, bus, terminal)? {
        return terminal.document(&document);
    }
    let result = bus.with_found(terminal, |session, found, terminal| {
        running(session, found, &image, (path, wish), terminal)
    });
    let done = match result {
        // Nobody has answered as a sensor.
        Err(failure) if failure.kind() == Kind::Silent && !bus.is_found => {
            waiting(&image, wish, bus, terminal, failure)
        }
        result => result,
    };
    terminal.document(&done?)
}

/// The same for all sensors of the product on the bus, one after the other. One that fails does not end it.
///
/// # Errors
/// See [`update`]; or there is no sensor of the product.
pub(super) fn update_all(
    path: &Path,
    wish: Wish,
    bus: &mut Bus,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let image = read(path)?;
    let options = scan::Options {
        rate: bus.options.rate,
        active: Name::Ask.is_in(&bus.options.yes),
        ..scan::Options::default()
    };
    let labels = bus.labels(terminal);
    let rows = scan::run(bus.adapter()?, options, labels, terminal)?;
    let (mut done, mut failures) = (Vec::new(), Vec::new());
    for found in rows.found() {
        if found
            .product()
            .is_none_or(|own| own.name != image.product())
        {
            continue;
        }
        let wanted = Wanted {
            rate: rows.rate.or(bus.options.rate),
            target: Some(found.target),
            ..bus.wanted(terminal)?
        };
        let result = one(&wanted, &image, (path, wish), bus, terminal);
        let mut document = result.unwrap_or_else(|failure| {
            terminal.note(&failure);
            let document = json!({"loaded": false, "error": failure.code()});
            failures.push(failure);
            document
        });
        document["address"] = json!(found.target.address());
        done.push(document);
    }
    if done.is_empty() {
        return Err(RequestError::NoSuchSensor(image.product()).into());
    }
    terminal.document(&done.into())?;
    match failures.into_iter().next() {
        Some(first) => Err(first.after_document()),
        None => Ok(()),
    }
}

/// Updates the sensor at an address.
fn one(
    wanted: &Wanted,
    image: &ImageFile,
    (path, wish): (&Path, Wish),
    bus: &mut Bus,
    terminal: &mut Terminal,
) -> Result<Value, Error> {
    let (mut session, found) = connect::session(bus.adapter()?, wanted, terminal)?;
    let result = running(&mut session, &found, image, (path, wish), terminal);
    let result = ended(&mut session, result);
    for note in session.notes.drain(..) {
        terminal.note(&note);
    }
    result
}

/// The end of a session.
fn ended<T>(session: &mut Session, result: Result<T, Error>) -> Result<T, Error> {
    session.link.end();
    let released = session.release();
    session.link.close();
    let value = result?;
    released.map(|()| value)
}

/// Reads an image file.
pub(super) fn read(path: &Path) -> Result<ImageFile, Error> {
    let name = path.display().to_string();
    let bytes = bench::file::read(path, LONGEST)
        .map_err(|error| FileError::ImageUnread(name.clone(), error.to_string()))?;
    Ok(ImageFile::parse(bytes).map_err(|why| FileError::Image(name, why))?)
}

/// Updates a sensor that answers.
fn running(
    session: &mut Session,
    found: &Found,
    image: &ImageFile,
    (path, wish): (&Path, Wish),
    terminal: &mut Terminal,
) -> Result<Value, Error> {
    let before = update::check(session, image)?;
    if before == Before::Same {
        terminal.line(format!(
            "the sensor has version {} already",
            image.version()
        ))?;
        return Ok(report(image, false, None));
    }
    let mut kept = None;
    if before == Before::Waits {
        terminal.note(&Note::WaitsInBootloader);
    } else {
        if wish.backup {
            let path = backup_path(path, session, found);
            let (backup, _) = file::save(session, found, &path, terminal)?;
            kept = Some((backup, path));
        }
        update::enter(session)?;
    }
    let target = session.target;
    finish(session, (target, image), wish, kept, terminal)
}

/// Loads the first program of a board with a bootloader, which is node 127. None: the options do not name this address.
fn blank(
    image: &ImageFile,
    wish: Wish,
    bus: &mut Bus,
    terminal: &mut Terminal,
) -> Result<Option<Value>, Error> {
    let via = bus.options.sensor.target()?;
    let (Some(via), Some(product)) = (via, product(image)) else {
        return Ok(None);
    };
    let (true, Some(target)) = (via.node_id() == Some(BLANK), factory_target(product)) else {
        return Ok(None);
    };
    let mut session = open(bus, product, target, terminal)?;
    let result = finish(&mut session, (via, image), wish, None, terminal);
    ended(&mut session, result).map(Some)
}

/// The product of an image file.
fn product(image: &ImageFile) -> Option<&'static Product> {
    let number = image.header.product();
    PRODUCTS.iter().find(|own| own.image.number() == number)
}

/// Goes on with a sensor that waits in its bootloader: that of the address in the options, or that of the product as delivered.
fn waiting(
    image: &ImageFile,
    wish: Wish,
    bus: &mut Bus,
    terminal: &mut Terminal,
    failure: Error,
) -> Result<Value, Error> {
    let target = bus.options.sensor.target()?;
    let Some((product, target)) = product(image).and_then(|product| {
        let target = target.or_else(|| factory_target(product));
        Some((product, target?))
    }) else {
        return Err(failure);
    };
    let mut session = open(bus, product, target, terminal)?;
    let result = finish(&mut session, (target, image), wish, None, terminal);
    match ended(&mut session, result) {
        Err(own) if own.kind() == Kind::Silent => Err(failure),
        result => result,
    }
}

fn open(
    bus: &mut Bus,
    product: &'static Product,
    target: Target,
    terminal: &mut Terminal,
) -> Result<Session, Error> {
    let mut link = Link::new(bus.adapter()?, &terminal.stopped);
    link.open(bus.options.rate, Mode::Active)?;
    Ok(Session::new(link, target, product))
}

/// Loads the file and compares the settings with those before.
fn finish(
    session: &mut Session,
    (via, image): (Target, &ImageFile),
    wish: Wish,
    kept: Option<(Backup, PathBuf)>,
    terminal: &mut Terminal,
) -> Result<Value, Error> {
    update::load(session, via, image, wish.downgrade, terminal)?;
    terminal.line(format!("the sensor runs version {}", image.version()))?;
    let kept = match kept {
        Some((backup, path)) => {
            let path = path.display().to_string();
            let count = restore::count_differences(session, &backup)?;
            if count > 0 {
                terminal.note(&Note::SettingsDiffer(Differing::of(count), path.clone()));
            }
            Some((path, count))
        }
        None => None,
    };
    Ok(report(image, true, kept))
}

/// The file of the settings: beside the image file, with product and serial number or address.
fn backup_path(image: &Path, session: &Session, found: &Found) -> PathBuf {
    let serial = found.identity().serial();
    let unit = serial.map_or_else(|| session.target.address(), |serial| serial.to_string());
    image.with_file_name(format!("{}-{unit}.toml", session.sheet.product.name))
}

/// The document of a sensor.
fn report(image: &ImageFile, loaded: bool, kept: Option<(String, usize)>) -> Value {
    let (backup, different) = kept.unzip();
    json!({
        "product": image.product(),
        "version": image.version(),
        "crc": image.header.body(),
        "loaded": loaded,
        "backup": backup,
        "different": different,
    })
}
