//! POSITAL TILTIX 080, two axes, DeviceNet.
#![cfg_attr(target_os = "none", no_std, no_main)]

use plumbline::model::tiltix::tiltix080::Tiltix080;

firmware_stm32::firmware!(Tiltix080, "POSITAL TILTIX080", Tiltix080::IMAGE);
