//! POSITAL TILTIX 360, one axis, DeviceNet.
#![cfg_attr(target_os = "none", no_std, no_main)]

use plumbline::model::tiltix::tiltix360::Tiltix360;

firmware_stm32::firmware!(Tiltix360, "POSITAL TILTIX360", Tiltix360::IMAGE);
