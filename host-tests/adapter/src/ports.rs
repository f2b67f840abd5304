//! The ports of this computer.

use super::gs_usb::{self, Port};
use super::pcan;
use serde::Serialize;

/// A port of this computer.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Listed {
    /// The name for `--port`.
    pub port: String,
    /// What it is, in words.
    pub kind: String,
}

fn listed(port: impl Into<String>, kind: impl Into<String>) -> Listed {
    let (port, kind) = (port.into(), kind.into());
    Listed { port, kind }
}

/// All ports that this computer has now. Without a list of the devices of a kind, the others are there.
pub fn ports() -> Vec<Listed> {
    let serial = serial2::SerialPort::available_ports().unwrap_or_default();
    let mut ports: Vec<Listed> = serial
        .iter()
        .map(|path| listed(format!("slcan:{}", path.display()), "serial"))
        .collect();
    ports.extend(devices(&interfaces(), &gs_usb::ports().unwrap_or_default()));
    let pcan = pcan::ports().into_iter();
    ports.extend(pcan.map(|(port, is_used)| {
        let kind = if is_used {
            "PCAN, used by another program"
        } else {
            "PCAN"
        };
        listed(port, kind)
    }));
    ports
}

/// The interfaces of SocketCAN and the adapters on USB; an adapter that the kernel uses is listed only as an interface.
fn devices(interfaces: &[String], usb: &[Port]) -> Vec<Listed> {
    let kind = |port: &Port| {
        let serial = port.serial.as_deref().unwrap_or_default();
        format!("candleLight (gs_usb) {serial}")
            .trim_end()
            .to_owned()
    };
    let of = |name: &String| {
        let own = usb.iter().find(|own| own.port == *name);
        let kind = own.map_or("socketcan".to_owned(), |own| {
            format!("socketcan, {}", kind(own))
        });
        listed(name, kind)
    };
    let mut ports: Vec<Listed> = interfaces.iter().map(of).collect();
    let others = usb.iter().filter(|own| !interfaces.contains(&own.port));
    ports.extend(others.map(|own| listed(&own.port, kind(own))));
    ports
}

/// The CAN interfaces of Linux.
pub(super) fn interfaces() -> Vec<String> {
    /// The type of a CAN interface (ARPHRD_CAN).
    const CAN: &str = "280";
    let entries = std::fs::read_dir("/sys/class/net").into_iter().flatten();
    let entries = entries.flatten().filter(|entry| {
        let kind = std::fs::read_to_string(entry.path().join("type"));
        kind.is_ok_and(|kind| kind.trim() == CAN)
    });
    let mut names: Vec<String> = entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn adapters_on_usb_are_offered_with_their_serial_numbers() {
        let port = |port: &str, serial: &str| Port {
            port: port.to_owned(),
            serial: Some(serial.to_owned()),
        };
        let interfaces = ["can0", "vcan0"].map(str::to_owned);
        let usb = [port("can0", "0031001A"), port("usb:0042003B", "0042003B")];
        assert_eq!(
            devices(&interfaces, &usb),
            [
                listed("can0", "socketcan, candleLight (gs_usb) 0031001A"),
                listed("vcan0", "socketcan"),
                listed("usb:0042003B", "candleLight (gs_usb) 0042003B"),
            ]
        );
    }
}
