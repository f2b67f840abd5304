//! The lines of the log with the raw values of a unit: the firmware writes them, and `plumbline calibrate` reads them.

/// One of the lines: passes its format, in the syntax of defmt, and the arguments to a macro. With `concat` it is the format.
///
/// ```
/// let format = plumbline::calibration_line!(serial, concat);
/// assert!(format.contains("{=u32}"));
/// ```
#[macro_export]
macro_rules! calibration_line {
    // The name of the measuring element, at the start.
    (element, $macro:ident $(, $argument:expr)*) => {
        $macro!("measuring element {=str}" $(, $argument)*)
    };
    // The serial number of the chip, at the start.
    (serial, $macro:ident $(, $argument:expr)*) => {
        $macro!("serial number {=u32}" $(, $argument)*)
    };
    // A reading: the acceleration on three axes, the temperature, and the angular rate on three axes.
    (reading, $macro:ident $(, $argument:expr)*) => {
        $macro!(
            "acceleration {=i32} {=i32} {=i32} ug, {=i16} 0.01 degC, rate {=i32} {=i32} {=i32} mdps"
            $(, $argument)*
        )
    };
}
