//! The next steps after a refusal of the sensor.

/// The object, its access or its value is wrong.
pub(crate) const LIST: &str = "`plumbline parameters` lists the names and the permitted values";

/// The state of the device is wrong.
pub(crate) const WRONG_STATE: &str =
    "It can store or be in operation: wait some seconds, stop its master, and repeat";

/// The memory or the hardware has failed.
pub(crate) const FAILED: &str = "Repeat, and restart the sensor with `plumbline restart`; if it fails again, the sensor is faulty";

/// The request was damaged or came too late.
pub(crate) const REPEAT: &str =
    "Repeat; if it is refused again, `plumbline restart` restarts the sensor";
