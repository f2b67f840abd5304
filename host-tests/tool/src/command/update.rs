//! `plumbline update`.

use super::bus::Bus;
use super::file;
use super::place::Place;
use crate::connect::{self, Wanted};
use crate::error::{Error, FileError, RequestError};
use crate::identify::Found;
use crate::image::ImageFile;
use crate::link::Link;
use crate::ops::update::{self, Updated, Waiting};
use crate::output::Terminal;
use crate::question::Name;
use crate::scan;
use crate::session::Session;
use adapter::Mode;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use texts::Kind;

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
    let bytes = bench::file::read(path, ImageFile::LONGEST as u64)
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
    let mut kept = None;
    let mut keep = |session: &mut Session, terminal: &mut Terminal| {
        if !wish.backup {
            return Ok(None);
        }
        let path = backup_path(path, session, found);
        let (backup, _) = file::save(session, found, &path, terminal)?;
        let name = path.display().to_string();
        kept = Some(name.clone());
        Ok(Some((backup, name)))
    };
    let done = update::update(session, image, wish.downgrade, &mut keep, terminal)?;
    report(&done, kept, terminal)
}

/// Loads the first program of a board with a bootloader, which is node 127. None: the options do not name this address.
fn blank(
    image: &ImageFile,
    wish: Wish,
    bus: &mut Bus,
    terminal: &mut Terminal,
) -> Result<Option<Value>, Error> {
    let target = bus.options.sensor.target()?;
    match Waiting::of(image, target).filter(|waiting| waiting.is_blank) {
        Some(waiting) => gone_on(waiting, image, wish, bus, terminal).map(Some),
        None => Ok(None),
    }
}

/// Goes on with a sensor that waits in its bootloader: that of the address in the options, or that of the product as delivered.
fn waiting(
    image: &ImageFile,
    wish: Wish,
    bus: &mut Bus,
    terminal: &mut Terminal,
    failure: Error,
) -> Result<Value, Error> {
    let Some(waiting) = Waiting::of(image, bus.options.sensor.target()?) else {
        return Err(failure);
    };
    match gone_on(waiting, image, wish, bus, terminal) {
        Err(own) if own.kind() == Kind::Silent => Err(failure),
        result => result,
    }
}

fn gone_on(
    Waiting {
        product,
        target,
        via,
        ..
    }: Waiting,
    image: &ImageFile,
    wish: Wish,
    bus: &mut Bus,
    terminal: &mut Terminal,
) -> Result<Value, Error> {
    let mut link = Link::new(bus.adapter()?, &terminal.stopped);
    link.open(bus.options.rate, Mode::Active)?;
    let mut session = Session::new(link, target, product);
    let done = update::go_on(&mut session, via, image, wish.downgrade, terminal);
    let done = ended(&mut session, done)?;
    bus.place = Some(Place::now(&session));
    report(&done, None, terminal)
}

/// The file of the settings: beside the image file, with product and serial number or address.
fn backup_path(image: &Path, session: &Session, found: &Found) -> PathBuf {
    let serial = found.identity().serial();
    let unit = serial.map_or_else(|| session.target.address(), |serial| serial.to_string());
    image.with_file_name(format!("{}-{unit}.toml", session.sheet.product.name))
}

/// Tells what was done, and returns the document of a sensor.
fn report(done: &Updated, backup: Option<String>, terminal: &mut Terminal) -> Result<Value, Error> {
    let version = &done.version;
    terminal.line(match (&done.before, done.loaded) {
        (_, false) => format!("the sensor has version {version} already"),
        (Some(before), true) => format!("the sensor runs version {version} (before: {before})"),
        (None, true) => format!("the sensor runs version {version}"),
    })?;
    Ok(json!({
        "product": done.product,
        "version": version,
        "crc": done.crc,
        "loaded": done.loaded,
        "backup": backup.filter(|_| done.loaded),
        "different": done.different,
    }))
}
