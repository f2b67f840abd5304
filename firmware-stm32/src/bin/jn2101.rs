//! ifm JN2101, two axes, CANopen.
#![cfg_attr(target_os = "none", no_std, no_main)]

use plumbline::model::jn2101::Jn2101;

firmware_stm32::firmware!(Jn2101, "ifm JN2101", Jn2101::IMAGE);
