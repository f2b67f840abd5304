//! The program `virtual-sensor`: sensors on a simulated bus that clients reach over slcan.

mod options;
mod sensor;

pub use options::{Options, Program};

use crate::server::{Clock, Language, Log, Outside, RunError, Server, StatusLine, Unit, tcp};
use adapter::AdapterError;
use bench::scene::SceneError;
use bench::{Bus, BusRate};
use options::SensorOptions;
use plumbline::model::catalog::Product;
use plumbline::time::{Instant, after, millis};
use sensor::Prepared;
use std::io::{self, IsTerminal, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::Path;
use stm32_sim::Microcontroller;
use texts::{Cause, Kind};

/// The default address for clients.
const DEFAULT_ADDRESS: &str = "127.0.0.1:11898";

/// Maximum time for the sensor to boot before clients are accepted.
const BOOT_LIMIT: Instant = Instant::from_ticks(2_000_000);

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

impl From<AdapterError> for Failure {
    fn from(error: AdapterError) -> Self {
        match error.kind() {
            Kind::Usage => Self::Usage(error.to_string()),
            _ => Self::Outside(error.to_string()),
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
    let mut sensors = vec![(program.model.product()?, &program.options.sensor)];
    for other in &program.others {
        sensors.push((other.model.product()?, &other.sensor));
    }
    run_sensors(&sensors, &program.options)
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
    run_sensors(&[(product, &options.sensor)], options)
}

/// Runs sensors on one bus until Ctrl-C.
fn run_sensors(
    sensors: &[(&'static Product, &SensorOptions)],
    options: &Options,
) -> Result<(), Failure> {
    if options.on.is_some() && options.clock == Clock::Client {
        let text = "the bus of an adapter (--on) has real time, so --clock client is not possible";
        return Err(Failure::Usage(text.to_owned()));
    }
    let stores = sensors.iter().filter_map(|(_, own)| own.store.as_deref());
    let stores: Vec<&Path> = stores.collect();
    for (at, store) in stores.iter().enumerate() {
        if stores[..at].contains(store) {
            let store = store.display();
            return Err(Failure::Usage(format!(
                "two sensors cannot have the same store {store}"
            )));
        }
    }
    let prepared = (1..).zip(sensors);
    let prepared: Vec<Prepared> = prepared
        .map(|(place, (product, own))| Prepared::new(product, own, place))
        .collect::<Result<_, _>>()?;
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
    let mut units: Vec<Unit> = Vec::new();
    for sensor in prepared {
        let model = sensor.node_type.name;
        let same = units.iter().filter(|unit| unit.node_type.name == model);
        let name = match same.count() {
            0 => model.to_owned(),
            others => format!("{model}-{}", others + 1),
        };
        units.push(sensor.attach(&mut bus, name));
    }
    boot(&mut bus, &units)?;
    let rate = bus.rate();
    let outside = options.on.as_deref().map(|port| Outside::open(port, rate));
    let outside = outside.transpose()?;
    let status = io::stdout().is_terminal().then(StatusLine::new);
    let (mut server, events) = Server::new(bus, units[0].device, options.clock, log, status);
    server.control(units);
    if let Some(outside) = outside {
        server.connect(outside);
    }

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
    if let Some(port) = &options.on {
        announce(&format!("on {port} at {}", rate.name()));
    }
    server.run().map_err(|ended| match ended {
        RunError::Log(error) => {
            let log = options.log.as_deref().unwrap_or(Path::new("log"));
            cannot(format!("write the log {}", log.display()))(error)
        }
        RunError::Adapter(error) => error.into(),
        RunError::Firmware(_) => Failure::Outside(ended.to_string()),
    })
}

/// Lets the sensors boot first, so that the first client finds them ready.
fn boot(bus: &mut Bus, units: &[Unit]) -> Result<(), Failure> {
    let waits = |bus: &Bus| {
        let mut units = units.iter();
        units.any(|unit| bus.device(unit.device).mode().is_none())
    };
    while waits(bus) && bus.now() < BOOT_LIMIT {
        let next = after(bus.now(), millis(1));
        bus.run_until(next);
    }
    for unit in units {
        let sensor = bus.device(unit.device);
        let stopped = Microcontroller::of(sensor).and_then(Microcontroller::stopped);
        if let Some(reason) = stopped {
            let ended = RunError::Firmware(reason.to_owned());
            return Err(Failure::Outside(ended.to_string()));
        }
        if sensor.mode().is_none() {
            let seconds = BOOT_LIMIT.ticks() / 1_000_000;
            eprintln!(
                "virtual-sensor: the firmware did not start its CAN controller within {seconds} s"
            );
        }
    }
    Ok(())
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
