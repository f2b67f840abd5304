//! Where the sensor is, from the options of the command line.

use crate::client::devicenet::Slave;
use crate::client::fsc::Sensor;
use crate::error::Error;
use crate::labels::Labels;
use crate::master::{Ca, Node, Target};
use crate::number::identifier;
use crate::scan::Memory;
use crate::sheet::Sheet;
use plumbline::can::{BitRate, CanId};
use plumbline::model::catalog::Product;

/// Where the sensor is, as far as the user says.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// The bit rate of the options; None: the tool finds it.
    pub rate: Option<BitRate>,
    /// The bit rate is that of the last command. Another bus can be at the adapter now, so the tool listens first.
    pub is_remembered: bool,
    /// The address of the options; None: the only sensor on the bus.
    pub target: Option<Target>,
    /// The product of the options, which the tool need not find out.
    pub product: Option<&'static Product>,
    /// The sheet of a device that is not in the catalogue; then `product` is the product of the sheet.
    pub sheet: Option<Sheet>,
    /// The names of sensors on this computer.
    pub labels: Labels,
    /// A DeviceNet slave of another master is only listened to. Otherwise it is refused.
    pub listens: bool,
    /// What an earlier scan has heard.
    pub memory: Memory,
}

/// The address of the options `--id`, `--node`, `--mac` and `--address`.
///
/// # Errors
/// More than one is given, or one is out of its range.
pub fn target(
    id: Option<&str>,
    node: Option<u8>,
    mac: Option<u8>,
    address: Option<u8>,
) -> Result<Option<Target>, Error> {
    match (id, node, mac, address) {
        (None, None, None, None) => Ok(None),
        (None, None, None, Some(address @ 0..=253)) => Ok(Some(Target::J1939(Ca(address)))),
        (None, None, None, Some(address)) => Err(no_address(
            "--address",
            address,
            "a J1939 address is 0 to 253",
        )),
        (Some(id), None, None, None) => {
            let bits = identifier(id)
                .map_err(|text| Error::usage("bad-value", format!("--id {id}: {text}")))?;
            let request = CanId::from_bits(bits);
            Ok(Some(Target::Fsc(Sensor {
                request,
                reply: None,
            })))
        }
        (None, Some(node @ 1..=127), None, None) => Ok(Some(Target::Canopen(Node(node)))),
        (None, None, Some(mac @ 0..=63), None) => Ok(Some(Target::Devicenet(Slave { mac }))),
        (None, Some(node), None, None) => Err(no_address("--node", node, "a node-ID is 1 to 127")),
        (None, None, Some(mac), None) => Err(no_address("--mac", mac, "a MAC ID is 0 to 63")),
        _ => Err(Error::usage(
            "too-many-addresses",
            "give one of --id (GEMAC), --node (CANopen), --mac (DeviceNet) and --address (J1939)",
        )),
    }
}

fn no_address(option: &str, number: u8, why: &str) -> Error {
    let message = format!(
        "{option} {number}: {why}; `plumbline scan` shows the addresses of the sensors on the bus"
    );
    Error::usage("out-of-range", message)
}
