//! The commands.

mod address;
mod file;
mod parameters;
mod raw;
mod set;
mod watch;

use crate::adapter::{self, Adapter};
use crate::cli::{Cli, Command, Options};
use crate::connect::{self, Wanted};
use crate::failure::Failure;
use crate::identify::{self, Found};
use crate::output::Terminal;
use crate::scan;
use crate::session::Session;
use clap::CommandFactory;
use serde_json::json;

/// Opens the adapter of a port.
pub type Connect<'a> = &'a mut dyn FnMut(&str) -> Result<Box<dyn Adapter>, Failure>;

/// The port if the user names none.
const NO_PORT: &str = "no port: give --port slcan:/dev/ttyACM0, slcan://HOST:PORT, can0 or demo:is2, or set PLUMBLINE_PORT";

/// Runs a command with the adapters of this computer.
///
/// # Errors
/// The command failed.
pub fn run(cli: &Cli, terminal: &mut Terminal) -> Result<(), Failure> {
    run_with(cli, terminal, &mut adapter::connect)
}

/// Runs a command with these adapters.
///
/// # Errors
/// The command failed.
pub fn run_with(cli: &Cli, terminal: &mut Terminal, connect: Connect) -> Result<(), Failure> {
    let options = &cli.options;
    match &cli.command {
        Command::Completions { shell } => {
            let mut command = Cli::command();
            clap_complete::generate(*shell, &mut command, "plumbline", &mut terminal.out);
            return Ok(());
        }
        Command::Man => {
            let page = clap_mangen::Man::new(Cli::command());
            let rendered = page.render(&mut terminal.out);
            return rendered.map_err(|error| Failure::bus("output-closed", error.to_string()));
        }
        Command::Set {
            assignments,
            file: Some(path),
            ..
        } => return file::set(path, assignments, terminal),
        Command::Parameters if options.product.is_some() => {
            let product = identify::product(options.product.as_deref().unwrap_or_default())?;
            return parameters::list(&crate::sheet::Sheet::of(product), terminal);
        }
        _ => {}
    }
    let mut bus = Bus { options, connect };
    match &cli.command {
        Command::Scan { active, search } => {
            let options = scan::Options {
                rate: options.rate,
                active: *active || options.yes,
                search: *search,
            };
            scan::run(bus.adapter()?, options, terminal)
        }
        Command::Parameters => {
            let (session, _) = bus.session()?;
            parameters::list(&session.sheet, terminal)?;
            session.finish().map(|_| ())
        }
        Command::Get { names } => bus.with(|session| parameters::get(session, names, terminal)),
        Command::Set {
            assignments, save, ..
        } => bus.with(|session| set::set(session, assignments, *save, terminal)),
        Command::Save => bus.with(|session| {
            let done = session.save()?;
            tell(terminal, done)
        }),
        Command::LoadFactory => bus.with(|session| {
            let done = session.load_factory()?;
            tell(terminal, done)
        }),
        Command::Zero { axis, save } => bus.with(|session| {
            let adjustments = session.sheet.product.guide.zero;
            set::adjust(
                session,
                "zero",
                adjustments,
                axis.map(|axis| axis.name()),
                *save,
                terminal,
            )
        }),
        Command::Teach { save } => bus.with(|session| {
            let adjustments = session.sheet.product.guide.teach;
            set::adjust(session, "teach", adjustments, None, *save, terminal)
        }),
        Command::Restart => bus.with(|session| {
            session.restart()?;
            tell(terminal, "the sensor restarts")
        }),
        Command::NodeId { new } => bus.with(|session| address::node_id(session, *new, terminal)),
        Command::Mac { new } => bus.with(|session| address::mac(session, *new, terminal)),
        Command::Raw { request } => raw::raw(&mut bus, request, terminal),
        Command::Backup { file } => {
            bus.with_found(|session, found| file::backup(session, found, file, terminal))
        }
        Command::Restore { file, only } => {
            bus.with_found(|session, found| file::restore(session, found, file, only, terminal))
        }
        Command::Diff { file } => bus.with(|session| file::diff(session, file, terminal)),
        Command::Watch { every, seconds } => {
            bus.with(|session| watch::watch(session, *every, *seconds, terminal))
        }
        Command::Record {
            file,
            every,
            seconds,
        } => bus.with(|session| watch::record(session, file, *every, *seconds, terminal)),
        Command::Log { file, seconds } => {
            watch::log(bus.adapter()?, options.rate, file, *seconds, terminal)
        }
        Command::Completions { .. } | Command::Man => Ok(()),
    }
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
}

impl Bus<'_> {
    fn adapter(&mut self) -> Result<Box<dyn Adapter>, Failure> {
        let port = self.options.port.as_deref();
        (self.connect)(port.ok_or_else(|| Failure::usage("no-port", NO_PORT))?)
    }

    fn wanted(&self) -> Result<Wanted, Failure> {
        let options = self.options;
        Ok(Wanted {
            rate: options.rate,
            target: connect::target(options.id.as_deref(), options.node, options.mac)?,
            product: options
                .product
                .as_deref()
                .map(identify::product)
                .transpose()?,
        })
    }

    fn session(&mut self) -> Result<(Session, Found), Failure> {
        let wanted = self.wanted()?;
        connect::session(self.adapter()?, &wanted)
    }

    /// Runs something in a session, which ends in every case.
    fn with<T>(
        &mut self,
        run: impl FnOnce(&mut Session) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        self.with_found(|session, _| run(session))
    }

    /// The same with what the sensor has told.
    fn with_found<T>(
        &mut self,
        run: impl FnOnce(&mut Session, &Found) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let (mut session, found) = self.session()?;
        let result = run(&mut session, &found);
        let released = session.release();
        session.link.adapter().close();
        let value = result?;
        released?;
        Ok(value)
    }
}
