//! The adapters on USB, and their transfers by nusb.

use super::{GsUsb, Usb};
use crate::error::{AdapterError, UsbHint};
use nusb::descriptors::{ConfigurationDescriptor, TransferType};
use nusb::transfer::{
    Buffer, Bulk, ControlIn, ControlOut, ControlType, Direction, In, Out, Recipient, TransferError,
};
use nusb::{Device, DeviceInfo, Endpoint, ErrorKind, Interface, MaybeFuture};
use std::io;
use std::time::Duration;

/// Vendor and product of the adapters: gs_usb and CANable, candleLight, CES CANext FD, ABE CANdebugger FD.
const ADAPTERS: [(u16, u16); 4] = [
    (0x1D50, 0x606F),
    (0x1209, 0x2323),
    (0x1CD2, 0x606F),
    (0x16D0, 0x10B8),
];

/// The class of an interface that only its maker defines.
const VENDOR_CLASS: u8 = 0xFF;

/// The wait for a request.
const REQUEST: Duration = Duration::from_secs(1);

/// The wait until the device takes a frame.
const WRITE: Duration = Duration::from_millis(200);

/// The transfers from the device that wait for its frames.
const READS: usize = 32;

/// The length of a transfer from the device at least: a frame with a time stamp.
const FRAME: usize = 24;

/// The interface of the adapter in the descriptors of the device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Layout {
    /// The number of the interface.
    pub interface: u8,
    /// The address of the bulk endpoint from the device.
    pub input: u8,
    /// The address of the bulk endpoint to the device.
    pub output: u8,
    /// The packet size of the endpoint from the device, in bytes.
    pub packet: usize,
}

impl Layout {
    /// The first interface with a vendor class and bulk endpoints in both directions.
    pub fn of(configuration: &[u8]) -> Option<Self> {
        let configuration = ConfigurationDescriptor::new(configuration)?;
        let mut settings = configuration
            .interface_alt_settings()
            .filter(|setting| setting.alternate_setting() == 0 && setting.class() == VENDOR_CLASS);
        settings.find_map(|setting| {
            let bulk = |direction| {
                setting.endpoints().find(|endpoint| {
                    endpoint.transfer_type() == TransferType::Bulk
                        && endpoint.direction() == direction
                })
            };
            let (input, output) = (bulk(Direction::In)?, bulk(Direction::Out)?);
            Some(Self {
                interface: setting.interface_number(),
                input: input.address(),
                output: output.address(),
                packet: Some(input.max_packet_size()).filter(|size| *size > 0)?,
            })
        })
    }
}

/// The interface that was taken.
struct Claimed {
    interface: Interface,
    input: Endpoint<Bulk, In>,
    output: Endpoint<Bulk, Out>,
}

/// A device of this computer.
pub struct NusbDevice {
    device: Device,
    claimed: Option<Claimed>,
}

impl NusbDevice {
    fn claimed(&mut self) -> io::Result<&mut Claimed> {
        self.claimed
            .as_mut()
            .ok_or_else(|| io::ErrorKind::NotConnected.into())
    }
}

impl Usb for NusbDevice {
    fn configuration(&self) -> Vec<u8> {
        let active = self.device.active_configuration();
        active.map_or(Vec::new(), |active| active.as_bytes().to_vec())
    }

    fn claim(&mut self, layout: &Layout) -> io::Result<()> {
        let interface = self.device.claim_interface(layout.interface).wait()?;
        let mut input = interface.endpoint::<Bulk, In>(layout.input)?;
        let output = interface.endpoint::<Bulk, Out>(layout.output)?;
        // A whole number of packets.
        let length = layout.packet * FRAME.div_ceil(layout.packet);
        for _ in 0..READS {
            input.submit(Buffer::new(length));
        }
        self.claimed = Some(Claimed {
            interface,
            input,
            output,
        });
        Ok(())
    }

    fn control_out(&mut self, request: u8, value: u16, data: &[u8]) -> io::Result<()> {
        let interface = &self.claimed()?.interface;
        let control = ControlOut {
            control_type: ControlType::Vendor,
            recipient: Recipient::Interface,
            request,
            value,
            index: interface.interface_number().into(),
            data,
        };
        Ok(interface.control_out(control, REQUEST).wait()?)
    }

    fn control_in(&mut self, request: u8, value: u16, length: u16) -> io::Result<Vec<u8>> {
        let interface = &self.claimed()?.interface;
        let control = ControlIn {
            control_type: ControlType::Vendor,
            recipient: Recipient::Interface,
            request,
            value,
            index: interface.interface_number().into(),
            length,
        };
        Ok(interface.control_in(control, REQUEST).wait()?)
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        let output = &mut self.claimed()?.output;
        match output.transfer_blocking(bytes.into(), WRITE).status {
            Err(TransferError::Cancelled) => Err(io::ErrorKind::TimedOut.into()),
            status => Ok(status?),
        }
    }

    fn read(&mut self, timeout: Duration) -> io::Result<Option<Vec<u8>>> {
        let input = &mut self.claimed()?.input;
        if input.pending() == 0 {
            return Err(io::ErrorKind::NotConnected.into());
        }
        let Some(completion) = input.wait_next_complete(timeout) else {
            return Ok(None);
        };
        completion.status?;
        let mut buffer = completion.buffer;
        let bytes = buffer.get(..completion.actual_len).map(<[u8]>::to_vec);
        buffer.clear();
        input.submit(buffer);
        Ok(bytes)
    }
}

/// An adapter that was found.
#[derive(Clone, Debug, Default)]
struct Candidate {
    serial: Option<String>,
    /// The interface of SocketCAN, if the kernel has the adapter.
    interface: Option<String>,
}

/// The only adapter, or that with this serial number.
fn choose(candidates: &[Candidate], serial: Option<&str>) -> Result<usize, AdapterError> {
    let is_wanted = |candidate: &Candidate| match (serial, &candidate.serial) {
        (Some(serial), Some(own)) => own.eq_ignore_ascii_case(serial),
        (Some(_), None) => false,
        (None, _) => true,
    };
    let ports = || {
        let ports = candidates.iter().map(|candidate| {
            let serial = candidate
                .serial
                .as_deref()
                .unwrap_or("without serial number");
            format!("usb:{serial}")
        });
        ports.collect::<Vec<String>>().join(", ")
    };
    let mut places = (0..).zip(candidates).filter(|(_, own)| is_wanted(own));
    Err(match (places.next(), places.next()) {
        (Some((place, candidate)), None) => match &candidate.interface {
            None => return Ok(place),
            Some(interface) => AdapterError::HasInterface(interface.clone()),
        },
        (Some(_), Some(_)) => AdapterError::Several(ports()),
        (None, _) if candidates.is_empty() => AdapterError::NoUsb,
        (None, _) => AdapterError::OtherSerial(ports()),
    })
}

/// The interface of SocketCAN that the kernel has made of a device.
#[cfg(target_os = "linux")]
fn kernel_interface(info: &DeviceInfo) -> Option<String> {
    let folders = std::fs::read_dir(info.sysfs_path()).ok()?;
    let mut interfaces = folders.flatten().filter_map(|folder| {
        let mut names = std::fs::read_dir(folder.path().join("net")).ok()?;
        Some(
            names
                .next()?
                .ok()?
                .file_name()
                .to_string_lossy()
                .into_owned(),
        )
    });
    interfaces.next()
}

#[cfg(not(target_os = "linux"))]
fn kernel_interface(_: &DeviceInfo) -> Option<String> {
    None
}

/// A port that a user can choose.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Port {
    /// The port: `usb:SERIAL`, or the interface of the kernel.
    pub port: String,
    /// The serial number of the adapter.
    pub serial: Option<String>,
}

/// The ports of these adapters. One without serial number is `usb`, which works if it is the only one.
fn ports_of(candidates: &[Candidate]) -> Vec<Port> {
    let ports = candidates.iter().map(|candidate| {
        let Candidate { serial, interface } = candidate.clone();
        let port = match (&interface, &serial) {
            (Some(interface), _) => interface.clone(),
            (None, Some(serial)) => format!("usb:{serial}"),
            (None, None) => "usb".to_owned(),
        };
        Port { port, serial }
    });
    ports.collect()
}

/// The ports of the adapters that are plugged in.
///
/// # Errors
/// The devices on USB cannot be listed.
pub fn ports() -> Result<Vec<Port>, AdapterError> {
    let found = found()?;
    let candidates: Vec<Candidate> = found.into_iter().map(|(_, own)| own).collect();
    Ok(ports_of(&candidates))
}

/// The adapters that are plugged in.
fn found() -> Result<Vec<(DeviceInfo, Candidate)>, AdapterError> {
    let devices = nusb::list_devices()
        .wait()
        .map_err(|error| AdapterError::NoUsbList(error.to_string()))?;
    let adapters = devices.filter(|info| ADAPTERS.contains(&(info.vendor_id(), info.product_id())));
    let found = adapters.map(|info| {
        let candidate = Candidate {
            serial: info.serial_number().map(str::to_owned),
            interface: kernel_interface(&info),
        };
        (info, candidate)
    });
    Ok(found.collect())
}

/// The adapter with this serial number, or the only one.
///
/// # Errors
/// There is none, there are several, or it cannot be used.
pub fn connect(serial: Option<&str>) -> Result<GsUsb<NusbDevice>, AdapterError> {
    let failed = |name: &str, error: nusb::Error| {
        let hint = match error.kind() {
            ErrorKind::PermissionDenied => UsbHint::Permission,
            ErrorKind::Busy => UsbHint::Busy,
            ErrorKind::Unsupported => UsbHint::Driver,
            _ => UsbHint::Other,
        };
        AdapterError::UsbUnopened(name.to_owned(), error.to_string(), hint)
    };
    let (devices, candidates): (Vec<DeviceInfo>, Vec<Candidate>) = found()?.into_iter().unzip();
    let place = choose(&candidates, serial)?;
    let name = match &candidates[place].serial {
        Some(serial) => format!("usb:{serial}"),
        None => "usb".to_owned(),
    };
    let device = devices[place].open().wait();
    let device = device.map_err(|error| failed(&name, error))?;
    let usb = NusbDevice {
        device,
        claimed: None,
    };
    GsUsb::new(usb, &name)
}

#[cfg(test)]
mod tests;
