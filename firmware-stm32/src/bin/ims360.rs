//! SIKO IMS360, one or two axes, CANopen or J1939.
#![cfg_attr(target_os = "none", no_std, no_main)]

use plumbline::model::ims360::Ims360;

firmware_stm32::firmware!(Ims360, "SIKO IMS360", Ims360::IMAGE);
