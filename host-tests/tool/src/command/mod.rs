//! The commands of the tool, one file for each.

mod bridge;
mod bus;
mod calibrate;
mod commission;
mod diff;
mod doctor;
mod file;
mod help;
mod identity;
mod image;
mod key;
mod log;
mod parameters;
mod place;
mod ports;
mod raw;
mod record;
mod replace;
mod replay;
mod send;
mod sender;
mod update;
mod watch;
mod written;

use crate::calibrate::log::Source;
use crate::cli::{Cli, Command, Options, time};
use crate::eds;
use crate::error::{Error, RequestError};
use crate::identify;
use crate::labels::Labels;
use crate::last::{self, Last};
use crate::note::Note;
use crate::ops::{self, Report, Request};
use crate::output::Terminal;
use crate::question::Name;
use crate::scan;
use crate::serve;
use adapter::Adapter;
use adapter::unread::Unread;
use bus::Bus;
use log::View;
use place::Place;
use sender::Sender;
use std::path::Path;
use texts::Kind;
use written::{distinct, replaced};

/// Opens the adapter of a port.
pub type Connect<'a> = &'a mut dyn FnMut(&str) -> Result<Box<dyn Adapter>, Error>;

/// Runs a command with the adapters of this computer.
///
/// # Errors
/// The command failed.
pub fn run(cli: &Cli, terminal: &mut Terminal) -> Result<(), Error> {
    run_with(cli, terminal, &mut crate::port::connect)
}

/// Runs a command with these adapters.
///
/// # Errors
/// The command failed.
pub fn run_with(cli: &Cli, terminal: &mut Terminal, connect: Connect) -> Result<(), Error> {
    let options = &cli.options;
    match &cli.command {
        Command::Ports => return ports::list(terminal),
        Command::Image {
            elf,
            output,
            bootloader,
            hex,
        } => {
            let hex = bootloader.as_deref().zip(hex.as_deref());
            return image::make(elf, output, hex, terminal);
        }
        Command::Key { command } => return key::key(command, terminal),
        Command::Decode { file, filter } => {
            let view = View::new(options, filter, true)?;
            return log::decode(file, view, terminal);
        }
        Command::Completions { shell } => return help::completions(*shell, terminal),
        Command::Man { command, out } => {
            return help::man(command.as_deref(), out.as_deref(), terminal);
        }
        Command::Operation(Request::Set {
            assignments,
            file: Some(path),
            ..
        }) => {
            let sheet = options.eds.as_deref().map(eds::read).transpose()?;
            return file::set_in_file(path, assignments, sheet.as_ref(), terminal);
        }
        Command::Calibrate {
            file,
            store,
            serial,
            log,
        } => {
            let unit = ops::calibrate::Unit {
                product: options.product.as_deref(),
                serial: *serial,
                store: store.as_deref(),
            };
            let may_measure = options.yes.is_empty();
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
            return Err(RequestError::NoIdentity.into());
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
            let sheet = eds::read(path)?;
            eds::note_losses(&sheet, terminal);
            return parameters::list(&sheet, terminal);
        }
        Command::Operation(request) if options.eds.is_some() => request.check_described()?,
        _ => {}
    }
    let mut last = Last::open(options.config.as_deref());
    let is_for_sensor = !matches!(
        cli.command,
        Command::Scan { .. }
            | Command::Log { .. }
            | Command::Replay(_)
            | Command::Send(_)
            | Command::Doctor { .. }
            | Command::Bridge(_)
            | Command::Commission { .. }
    );
    let (full, mut is_filled) = last.complete(options, is_for_sensor, terminal);
    let mut bus = Bus {
        options: &full,
        connect,
        listens: matches!(
            cli.command,
            Command::Watch { cyclic: true, .. } | Command::Record { cyclic: true, .. }
        ),
        unread: Unread::default(),
        place: None,
        is_found: false,
        is_rate_given: options.rate.is_some(),
    };
    let mut result = on_bus(cli, &mut bus, terminal);
    // Another sensor can be at the adapter now.
    let searched = Options {
        port: full.port.clone(),
        ..options.clone()
    };
    let is_silent = matches!(&result, Err(failure) if failure.kind() == Kind::Silent);
    if is_filled && is_silent && !bus.is_found {
        terminal.note(&Note::Searches);
        bus.options = &searched;
        is_filled = false;
        result = on_bus(cli, &mut bus, terminal);
    }
    if let (Ok(()), Some(note)) = (&result, Note::unread(&bus.unread)) {
        terminal.note(&note);
    }
    if let (Ok(()), Some(place), Some(port)) = (&result, bus.place, &full.port) {
        last.keep(port, place.rate, place.target);
    }
    result.map_err(|failure| {
        let failure = failure.with_unread(&bus.unread);
        match is_filled {
            true => last::explain(failure),
            false => failure,
        }
    })
}

/// Runs a command that needs the bus.
fn on_bus(cli: &Cli, bus: &mut Bus, terminal: &mut Terminal) -> Result<(), Error> {
    let options = bus.options;
    match &cli.command {
        Command::Scan { active, search } => {
            let options = scan::Options {
                rate: options.rate,
                active: *active || Name::Ask.is_in(&options.yes),
                search: *search,
                memory: scan::Memory::default(),
            };
            let labels = bus.labels(terminal);
            let rows = scan::run(bus.adapter()?, options, labels, terminal)?;
            bus.place = rows.only_one().map(|found| Place {
                rate: rows.rate,
                target: found.target,
                after_restart: false,
            });
            terminal.document(&rows.json())
        }
        Command::Parameters => bus.with(terminal, |session, terminal| {
            parameters::list(&session.sheet, terminal)
        }),
        Command::Operation(Request::Raw { request }) => raw::raw(bus, request, terminal),
        Command::Operation(request) => {
            let mut labels = match request {
                Request::Label { .. } => Labels::open(options.config.as_deref())?,
                _ => Labels::default(),
            };
            let (report, note, place) = bus.with_found(terminal, |session, found, terminal| {
                // After a restart the sensor needs some time before it answers.
                let next = matches!(request, Request::Restart).then(|| Place::next(session));
                let report = ops::perform(request, session, found, (&mut labels, false), terminal)?;
                let place = Place::after(request, &report, session, next);
                let note = place.note_after(request, options, session, found);
                Ok((report, note, place))
            })?;
            if !place.after_restart {
                bus.place = Some(place);
            }
            if let Some(note) = note {
                terminal.note(&note);
            }
            terminal.report(&report)
        }
        Command::Backup { file } => bus.with_found(terminal, |session, found, terminal| {
            file::backup(session, found, file, terminal)
        }),
        Command::Restore { file, only } => {
            let mut labels = bus.labels(terminal);
            bus.with_found(terminal, |session, found, terminal| {
                let from = file::read(session, file)?;
                let (document, name) = ops::restore::restore(session, found, from, only, terminal)?;
                let place = Place::next(session);
                terminal.note(&place.note(options, session, found));
                terminal.document(&document)?;
                ops::label::take_over(&mut labels, found, name.as_deref(), terminal);
                Ok(())
            })
        }
        Command::Diff { file, exit_code } => {
            bus.with_found(terminal, |session, found, terminal| {
                let from = file::read(session, file)?;
                diff::diff(session, found, from, *exit_code, terminal)
            })
        }
        Command::Align { save } => {
            let report = bus.with_found(terminal, |session, found, terminal| {
                let mut measured = ops::align::Measured::default();
                ops::align::align(session, found, (&mut measured, *save), terminal)
            })?;
            terminal.report(&Report::Aligned(report))
        }
        Command::Watch {
            names,
            every,
            cyclic,
            seconds,
        } => {
            let wanted = samples(names, *every, *cyclic, *seconds)?;
            bus.with(terminal, |session, terminal| {
                watch::show(session, &wanted, terminal)
            })
        }
        Command::Record {
            file,
            names,
            every,
            cyclic,
            seconds,
        } => {
            let wanted = samples(names, *every, *cyclic, *seconds)?;
            replaced(file, terminal)?;
            bus.with(terminal, |session, terminal| {
                record::record(session, &wanted, file, terminal)
            })
        }
        Command::Log {
            file,
            decode,
            filter,
            seconds,
        } => {
            let seconds = time(*seconds)?;
            let view = View::new(options, filter, *decode)?;
            if file.as_path() != Path::new("-") {
                replaced(file, terminal)?;
            }
            log::log(bus.adapter()?, options.rate, file, seconds, view, terminal)
        }
        Command::Replay(replay) => {
            let seconds = time(replay.seconds)?;
            let round = replay::read(options, replay, terminal)?;
            let sender = Sender::open(bus.adapter()?, options.rate, seconds, terminal)?;
            replay::replay(sender, replay, round, terminal)
        }
        Command::Send(sending) => {
            let items = send::items(sending)?;
            let seconds = time(sending.seconds)?;
            let sender = Sender::open(bus.adapter()?, options.rate, seconds, terminal)?;
            send::send(sender, items, terminal)
        }
        Command::Commission { plan, report, wait } => {
            commission::run(plan, report.as_deref(), *wait, bus, terminal)
        }
        Command::Replace { step } => replace::run(step, bus, terminal),
        Command::Bridge(wanted) => bridge::bridge(wanted, bus, terminal),
        Command::Doctor { seconds, active } => doctor::examine(bus, *seconds, *active, terminal),
        Command::Update {
            file,
            downgrade,
            no_backup,
            all,
        } => {
            let wish = update::Wish {
                downgrade: *downgrade,
                backup: !no_backup,
            };
            match all {
                true => update::update_all(file, wish, bus, terminal),
                false => update::update(file, wish, bus, terminal),
            }
        }
        Command::Identity { output, store, .. } => {
            let into = identity::Into {
                output: output.as_deref(),
                store: store.as_deref(),
            };
            bus.with(terminal, |session, terminal| {
                let own = ops::identity::read(session, terminal)?;
                identity::finish(&own, into, terminal)
            })
        }
        Command::Calibrate { .. }
        | Command::Image { .. }
        | Command::Key { .. }
        | Command::Ports
        | Command::Decode { .. }
        | Command::Completions { .. }
        | Command::Man { .. }
        | Command::Serve { .. } => Ok(()),
    }
}

/// The options of `watch` and `record`.
///
/// # Errors
/// The time is out of range.
fn samples(
    names: &[String],
    every: u32,
    is_cyclic: bool,
    seconds: Option<f64>,
) -> Result<ops::watch::Request, Error> {
    Ok(ops::watch::Request {
        names: names.to_vec(),
        every,
        is_cyclic,
        time: time(seconds)?,
    })
}
