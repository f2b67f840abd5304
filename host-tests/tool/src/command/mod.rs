//! The commands of the tool, one file for each.

mod address;
mod adjust;
pub mod calibrate;
mod factory;
mod file;
mod help;
pub mod identity;
mod j1939;
mod label;
mod parameters;
mod ports;
mod rate;
mod raw;
mod record;
mod restore;
mod set;
mod watch;

use crate::adapter::{self, Adapter};
use crate::calibrate::log::Source;
use crate::cli::{Cli, Command, Options};
use crate::connect::{self, Wanted};
use crate::eds;
use crate::failure::Failure;
use crate::identify::{self, Found, Identity};
use crate::labels::Labels;
use crate::output::Terminal;
use crate::scan;
use crate::serve;
use crate::session::{Session, Target};
use serde_json::json;
use std::path::Path;

/// Opens the adapter of a port.
pub type Connect<'a> = &'a mut dyn FnMut(&str) -> Result<Box<dyn Adapter>, Failure>;

/// The port if the user names none.
const NO_PORT: &str = "no port: give --port slcan:/dev/ttyACM0, slcan://HOST:PORT, can0, pcan or demo:is2, or set PLUMBLINE_PORT; `plumbline ports` lists the ports of this computer";

/// Runs a command with the adapters of this computer.
///
/// # Errors
/// The command failed.
pub fn run(cli: &Cli, terminal: &mut Terminal) -> Result<(), Failure> {
    run_with(cli, terminal, &mut adapter::connect)
}

/// The sensor of a command: which one it must be, and where it is afterwards.
#[derive(Debug, Default)]
pub struct Sensor {
    /// Which one must answer. None: any.
    pub expected: Option<Identity>,
    /// Its address after the command, also if that has failed. None: it was not found.
    pub target: Option<Target>,
    /// What an earlier scan has heard.
    pub memory: scan::Memory,
}

/// Runs a command with these adapters.
///
/// # Errors
/// The command failed.
pub fn run_with(cli: &Cli, terminal: &mut Terminal, connect: Connect) -> Result<(), Failure> {
    run_on(cli, terminal, connect, &mut Sensor::default())
}

/// Runs a command with these adapters, on this sensor.
///
/// # Errors
/// The command failed, or another sensor answers.
pub fn run_on(
    cli: &Cli,
    terminal: &mut Terminal,
    connect: Connect,
    sensor: &mut Sensor,
) -> Result<(), Failure> {
    let options = &cli.options;
    match &cli.command {
        Command::Ports => return ports::list(terminal),
        Command::Completions { shell } => return help::completions(*shell, terminal),
        Command::Man { command, out } => {
            return help::man(command.as_deref(), out.as_deref(), terminal);
        }
        Command::Set {
            assignments,
            file: Some(path),
            ..
        } => {
            let sheet = options.eds.as_deref().map(eds::read).transpose()?;
            return file::set_in_file(path, assignments, sheet.as_ref(), terminal);
        }
        Command::Calibrate {
            file,
            store,
            serial,
            log,
        } => {
            let unit = calibrate::Unit {
                product: options.product.as_deref(),
                serial: *serial,
                store: store.as_deref(),
            };
            let may_measure = !options.yes;
            return calibrate::calibrate(file, log, may_measure, unit, terminal);
        }
        Command::Identity {
            from,
            output,
            store,
            ..
        } if from.is_some() => {
            let path = from.as_deref().unwrap_or(Path::new(""));
            let into = identity::Into {
                output: output.as_deref(),
                store: store.as_deref(),
            };
            return identity::from_file(path, options.product.as_deref(), into, terminal);
        }
        Command::Identity {
            from_sensor: false,
            store: Some(_),
            ..
        } => {
            let message = "a store file needs an identity: give --from FILE, or --from-sensor for that of the connected sensor";
            return Err(Failure::usage("no-identity", message));
        }
        Command::Serve {
            listen,
            open,
            demo,
            calibrate,
            store,
            serial,
            log,
        } => {
            let unit = calibrate.as_ref().map(|file| serve::calibration::Unit {
                file: file.clone(),
                store: store.clone(),
                serial: *serial,
                product: options.product.clone(),
                source: (!log.is_empty()).then(|| Source::Command(log.clone())),
            });
            let settings = serve::Settings {
                listen: *listen,
                options: options.clone(),
                demo: *demo,
                unit,
                store: store.clone(),
            };
            return serve::run(settings, *open, terminal);
        }
        Command::Parameters if options.product.is_some() => {
            let product = identify::product(options.product.as_deref().unwrap_or_default())?;
            return parameters::list(&crate::sheet::Sheet::of(product), terminal);
        }
        Command::Parameters if options.eds.is_some() => {
            let path = options.eds.as_deref().unwrap_or(Path::new(""));
            return parameters::list(&eds::read(path)?, terminal);
        }
        Command::NodeId { .. }
        | Command::Mac { .. }
        | Command::Rate { .. }
        | Command::Zero { .. }
        | Command::Teach { .. }
            if options.eds.is_some() =>
        {
            let message = "a data sheet does not describe this command: use `plumbline set` with the names that `plumbline parameters` lists";
            return Err(Failure::usage("not-offered", message));
        }
        _ => {}
    }
    let mut bus = Bus {
        options,
        connect,
        listens: matches!(
            cli.command,
            Command::Watch { cyclic: true, .. } | Command::Record { cyclic: true, .. }
        ),
        sensor,
    };
    match &cli.command {
        Command::Scan { active, search } => {
            let options = scan::Options {
                rate: options.rate,
                active: *active || options.yes,
                search: *search,
                memory: bus.sensor.memory.clone(),
            };
            let labels = bus.labels(terminal);
            scan::run(bus.adapter()?, options, labels, terminal)
        }
        Command::Parameters => bus.with(terminal, |session, terminal| {
            parameters::list(&session.sheet, terminal)
        }),
        Command::Get { names } => bus.with(terminal, |session, terminal| {
            parameters::get(session, names, terminal)
        }),
        Command::Set {
            assignments, save, ..
        } => bus.with(terminal, |session, terminal| {
            set::set(session, assignments, *save, terminal)
        }),
        Command::Save => bus.with(terminal, |session, terminal| {
            let done = session.save()?;
            tell(terminal, done)
        }),
        Command::LoadFactory => bus.with_found(terminal, factory::load),
        Command::Zero { axis, save } => bus.with_found(terminal, |session, found, terminal| {
            let axis = axis.map(|axis| axis.name());
            adjust::adjust(session, found, adjust::What::Zero, (axis, *save), terminal)
        }),
        Command::Teach { save } => bus.with_found(terminal, |session, found, terminal| {
            adjust::adjust(session, found, adjust::What::Teach, (None, *save), terminal)
        }),
        Command::Restart => bus.with(terminal, |session, terminal| {
            session.restart()?;
            tell(terminal, "the sensor restarts")
        }),
        Command::NodeId { new } => bus.with(terminal, |session, terminal| {
            address::node_id(session, *new, terminal)
        }),
        Command::Mac { new } => bus.with(terminal, |session, terminal| {
            address::mac(session, *new, terminal)
        }),
        Command::Address { new } => bus.with(terminal, |session, terminal| {
            j1939::address(session, *new, terminal)
        }),
        Command::Rate { new } => bus.with_found(terminal, |session, found, terminal| {
            rate::rate(session, found, *new, terminal)
        }),
        Command::Label { name, remove } => {
            let mut labels = Labels::open(options.config.as_deref())?;
            let change = match (name, remove) {
                (Some(name), _) => label::Change::Give(name),
                (None, true) => label::Change::Remove,
                (None, false) => label::Change::Show,
            };
            bus.with_found(terminal, |_, found, terminal| {
                label::label(&mut labels, found, change, terminal)
            })
        }
        Command::Raw { request } => raw::raw(&mut bus, request, terminal),
        Command::Backup { file } => bus.with_found(terminal, |session, found, terminal| {
            file::backup(session, found, file, terminal)
        }),
        Command::Restore { file, only } => {
            let mut labels = bus.labels(terminal);
            bus.with_found(terminal, |session, found, terminal| {
                let name = restore::restore(session, found, file, only, terminal)?;
                label::take_over(&mut labels, found, name.as_deref(), terminal);
                Ok(())
            })
        }
        Command::Diff { file } => bus.with(terminal, |session, terminal| {
            restore::diff(session, file, terminal)
        }),
        Command::Watch {
            names,
            every,
            cyclic,
            seconds,
        } => {
            let pace = watch::Pace::checked(*every, *cyclic, *seconds)?;
            bus.with(terminal, |session, terminal| {
                let sampler = watch::sampler(session, names)?;
                watch::watch(session, sampler, pace, terminal)
            })
        }
        Command::Record {
            file,
            names,
            every,
            cyclic,
            seconds,
        } => {
            let pace = watch::Pace::checked(*every, *cyclic, *seconds)?;
            replaced(file, terminal)?;
            bus.with(terminal, |session, terminal| {
                let sampler = watch::sampler(session, names)?;
                record::record(session, sampler, file, pace, terminal)
            })
        }
        Command::Log { file, seconds } => {
            let seconds = watch::checked(*seconds)?;
            if file.as_path() != Path::new("-") {
                replaced(file, terminal)?;
            }
            watch::log(bus.adapter()?, options.rate, file, seconds, terminal)
        }
        Command::Identity { output, store, .. } => {
            let into = identity::Into {
                output: output.as_deref(),
                store: store.as_deref(),
            };
            bus.with(terminal, |session, terminal| {
                identity::from_sensor(session, into, terminal)
            })
        }
        Command::Calibrate { .. }
        | Command::Ports
        | Command::Completions { .. }
        | Command::Man { .. }
        | Command::Serve { .. } => Ok(()),
    }
}

/// A file that exists is replaced only after a yes.
fn replaced(path: &Path, terminal: &mut Terminal) -> Result<(), Failure> {
    let shown = path.display();
    if path.is_file() && !(terminal.confirm)(&format!("{shown} exists. Replace it?")) {
        let message =
            format!("{shown} exists already: choose another name, or replace it with --yes");
        return Err(Failure::usage("file-exists", message));
    }
    Ok(())
}

/// What happened, in one sentence.
fn tell(terminal: &mut Terminal, text: &str) -> Result<(), Failure> {
    terminal.line(text)?;
    terminal.document(&json!({"done": text}))
}

/// The bus of the options.
struct Bus<'a> {
    options: &'a Options,
    connect: Connect<'a>,
    /// A DeviceNet slave of another master is listened to.
    listens: bool,
    sensor: &'a mut Sensor,
}

impl Bus<'_> {
    fn adapter(&mut self) -> Result<Box<dyn Adapter>, Failure> {
        let port = self.options.port.as_deref();
        (self.connect)(port.ok_or_else(|| Failure::usage("no-port", NO_PORT))?)
    }

    /// The names of sensors. Without them every command works.
    fn labels(&self, terminal: &mut Terminal) -> Labels {
        let labels = Labels::open(self.options.config.as_deref());
        labels.unwrap_or_else(|failure| {
            terminal.note(failure.message);
            Labels::default()
        })
    }

    fn wanted(&self, terminal: &mut Terminal) -> Result<Wanted, Failure> {
        let options = self.options;
        let sheet = options.eds.as_deref().map(eds::read).transpose()?;
        let product = match (&sheet, &options.product) {
            (Some(sheet), _) => Some(sheet.product),
            (None, Some(name)) => Some(identify::product(name)?),
            (None, None) => None,
        };
        Ok(Wanted {
            rate: options.rate,
            target: connect::target(
                options.id.as_deref(),
                options.node,
                options.mac,
                options.address,
            )?,
            product,
            sheet,
            labels: self.labels(terminal),
            listens: self.listens,
            expected: self.sensor.expected.clone(),
            all_yes: options.yes,
            memory: self.sensor.memory.clone(),
        })
    }

    fn session(&mut self, terminal: &mut Terminal) -> Result<(Session, Found), Failure> {
        let wanted = self.wanted(terminal)?;
        connect::session(self.adapter()?, &wanted, terminal)
    }

    /// Runs something in a session, which ends in every case.
    fn with<T>(
        &mut self,
        terminal: &mut Terminal,
        run: impl FnOnce(&mut Session, &mut Terminal) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        self.with_found(terminal, |session, _, terminal| run(session, terminal))
    }

    /// The same with what the sensor has told.
    fn with_found<T>(
        &mut self,
        terminal: &mut Terminal,
        run: impl FnOnce(&mut Session, &Found, &mut Terminal) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let (mut session, found) = self.session(terminal)?;
        let result = run(&mut session, &found, terminal);
        self.sensor.target = Some(session.target);
        session.link.end();
        let released = session.release();
        session.link.close();
        for note in session.notes.drain(..) {
            terminal.note(note);
        }
        let value = result?;
        released?;
        Ok(value)
    }
}
