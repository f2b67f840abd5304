//! The third part of a scan: asks, one question at a time. All questions are reads.

use super::Row;
use super::listen::Heard;
use crate::adapter::Mode;
use crate::client::devicenet::Slave;
use crate::client::fsc::Sensor;
use crate::client::{Link, lss};
use crate::connect::factory_targets;
use crate::failure::Failure;
use crate::identify::{self, boot_up};
use crate::output::Terminal;
use crate::session::Target;
use plumbline::can::{BitRate, CanId, Frame};
use plumbline::time::{Duration, millis};

/// The wait for an answer in a search of all identifiers.
const SEARCH: Duration = millis(20);

/// The rate at which somebody answers, and who.
type Answers = (Option<BitRate>, Vec<Row>);

/// Asks at these rates until somebody answers at one of them.
///
/// # Errors
/// Those of the adapter, or Ctrl-C.
pub fn find(
    link: &mut Link,
    rates: &[Option<BitRate>],
    heard: Option<&Heard>,
    search: bool,
    terminal: &mut Terminal,
) -> Result<Answers, Failure> {
    let frames = heard.map_or(&[][..], |heard| &heard.frames);
    for rate in rates {
        say(terminal, "asking at the addresses as delivered", *rate);
        open(link, *rate)?;
        let mut rows = Vec::new();
        for target in factory_targets() {
            ask(link, target, frames, &mut rows)?;
        }
        booted(link, frames, &mut rows)?;
        if !rows.is_empty() {
            everybody(link, frames, &mut rows, terminal)?;
            return Ok((*rate, rows));
        }
        link.adapter().close();
    }
    for rate in rates {
        say(terminal, "asking at all node-IDs and MAC IDs", *rate);
        open(link, *rate)?;
        let mut rows = Vec::new();
        everybody(link, frames, &mut rows, terminal)?;
        if search {
            say(
                terminal,
                "searching all identifiers of 11 bits, 41 s",
                *rate,
            );
            identifiers(link, frames, &mut rows, terminal)?;
        }
        if !rows.is_empty() {
            return Ok((*rate, rows));
        }
        link.adapter().close();
    }
    Ok((None, Vec::new()))
}

fn say(terminal: &mut Terminal, what: &str, rate: Option<BitRate>) {
    let rate = rate.map_or("the bit rate of the interface", BitRate::name);
    terminal.note(format!("{what} ({rate})"));
}

fn open(link: &mut Link, rate: Option<BitRate>) -> Result<(), Failure> {
    link.open(rate, Mode::Active)
}

/// Asks at an address, unless somebody else talks to it or it has answered already.
fn ask(
    link: &mut Link,
    target: Target,
    frames: &[Frame],
    rows: &mut Vec<Row>,
) -> Result<(), Failure> {
    let address = target.address();
    let protocol = match target {
        Target::Fsc(_) => "fsc",
        Target::Canopen(_) => "canopen",
        Target::Devicenet(_) => "devicenet",
    };
    if rows
        .iter()
        .any(|row| row.address() == (protocol, address.clone()))
        || is_used(target, frames)
    {
        return Ok(());
    }
    if let Some(found) = identify::ask(link, target)? {
        let row = Row::Found(found);
        if !rows.iter().any(|own| own.address() == row.address()) {
            rows.push(row);
        }
    }
    Ok(())
}

/// Whether somebody else uses the identifier of the question.
fn is_used(target: Target, frames: &[Frame]) -> bool {
    use plumbline::devicenet::identifiers::{group_2, group_2_id};
    let id = match target {
        Target::Fsc(sensor) => sensor.request,
        Target::Canopen(node) => CanId::standard(0x600 + u16::from(node)),
        Target::Devicenet(slave) => CanId::standard(group_2_id(slave.mac, group_2::REQUEST)),
    };
    frames.iter().any(|frame| frame.can_id() == id)
}

/// All node-IDs, a node without node-ID, and all MAC IDs.
fn everybody(
    link: &mut Link,
    frames: &[Frame],
    rows: &mut Vec<Row>,
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    for node in 1..=127 {
        stop(terminal)?;
        ask(link, Target::Canopen(node), frames, rows)?;
    }
    if let Some([vendor, code, _, serial]) = lss::find(link)? {
        rows.push(Row::Heard {
            protocol: "canopen",
            address: "unconfigured".to_owned(),
            serial: Some(serial),
            article: Some(format!("vendor {vendor:X}h, product code {code:X}h")),
        });
        lss::release(link)?;
    }
    for mac in 0..=63 {
        stop(terminal)?;
        ask(link, Target::Devicenet(Slave { mac }), frames, rows)?;
    }
    booted(link, frames, rows)
}

/// The sensors that have detected the bit rate since the last call, whatever was asked.
fn booted(link: &mut Link, frames: &[Frame], rows: &mut Vec<Row>) -> Result<(), Failure> {
    for sensor in link.take_booted() {
        ask(link, Target::Fsc(sensor), frames, rows)?;
    }
    Ok(())
}

/// All identifiers of 11 bits: the request for the status has no effect. Identifiers of network management are left out.
fn identifiers(
    link: &mut Link,
    frames: &[Frame],
    rows: &mut Vec<Row>,
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    const STATUS: u8 = 0x02;
    for id in 1..=0x7FF {
        let request = CanId::standard(id);
        let sensor = Sensor {
            request,
            reply: None,
        };
        let is_managing = matches!(id, 0x080 | 0x100 | 0x7E4 | 0x7E5);
        if is_managing || is_used(Target::Fsc(sensor), frames) {
            continue;
        }
        stop(terminal)?;
        let question = Frame::of(request, [STATUS, 0, 0, 0, 0, 0, 0, 0], 1);
        let judge = |frame: &Frame| {
            let is_reply = matches!(frame.bytes(), [STATUS, _]) && frame.can_id() != request;
            if is_reply {
                Some(sensor)
            } else {
                boot_up(frame)
            }
        };
        if let Some(sensor) = link.ask(&question, SEARCH, judge)? {
            ask(link, Target::Fsc(sensor), frames, rows)?;
        }
    }
    Ok(())
}

fn stop(terminal: &Terminal) -> Result<(), Failure> {
    if (terminal.stopped)() {
        return Err(Failure::bus(
            "stopped",
            "the scan was stopped: start it again to finish",
        ));
    }
    Ok(())
}
