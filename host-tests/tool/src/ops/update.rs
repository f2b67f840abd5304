//! `update`: another program for a sensor with a bootloader.

use crate::error::{Error, Kind, RequestError, SensorError, Silence, What};
use crate::identify;
use crate::image::ImageFile;
use crate::link::Link;
use crate::master::canopen::sdo::{Answer, Server};
use crate::note::Step;
use crate::output::{Progress, Terminal};
use crate::session::Session;
use plumbline::canopen::Abort;
use plumbline::param::number;
use plumbline::time::{Duration, after, millis};

/// The longest time until the bootloader answers. It searches the bit rate if it has no boot record.
const ENTRY: Duration = millis(3000);

/// The longest time until the sensor answers after the update. A DeviceNet sensor checks its MAC ID first.
const START: Duration = millis(10_000);

/// The objects of the bootloader (CiA 302-3).
const FILE: (u16, u8) = (0x1F50, 1);
const CONTROL: (u16, u8) = (0x1F51, 1);
const PROGRAM: (u16, u8) = (0x1F56, 1);

/// The values of 1F51h:01.
const START_PROGRAM: u8 = 1;
const CLEAR: u8 = 3;
const PERMIT_DOWNGRADE: u8 = 0x81;

/// The abort codes of an image that is for another device, and of an older one.
const UNFIT: u32 = Abort::Value as u32;
const OLDER: u32 = Abort::DeviceState as u32;
const DAMAGED: u32 = Abort::Signature as u32;

/// What an update has found.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Before {
    /// The program of the file runs already.
    Same,
    /// Another program runs.
    Other,
    /// The bootloader waits for a program.
    Waits,
}

/// Checks that the file is for the sensor, and what runs in it.
pub(crate) fn check(session: &mut Session, image: &ImageFile) -> Result<Before, Error> {
    let product = session.sheet.product;
    if product.image.number() != image.header.product() {
        return Err(RequestError::ImageProduct(image.product(), product.name).into());
    }
    let target = session.target;
    if target.is_bootloader(&mut session.link)? {
        return Ok(Before::Waits);
    }
    match target.program(session)? {
        None => Err(SensorError::NoBootloader.into()),
        Some(crc) if crc == image.header.body() => Ok(Before::Same),
        Some(_) => Ok(Before::Other),
    }
}

/// Restarts the sensor into its bootloader.
pub(crate) fn enter(session: &mut Session) -> Result<(), Error> {
    let target = session.target;
    // Before the restart: in J1939 the tool needs an address of its own for it.
    target.bootloader(&mut session.link)?;
    target.enter_bootloader(session)
}

/// Loads the file over the bootloader of the sensor, starts it, and waits until it runs.
pub(crate) fn load(
    session: &mut Session,
    image: &ImageFile,
    downgrade: bool,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let target = session.target;
    let server = target.bootloader(&mut session.link)?;
    let server = server.ok_or(SensorError::NoBootloader)?;
    let link = &mut session.link;
    wait(link, server)?;
    control(link, server, CLEAR)?;
    if downgrade {
        control(link, server, PERMIT_DOWNGRADE)?;
    }
    let loaded = download(link, server, image, terminal);
    if let Err(failure) = loaded {
        if failure.kind() == Kind::Refused {
            // The present program, if it is still there.
            let _ = control(link, server, START_PROGRAM);
        }
        return Err(failure);
    }
    let (index, sub) = PROGRAM;
    let crc = server.read(link, index, sub)?.must(server, What::Program)?;
    if number(&crc) != image.header.body() {
        return Err(SensorError::ImageDamaged.into());
    }
    control(link, server, START_PROGRAM)?;
    session.moved(target);
    let until = after(session.link.now(), START);
    while identify::ask(&mut session.link, target, identify::PATIENT)?.is_none()
        || target.is_bootloader(&mut session.link)?
    {
        if session.link.now() >= until {
            return Err(Silence::Request.into());
        }
    }
    match target.program(session)? {
        Some(crc) if crc == image.header.body() => Ok(()),
        other => {
            let crc = other.map_or_else(|| "-".to_owned(), |crc| format!("{crc:08X}h"));
            Err(SensorError::OtherProgram(crc).into())
        }
    }
}

/// Waits until the bootloader answers.
fn wait(link: &mut Link, server: Server) -> Result<(), Error> {
    let until = after(link.now(), ENTRY);
    let (index, sub) = CONTROL;
    let quick = Server {
        time: identify::PATIENT,
        ..server
    };
    while quick.read(link, index, sub)? != Answer::Done(vec![0]) {
        if link.now() >= until {
            return Err(Silence::Bootloader.into());
        }
    }
    Ok(())
}

/// Writes 1F51h:01.
fn control(link: &mut Link, server: Server, value: u8) -> Result<(), Error> {
    let (index, sub) = CONTROL;
    let answer = server.patient().write(link, index, sub, &[value])?;
    answer.must(server, What::Program)
}

fn download(
    link: &mut Link,
    server: Server,
    image: &ImageFile,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let total = image.bytes.len();
    let step = Step::Downloads(image.version());
    let at = |done| Progress {
        done,
        total,
        step: &step,
    };
    terminal.progress(at(0), Some(&step));
    let mut progress = |done| terminal.progress(at(done), None);
    let answer = server.download(link, FILE, &image.bytes, &mut progress);
    terminal.hide();
    match answer? {
        Answer::Aborted(UNFIT) => Err(SensorError::ImageUnfit.into()),
        Answer::Aborted(OLDER) => Err(SensorError::ImageOlder(image.version()).into()),
        Answer::Aborted(DAMAGED) => Err(SensorError::ImageDamaged.into()),
        answer => answer.must(server, What::Program),
    }
}
