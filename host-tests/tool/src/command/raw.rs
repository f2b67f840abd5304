//! `raw`: one request of the protocol, as hexadecimal bytes.

use super::Bus;
use crate::client::devicenet::Path;
use crate::client::sdo::{SAVED, Server};
use crate::client::{Link, fsc};
use crate::connect;
use crate::failure::Failure;
use crate::output::Terminal;
use crate::session::Target;
use serde_json::json;

/// Sends one request and prints the answer. With an address of the command line the sensor is not asked for anything else.
pub(super) fn raw(bus: &mut Bus, request: &str, terminal: &mut Terminal) -> Result<(), Failure> {
    let wanted = bus.wanted()?;
    let adapter = bus.adapter()?;
    let (mut link, target) = match (wanted.target, wanted.rate) {
        (Some(target), Some(rate)) => {
            let mut link = Link::new(adapter);
            link.open(Some(rate), crate::adapter::Mode::Active)?;
            (link, target)
        }
        _ => {
            let (link, found) = connect::find(adapter, &wanted)?;
            (link, found.target)
        }
    };
    let answer = send(&mut link, target, request)?;
    link.adapter().close();
    let bytes: Vec<String> = answer.iter().map(|byte| format!("{byte:02X}")).collect();
    terminal.line(bytes.join(" "))?;
    terminal.document(&json!({"request": request, "answer": bytes.concat()}))
}

fn send(link: &mut Link, target: Target, request: &str) -> Result<Vec<u8>, Failure> {
    match target {
        Target::Fsc(sensor) => {
            let bytes = bytes(request)?;
            let (&code, data) = bytes.split_first().ok_or_else(|| bad(request))?;
            let reply = fsc::must(link, sensor, code, data, fsc::SAVED)?;
            Ok([&[code, reply.status], &reply.data[..]].concat())
        }
        Target::Canopen(node) => {
            let (address, data) = match request.split_once('=') {
                Some((address, data)) => (address, Some(bytes(data)?)),
                None => (request, None),
            };
            let (index, sub) = address.split_once(':').unwrap_or((address, "0"));
            let index = u16::from_str_radix(index.trim(), 16).map_err(|_| bad(request))?;
            let sub = u8::from_str_radix(sub.trim(), 16).map_err(|_| bad(request))?;
            let server = Server {
                time: SAVED,
                ..Server::of(node)
            };
            let what = format!("{index:04X}h:{sub:02X}");
            match data {
                Some(data) => {
                    server.write(link, index, sub, &data)?.must(node, &what)?;
                    Ok(Vec::new())
                }
                None => server.read(link, index, sub)?.must(node, &what),
            }
        }
        Target::Devicenet(slave) => {
            let bytes = bytes(request)?;
            let [service, class, instance, ref data @ ..] = bytes[..] else {
                return Err(bad(request));
            };
            slave.allocate(link)?;
            let path = Path { class, instance };
            let response = slave.explicit(link, service, path, data);
            slave.release(link)?;
            response?.must(slave.mac, "the request")
        }
    }
}

/// Hexadecimal bytes, with or without spaces.
fn bytes(text: &str) -> Result<Vec<u8>, Failure> {
    let digits: Vec<u8> = text
        .bytes()
        .filter(|byte| !byte.is_ascii_whitespace())
        .collect();
    if !digits.len().is_multiple_of(2) || !digits.iter().all(u8::is_ascii_hexdigit) {
        return Err(bad(text));
    }
    let value = |digit: u8| char::from(digit).to_digit(16).unwrap_or(0) as u8;
    Ok(digits
        .chunks(2)
        .map(|pair| value(pair[0]) << 4 | value(pair[1]))
        .collect())
}

fn bad(request: &str) -> Failure {
    let message = format!(
        "{request:?} is no request: bytes like 0300 (GEMAC), INDEX:SUB like 1018:1 or 6000:0=0A00 (CANopen), 0E650172 (DeviceNet)"
    );
    Failure::usage("bad-request", message)
}
