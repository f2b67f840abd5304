//! `update`: another program for a sensor with a bootloader.

use super::diff;
use crate::backup::Backup;
use crate::error::{Differing, Error, RequestError, SensorError, Silence, What};
use crate::identify;
use crate::image::{self, ImageFile};
use crate::link::Link;
use crate::master::canopen::sdo::{Answer, Server};
use crate::master::canopen::{CONTROL, PROGRAM};
use crate::master::{Target, factory_target};
use crate::note::{Note, Step};
use crate::ops::rate;
use crate::output::{Progress, Terminal};
use crate::question::Question;
use crate::session::Session;
use plumbline::canopen::Abort;
use plumbline::model::catalog::{PRODUCTS, Product};
use plumbline::param::number;
use plumbline::time::{Duration, after, millis};
use serde::Serialize;
use texts::Kind;

/// The longest time until the bootloader answers. It searches the bit rate if it has no boot record.
const ENTRY: Duration = millis(3000);

/// The longest time until the sensor answers after the update. A DeviceNet sensor checks its MAC ID first.
const START: Duration = millis(10_000);

/// The object of the image file (CiA 302-3).
const FILE: (u16, u8) = (0x1F50, 1);

/// The version of the present program; 0: there is none.
const VERSION: (u16, u8) = (0x1018, 3);

/// The values of 1F51h:01.
const START_PROGRAM: u8 = 1;
const CLEAR: u8 = 3;
const PERMIT_DOWNGRADE: u8 = 0x81;

/// The abort codes of a refused image.
const UNFIT: u32 = Abort::Value as u32;
const UNSIGNED: u32 = Abort::LocalControl as u32;
const OLDER: u32 = Abort::DeviceState as u32;
const DAMAGED: u32 = Abort::Signature as u32;
const TIME_OUT: u32 = Abort::TimeOut as u32;

/// The number of times a file is sent.
const TRIES: u8 = 3;

/// Objects that our bootloader does not have, and others do: name, software version, heartbeat.
const ABSENT: [u16; 3] = [0x1008, 0x100A, 0x1017];

/// The node-ID of a bootloader without a boot record.
const BLANK: u8 = 127;

/// What an update has found.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Before {
    /// The program of the file runs already.
    Same,
    /// Another program runs.
    Other,
    /// The bootloader waits for a program.
    Waits,
}

/// What an update has done.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Updated {
    /// The product of the file.
    pub product: String,
    /// The version of the file.
    pub version: String,
    /// The version of the program before; None: there was none, or it is the program of the file.
    pub before: Option<String>,
    /// The CRC of the program.
    pub crc: u32,
    /// The file was loaded; false: the sensor has its program already.
    pub loaded: bool,
    /// The number of settings that differ from those before; None: they were not read before.
    pub different: Option<usize>,
}

/// Reads the settings before an update; they are returned with the name of their file.
pub(crate) type Keep<'a> =
    dyn FnMut(&mut Session, &mut Terminal) -> Result<Option<(Backup, String)>, Error> + 'a;

/// Updates the sensor of a session, which can wait in its bootloader. `downgrade` permits an older version without a question.
pub(crate) fn update(
    session: &mut Session,
    image: &ImageFile,
    downgrade: bool,
    keep: &mut Keep,
    terminal: &mut Terminal,
) -> Result<Updated, Error> {
    let before = check(session, image)?;
    let mut kept = None;
    match before {
        Before::Same => return Ok(updated(image, None)),
        Before::Waits => terminal.note(&Note::WaitsInBootloader),
        Before::Other => {
            kept = keep(session, terminal)?;
            enter(session)?;
        }
    }
    let target = session.target;
    let mut done = go_on(session, target, image, downgrade, terminal)?;
    if let Some((backup, file)) = kept {
        let count = diff::count_differences(session, &backup)?;
        if count > 0 {
            terminal.note(&Note::SettingsDiffer(Differing::of(count), file));
        }
        done.different = Some(count);
    }
    Ok(done)
}

/// Loads the file over the bootloader that waits at this address.
pub(crate) fn go_on(
    session: &mut Session,
    via: Target,
    image: &ImageFile,
    downgrade: bool,
    terminal: &mut Terminal,
) -> Result<Updated, Error> {
    let before = load(session, via, image, downgrade, terminal)?;
    Ok(updated(image, Some(before)))
}

/// The document: `loaded` has the version before.
fn updated(image: &ImageFile, loaded: Option<Option<u32>>) -> Updated {
    Updated {
        product: image.product(),
        version: image.version(),
        before: loaded.flatten().map(image::version),
        crc: image.header.body(),
        loaded: loaded.is_some(),
        different: None,
    }
}

/// Where a bootloader waits for a program.
#[derive(Clone, Copy)]
pub(crate) struct Waiting {
    /// The product of the file.
    pub product: &'static Product,
    /// The address of the program.
    pub target: Target,
    /// The address of the bootloader.
    pub via: Target,
    /// A board without a boot record: its bootloader is node 127, whatever the product.
    pub is_blank: bool,
}

impl Waiting {
    /// The sensor at this address, or at that as delivered. None: the catalogue does not have the product of the file.
    pub fn of(image: &ImageFile, target: Option<Target>) -> Option<Self> {
        let number = image.header.product();
        let mut products = PRODUCTS.iter();
        let product = products.find(|own| own.image.number() == number)?;
        let delivered = factory_target(product)?;
        let via = target.unwrap_or(delivered);
        let is_blank = via.node_id() == Some(BLANK);
        Some(Self {
            product,
            target: if is_blank { delivered } else { via },
            via,
            is_blank,
        })
    }
}

/// Checks that the file is for the sensor, and what runs in it.
///
/// # Errors
/// The file is for another product, measuring element or board, there is no bootloader, or nobody answers.
pub fn check(session: &mut Session, image: &ImageFile) -> Result<Before, Error> {
    let product = session.sheet.product;
    if product.image.number() != image.header.product() {
        return Err(RequestError::ImageProduct(image.product(), product.name).into());
    }
    let target = session.target;
    if target.is_bootloader(&mut session.link)? {
        return Ok(Before::Waits);
    }
    let program = target.program(session)?;
    let program = program.ok_or(SensorError::NoBootloader)?;
    let installed = image.header.installed();
    if program.crc == installed.crc {
        return Ok(Before::Same);
    }
    match program.hardware.filter(|own| *own != installed.hardware) {
        Some(own) => {
            let [file, own] = [installed.hardware, own].map(image::hardware);
            Err(RequestError::ImageHardware(file, own).into())
        }
        None => Ok(Before::Other),
    }
}

/// Restarts the sensor into its bootloader.
///
/// # Errors
/// Its address or its bit rate is another one after a restart, it refuses, or does not answer.
pub fn enter(session: &mut Session) -> Result<(), Error> {
    let target = session.target;
    let rate = session.link.rate();
    let moves = rate::next_target(session).is_ok_and(|next| !next.is_at(target))
        || rate.is_some() && rate::next_rate(session).is_ok_and(|next| next != rate);
    if moves {
        return Err(RequestError::RestartFirst.into());
    }
    // Before the restart: in J1939 the tool needs an address of its own for it.
    target.bootloader(&mut session.link)?;
    target.enter_bootloader(session)
}

/// Loads the file over the bootloader at this address, starts it, and waits until it runs. Returns the version before.
///
/// # Errors
/// The bootloader refuses the file, or does not answer, or the program does not start.
pub fn load(
    session: &mut Session,
    via: Target,
    image: &ImageFile,
    downgrade: bool,
    terminal: &mut Terminal,
) -> Result<Option<u32>, Error> {
    let server = via.bootloader(&mut session.link)?;
    let server = server.ok_or(Silence::Bootloader)?;
    let link = &mut session.link;
    let loaded = loaded(link, server, image, downgrade, terminal);
    if loaded.is_err() {
        link.set_ending(true);
    }
    // After a failure that of the present program, if it is still there. Without a reply, the program shows whether it has started.
    let started = control(link, server, START_PROGRAM);
    let before = loaded?;
    match started {
        Err(failure) if failure.kind() != Kind::Silent => return Err(failure),
        _ => {}
    }
    runs(session, image)?;
    Ok(before)
}

/// Loads the file, and returns the version before. A transfer that the bootloader has aborted because a frame was lost is repeated.
fn loaded(
    link: &mut Link,
    server: Server,
    image: &ImageFile,
    downgrade: bool,
    terminal: &mut Terminal,
) -> Result<Option<u32>, Error> {
    wait(link, server)?;
    let (index, sub) = VERSION;
    let before = match server.read(link, index, sub)? {
        Answer::Done(bytes) => Some(number(&bytes)).filter(|version| *version != 0),
        _ => None,
    };
    let older = before.filter(|before| image.header.version() < *before);
    let downgrade = match older {
        Some(own) if !downgrade => terminal.ask(&Question::Downgrade {
            file: image.version(),
            own: image::version(own),
        })?,
        _ => downgrade,
    };
    let mut tries = TRIES;
    loop {
        control(link, server, CLEAR)?;
        if downgrade {
            control(link, server, PERMIT_DOWNGRADE)?;
        }
        match download(link, server, image, terminal)? {
            Answer::Done(()) => break,
            Answer::Silent | Answer::Aborted(TIME_OUT) if tries > 1 => tries -= 1,
            Answer::Aborted(UNFIT) => return Err(SensorError::ImageUnfit.into()),
            Answer::Aborted(OLDER) => return Err(SensorError::ImageOlder(image.version()).into()),
            Answer::Aborted(UNSIGNED) => return Err(SensorError::ImageUnsigned.into()),
            // To a bootloader without signatures, it is the first page of a damaged program.
            Answer::Aborted(DAMAGED) if image.header.key() != 0 => {
                return Err(SensorError::ImageSigned.into());
            }
            Answer::Aborted(DAMAGED) => return Err(SensorError::ImageDamaged.into()),
            answer => return answer.must(server, What::Program).map(|()| before),
        }
    }
    let (index, sub) = PROGRAM;
    let crc = server.read(link, index, sub)?.must(server, What::Program)?;
    match number(&crc) == image.header.body() {
        true => Ok(before),
        false => Err(SensorError::ImageDamaged.into()),
    }
}

/// Waits until the program of the file runs.
fn runs(session: &mut Session, image: &ImageFile) -> Result<(), Error> {
    let target = session.target;
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
        Some(program) if program.crc == image.header.body() => Ok(()),
        other => {
            let crc = other.map_or_else(|| "-".to_owned(), |other| format!("{:08X}h", other.crc));
            Err(SensorError::OtherProgram(crc).into())
        }
    }
}

/// Waits until the bootloader answers. Another device with CiA 302 is refused: it has objects that the bootloader does not have.
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
    let mut is_own = server.read(link, 0x1000, 0)? == Answer::Done(vec![0; 4]);
    for index in ABSENT {
        is_own &= server.read(link, index, 0)? == Answer::Aborted(Abort::NoObject as u32);
    }
    match is_own {
        true => Ok(()),
        false => Err(SensorError::OtherBootloader.into()),
    }
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
) -> Result<Answer<()>, Error> {
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
    answer
}
