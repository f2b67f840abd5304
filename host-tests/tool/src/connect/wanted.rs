//! Where the sensor is, from the options of the command line.

use crate::labels::Labels;
use crate::master::Target;
use crate::scan::Memory;
use crate::sheet::Sheet;
use plumbline::can::BitRate;
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
