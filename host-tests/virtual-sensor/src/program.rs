//! The program `virtual-sensor`: one sensor on a simulated bus that clients reach over slcan.

use crate::server::{Clock, Language, Log, RunError, Server, StatusLine, Unit, tcp};
use bench::fault::FaultFrom;
use bench::file::Unread;
use bench::scene::{Axes, Scene, SceneArgument, SceneError};
use bench::stage::Stage;
use bench::{Bus, BusRate, Device, Flash, Geometry, NodeType};
use clap::Parser;
use clap::builder::PossibleValuesParser;
use plumbline::can::BitRate;
use plumbline::model::catalog::{self, PRODUCTS, Product};
use plumbline::time::{Instant, after, millis};
use std::fs::OpenOptions;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use stm32_sim::Microcontroller;
use stm32_sim::elf::Image;

/// The default address for clients.
const DEFAULT_ADDRESS: &str = "127.0.0.1:11898";

/// Maximum time for the sensor to boot before clients are accepted.
const BOOT_LIMIT: Instant = Instant::from_ticks(2_000_000);

/// The serial number of the sensor.
const SERIAL: u32 = 1;

/// A CAN inclination sensor on a simulated bus. Clients speak slcan (LAWICEL ASCII) and share the bus.
#[derive(Clone, Debug, Parser)]
#[command(name = "virtual-sensor", version)]
pub struct Program {
    /// The sensor to simulate
    #[arg(long, default_value = "is2", ignore_case = true, value_parser = PossibleValuesParser::new(PRODUCTS.iter().map(|product| product.name)))]
    model: String,

    #[command(flatten)]
    options: Options,
}

/// A CAN inclination sensor on a simulated bus. Clients speak slcan (LAWICEL ASCII) and share the bus.
#[derive(Clone, Debug, Parser)]
pub struct Options {
    /// The article of the sensor: its type name or order number [default: the first one]
    #[arg(long, value_name = "ARTICLE")]
    article: Option<String>,

    /// Run this firmware image (an ELF file for one of the boards) on a simulated microcontroller, instead of the model
    /// built for the PC
    #[arg(long, value_name = "FILE")]
    elf: Option<PathBuf>,

    /// The bootloader of the board (an ELF file), which starts the image of --elf, or waits for a program if there is none. Build the image
    /// with --features behind-bootloader
    #[arg(long, value_name = "FILE")]
    bootloader: Option<PathBuf>,

    /// Address to listen on for clients; port 0 picks a free one [default: 127.0.0.1:11898, or a free port if that one is in use]
    #[arg(long, value_name = "ADDRESS:PORT")]
    listen: Option<String>,

    /// Also create a pseudoterminal, for programs that need a serial port
    #[cfg(unix)]
    #[arg(long)]
    pty: bool,

    /// The motion of the sensor: tilt=X,Y (degrees, at rest; with one axis X is the angle, Y the cross slope) or a CSV file with
    /// the columns t_s,ax_g,ay_g,az_g[,gx_dps,gy_dps,gz_dps][,temp_c][,supply_v] [default: a slow sway]
    #[arg(long, allow_hyphen_values = true)]
    scene: Option<SceneArgument>,

    /// A fault of the accelerometer: silent (it does not answer), stopped (it answers without values), frozen (its values do not
    /// change), zero (0 g in all axes), axis-x, axis-y, axis-z (0 g in this axis, also in the self-test) or clipping (an axis at
    /// the end of the range); SECONDS after the start, or from power-up. Repeatable: the one that began last counts
    #[arg(long, value_name = "accelerometer=FAULT[@SECONDS]")]
    fault: Vec<FaultFrom>,

    /// Keep the nonvolatile memory in this file, so that a restart of the program is a power cycle
    #[arg(long, value_name = "FILE")]
    store: Option<PathBuf>,

    /// The bit rate of the bus; clients with another rate are not connected [default: that of the sensor, for clients with any
    /// rate]
    #[arg(long, value_name = "KBITS", value_parser = bench::bit_rate)]
    bus_rate: Option<BitRate>,

    /// Also listen on this port of 127.0.0.1 (or at this address) for programs that move and break the sensor: lines of JSON, see the
    /// README of virtual-sensor. Port 0 picks a free one
    #[arg(long, value_name = "[ADDRESS:]PORT")]
    control: Option<String>,

    /// Where the time comes from
    #[arg(long, value_enum, default_value_t)]
    clock: Clock,

    /// Write the traffic to this file, in the format of candump -L
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
}

/// The reason why the program ended, as one sentence for its user.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Failure {
    /// The command line is invalid.
    #[error("{0}")]
    Usage(String),
    /// An error outside the program.
    #[error("{0}")]
    Outside(String),
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        match error {
            SceneError::Argument(what) => Self::Usage(what),
            SceneError::File(what) => Self::Outside(what),
        }
    }
}

/// Builds the message for an action that failed.
fn cannot(what: impl std::fmt::Display) -> impl FnOnce(io::Error) -> Failure {
    move |error| Failure::Outside(format!("cannot {what}: {error}"))
}

/// Runs a virtual sensor of the catalogue until Ctrl-C.
///
/// # Errors
/// The options are invalid, or something outside of the program failed.
pub fn run(program: &Program) -> Result<(), Failure> {
    let unknown = || Failure::Usage(format!("there is no model {}", program.model));
    let product = catalog::find(&program.model.to_lowercase()).ok_or_else(unknown)?;
    run_with(product, &program.options)
}

/// Runs a virtual sensor of any product until Ctrl-C, for the program of a product in another crate:
///
/// ```no_run
/// use clap::Parser;
/// use virtual_sensor::{Options, run_with};
/// # use plumbline::model::gemac::is2::LISTING;
///
/// run_with(&LISTING, &Options::parse()).unwrap();
/// ```
///
/// # Errors
/// The options are invalid, or something outside of the program failed.
pub fn run_with(product: &'static Product, options: &Options) -> Result<(), Failure> {
    let node_type = node_type(product, options)?;
    let image = image(options, node_type.name)?;
    let geometry = match &image {
        Some(image) => image.board().chip().facts().geometry,
        None => Geometry::STM32F103,
    };
    let flash = match options.store.as_deref() {
        Some(path) => open_store(geometry, path)?,
        None => Flash::blank(geometry),
    };
    let (axes, flash) = Axes::stored(&node_type, SERIAL, flash);
    let scene = Scene::open(options.scene.as_ref(), axes)?;
    let log = match &options.log {
        Some(path) => {
            Some(Log::create(path).map_err(cannot(format!("write the log {}", path.display())))?)
        }
        None => None,
    };
    let listener = listen(options.listen.as_deref())?;
    let address = listener.local_addr().map_err(cannot("listen"))?;
    let control = options.control.as_deref().map(listen_for_control);
    let control = control.transpose()?;

    let mut bus = Bus::new(options.bus_rate.map_or(BusRate::Follow, BusRate::Fixed));
    let stage = Stage::new(scene, &options.fault);
    let motion = Box::new(stage.clone());
    let sensor = match image {
        Some(image) => {
            let mut microcontroller =
                Microcontroller::of_type(&node_type, image, SERIAL, flash, motion);
            if let Some(SceneArgument::Tilt(..)) = options.scene {
                microcontroller = microcontroller.quiet();
            }
            microcontroller.report_stop();
            bus.attach(microcontroller)
        }
        None => bus.attach(Device::new(&node_type, SERIAL, flash, motion)),
    };
    // The sensor boots first, so that the first client finds it ready.
    while bus.device(sensor).mode().is_none() && bus.now() < BOOT_LIMIT {
        let next = after(bus.now(), millis(1));
        bus.run_until(next);
    }
    let stopped = Microcontroller::of(bus.device(sensor)).and_then(Microcontroller::stopped);
    if let Some(reason) = stopped {
        return Err(Failure::Outside(
            RunError::Firmware(reason.to_owned()).to_string(),
        ));
    }
    if bus.device(sensor).mode().is_none() {
        let seconds = BOOT_LIMIT.ticks() / 1_000_000;
        eprintln!(
            "virtual-sensor: the firmware did not start its CAN controller within {seconds} s"
        );
    }
    let status = io::stdout().is_terminal().then(StatusLine::new);
    let (mut server, events) = Server::new(bus, sensor, options.clock, log, status);
    let name = node_type.name.to_owned();
    server.control(vec![Unit::new(name, sensor, node_type, SERIAL, stage)]);

    let stop = events.clone();
    ctrlc::set_handler(move || stop.stop())
        .map_err(|error| Failure::Outside(format!("cannot catch Ctrl-C: {error}")))?;
    announce(&format!("slcan socket://{address}"));
    if let Some((control, address)) = control {
        announce(&format!("control socket://{address}"));
        tcp::accept(control, events.clone(), Language::Control)
            .map_err(cannot("start a thread"))?;
    }
    #[cfg(unix)]
    if options.pty {
        let path =
            crate::server::pty::serve(events.clone()).map_err(cannot("create a pseudoterminal"))?;
        announce(&format!("slcan {path}"));
    }
    tcp::serve(listener, events).map_err(cannot("start a thread"))?;
    server.run().map_err(|ended| match ended {
        RunError::Log(error) => {
            let log = options.log.as_deref().unwrap_or(Path::new("log"));
            cannot(format!("write the log {}", log.display()))(error)
        }
        RunError::Firmware(_) => Failure::Outside(ended.to_string()),
    })
}

/// The sensor of the options.
fn node_type(product: &'static Product, options: &Options) -> Result<NodeType, Failure> {
    let node_type = NodeType::from(product);
    let Some(wanted) = &options.article else {
        return Ok(node_type);
    };
    if options.elf.is_some() || options.bootloader.is_some() {
        let message = "the article is in the firmware image: omit --article or --elf";
        return Err(Failure::Usage(message.to_owned()));
    }
    node_type.with_article(wanted).ok_or_else(|| {
        let articles: Vec<String> = product
            .articles()
            .map(|article| format!("{} ({})", article.name, article.number))
            .collect();
        let own = articles.join(", ");
        let others = PRODUCTS.iter().filter(|other| has_article(other, wanted));
        let others: Vec<&str> = others.map(|other| other.name).collect();
        let hint = match &others[..] {
            [] => String::new(),
            others => format!("; {wanted} is an article of {}", others.join(", ")),
        };
        let model = product.name;
        Failure::Usage(format!(
            "{model} has no article {wanted}; its articles are {own}{hint}"
        ))
    })
}

fn has_article(product: &Product, wanted: &str) -> bool {
    product.articles().any(|article| article.is(wanted))
}

/// The memory in `path`, which is created if it does not exist. If it cannot be written, reports it at once and not at the first
/// save; the sensor continues with its contents.
fn open_store(geometry: Geometry, path: &Path) -> Result<Flash, Failure> {
    let unusable = |error| cannot(format!("use the store {}", path.display()))(error);
    // The opening of a pipe would wait without end.
    match bench::file::open(path) {
        Err(why @ Unread::Unfit(_)) => return Err(unusable(why.into())),
        Err(Unread::Failed(_)) | Ok(_) => {}
    }
    let writable = OpenOptions::new()
        .write(true)
        .create(true)
        .truncate(false)
        .open(path);
    let problem = match (Flash::in_file(geometry, path), writable) {
        (Ok(flash), Ok(_)) => return Ok(flash),
        (Err(error), _) if error.kind() == ErrorKind::ResourceBusy => {
            return Err(unusable(error));
        }
        (Err(error), _) | (Ok(_), Err(error)) => error,
    };
    let path_shown = path.display();
    eprintln!("virtual-sensor: cannot use the store {path_shown}: {problem}; nothing can be saved");
    Ok(Flash::read_only(geometry, path).unwrap_or_else(|_| {
        let mut flash = Flash::blank(geometry);
        flash.fail_writes(true);
        flash.fail_erases(true);
        flash
    }))
}

/// The length of the longest ELF file in bytes.
const LONGEST_ELF: u64 = 1 << 28;

/// The firmware image of the options, with its bootloader; None: the model for the PC.
fn image(options: &Options, model: &str) -> Result<Option<Rc<Image>>, Failure> {
    let open = |path: &Option<PathBuf>| {
        let path = path.as_deref();
        path.map(|path| open_image(path, model)).transpose()
    };
    let (image, bootloader) = (open(&options.elf)?, open(&options.bootloader)?);
    let image = match (image, bootloader) {
        (Some(image), None) if image.needs_bootloader() => {
            let message = "the image is built for a flash with a bootloader: add --bootloader FILE";
            return Err(Failure::Usage(message.to_owned()));
        }
        (Some(image), Some(bootloader)) => {
            let both = image.behind(&bootloader);
            let message = "the two images do not fit: build that of --elf with --features behind-bootloader, for the board of the bootloader";
            Some(both.ok_or_else(|| Failure::Usage(message.to_owned()))?)
        }
        (None, Some(bootloader)) => Some(bootloader.as_bootloader()),
        (image, None) => image,
    };
    Ok(image.map(Rc::new))
}

/// The firmware image in an ELF file; checks the model, if the file has symbols.
fn open_image(path: &Path, model: &str) -> Result<Image, Failure> {
    let what = format!("read the firmware image {}", path.display());
    let elf = bench::file::read(path, LONGEST_ELF).map_err(|why| cannot(&what)(why.into()))?;
    let image =
        Image::parse(&elf).map_err(|error| Failure::Outside(format!("cannot {what}: {error}")))?;
    let other = image.program().filter(|program| *program != model);
    if let Some(other) = other.filter(|program| catalog::find(program).is_some()) {
        return Err(Failure::Usage(format!(
            "{} is an image of the model {other}, not of {model}",
            path.display(),
        )));
    }
    Ok(image)
}

/// Listens on the address, or on the default one.
fn listen(address: Option<&str>) -> Result<TcpListener, Failure> {
    match address {
        Some(address) => TcpListener::bind(address).map_err(cannot(format!("listen at {address}"))),
        None => TcpListener::bind(DEFAULT_ADDRESS)
            .or_else(|_| TcpListener::bind("127.0.0.1:0"))
            .map_err(cannot(format!("listen at {DEFAULT_ADDRESS}"))),
    }
}

/// Listens for control clients at the address, or on the port of this computer.
fn listen_for_control(place: &str) -> Result<(TcpListener, SocketAddr), Failure> {
    let listener = match place.parse::<u16>() {
        Ok(port) => TcpListener::bind((Ipv4Addr::LOCALHOST, port)),
        Err(_) => TcpListener::bind(place),
    };
    let listening = listener.and_then(|listener| {
        let address = listener.local_addr()?;
        Ok((listener, address))
    });
    listening.map_err(cannot(format!("listen at {place} for control")))
}

/// Prints a line at once. The sensor ignores errors of standard output.
fn announce(line: &str) {
    let mut output = io::stdout().lock();
    let _ = writeln!(output, "{line}").and_then(|()| output.flush());
}
