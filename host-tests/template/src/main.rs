//! The firmware of the sensor.
#![cfg_attr(target_os = "none", no_std, no_main)]

use mast::Mast;
use plumbline::canopen::CanopenNode;

firmware_stm32::firmware!(CanopenNode<Mast>, "mast", CanopenNode::<Mast>::IMAGE);
