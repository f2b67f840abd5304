//! The port that a user means who writes something else: the name of a device, of an adapter or of its maker, or a wrong scheme.

use super::pcan;

/// How users call the adapters of PEAK.
const PEAK: [&str; 2] = ["peak", "pcan"];

/// How users call adapters with gs_usb.
const GS_USB: [&str; 6] = ["canable", "candlelight", "gsusb", "gs", "cando", "usbcan"];

/// Adapters whose drivers the tool cannot use: they have a port only as an interface of Linux.
const OTHERS: [&str; 7] = [
    "kvaser", "vector", "ixxat", "leaf", "vn1610", "systec", "esd",
];

/// What a user means.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Meant {
    /// This port.
    Port(String),
    /// An adapter that has no port on this system.
    Unsupported,
}

/// The port that a user means; None: it can be anything. `interfaces` are the CAN interfaces of Linux, None on another system.
pub(super) fn meant(port: &str, interfaces: Option<&[String]>) -> Option<Meant> {
    let interface = |name: &str| -> String {
        let own = interfaces.unwrap_or_default().iter();
        let mut own = own.filter(|own| own.as_str() == name);
        let first = || interfaces.and_then(<[String]>::first);
        own.next()
            .or_else(first)
            .map_or("can0", String::as_str)
            .to_owned()
    };
    let small = port.to_ascii_lowercase();
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let rest = |start: &str| small.strip_prefix(start);
    if small == "usb" || small == "pcan" {
        return Some(Meant::Port(small));
    }
    // slcan:socket://HOST:PORT, tcp://HOST:PORT, HOST:PORT
    let mut address = port;
    for scheme in ["slcan:", "socket:", "tcp:"] {
        let start = address.get(..scheme.len());
        if start.is_some_and(|start| start.eq_ignore_ascii_case(scheme)) {
            address = &address[scheme.len()..];
        }
    }
    let address = address.trim_start_matches('/');
    if is_address(address) {
        return Some(Meant::Port(format!("slcan://{address}")));
    }
    let device = port.trim_end_matches(':');
    let device = match device.split_once(':') {
        Some((scheme, device)) if ["serial", "slcan"].contains(&&*scheme.to_lowercase()) => device,
        _ => device,
    };
    let upper = device.to_ascii_uppercase();
    if upper.strip_prefix("COM").is_some_and(is_number) {
        return Some(Meant::Port(format!("slcan:{upper}")));
    }
    if device.starts_with("/dev/") {
        return Some(Meant::Port(format!("slcan:{device}")));
    }
    let mut starts = ["ttyACM", "ttyUSB", "cu.", "tty."].into_iter();
    if starts.any(|start| device.starts_with(start)) {
        return Some(Meant::Port(format!("slcan:/dev/{device}")));
    }
    let upper = port.to_ascii_uppercase();
    if pcan::is_channel(&upper) {
        let channel = upper.trim_start_matches("PCAN_");
        return Some(Meant::Port(format!("pcan:{channel}")));
    }
    for scheme in ["socketcan:", "can:"] {
        if let Some(name) = rest(scheme) {
            return Some(Meant::Port(interface(name)));
        }
    }
    let plain: String = small.chars().filter(char::is_ascii_alphanumeric).collect();
    let is_one = |names: &[&str]| {
        let mut names = names.iter();
        names.any(|name| plain.starts_with(name))
    };
    if is_one(&PEAK) {
        return Some(Meant::Port("pcan".to_owned()));
    }
    if GS_USB.contains(&plain.as_str()) {
        return Some(Meant::Port("usb".to_owned()));
    }
    if is_one(&OTHERS) {
        return Some(match interfaces {
            Some(_) => Meant::Port(interface("")),
            None => Meant::Unsupported,
        });
    }
    let number = plain
        .strip_prefix("can")
        .or_else(|| plain.strip_prefix("socketcan"));
    let is_interface = number.is_some_and(|number| number.is_empty() || is_number(number));
    let is_other = number == Some("") || plain != port;
    (is_interface && is_other).then_some(())?;
    interfaces.map(|_| Meant::Port(interface(&plain)))
}

/// Whether a text is `HOST:PORT`.
pub(super) fn is_address(text: &str) -> bool {
    text.rsplit_once(':').is_some_and(|(host, number)| {
        let is_host = !host.is_empty() && !host.contains(['/', ' ']);
        is_host && number.parse::<u16>().is_ok_and(|number| number > 0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn port(name: &str) -> Option<Meant> {
        Some(Meant::Port(name.to_owned()))
    }

    #[test]
    fn other_names_of_a_port_are_told_with_the_port_that_works() {
        let linux = ["can1".to_owned(), "vcan0".to_owned()];
        for (text, meant_port) in [
            ("peak", "pcan"),
            ("PCAN", "pcan"),
            ("PCAN-USB", "pcan"),
            ("pcan-usb pro", "pcan"),
            ("pcanusb1", "pcan"),
            ("PCAN_USBBUS2", "pcan:USBBUS2"),
            ("candleLight", "usb"),
            ("CANable", "usb"),
            ("USB", "usb"),
            ("slcan:socket://127.0.0.1:11898", "slcan://127.0.0.1:11898"),
            ("slcan:127.0.0.1:11898", "slcan://127.0.0.1:11898"),
            ("tcp://crane.local:2000", "slcan://crane.local:2000"),
            ("localhost:11898", "slcan://localhost:11898"),
            ("COM3", "slcan:COM3"),
            ("com12:", "slcan:COM12"),
            ("serial:COM3", "slcan:COM3"),
            ("/dev/ttyUSB0", "slcan:/dev/ttyUSB0"),
            ("ttyACM1", "slcan:/dev/ttyACM1"),
        ] {
            for interfaces in [None, Some(&linux[..])] {
                assert_eq!(meant(text, interfaces), port(meant_port), "{text}");
            }
        }
    }

    #[test]
    fn adapter_without_a_driver_of_the_tool_is_an_interface_on_linux_only() {
        let linux = ["can1".to_owned(), "vcan0".to_owned()];
        for text in ["kvaser", "Kvaser Leaf", "Vector", "IXXAT"] {
            assert_eq!(meant(text, Some(&linux)), port("can1"), "{text}");
            assert_eq!(meant(text, Some(&[])), port("can0"), "{text}");
            assert_eq!(meant(text, None), Some(Meant::Unsupported), "{text}");
        }
        for (text, meant_port) in [
            ("CAN0", "can1"),
            ("can", "can1"),
            ("socketcan", "can1"),
            ("socketcan:vcan0", "vcan0"),
            ("can:can1", "can1"),
        ] {
            assert_eq!(meant(text, Some(&linux)), port(meant_port), "{text}");
        }
        assert_eq!(meant("can", None), None);
    }

    #[test]
    fn other_words_are_no_port() {
        for text in [
            "",
            "sub:",
            "nonexistent0",
            "can7",
            "vcan3",
            "slcan:",
            "x:y",
            ":5",
        ] {
            assert_eq!(meant(text, Some(&["can1".to_owned()])), None, "{text}");
        }
    }
}
