//! The rows of the table: the title and the exact definition of each.
//!
//! Instructions are those of the main program between the first instruction of a function and its return, including called
//! functions, but not interrupts, unless a row states otherwise.

use std::fmt;

/// The unit of a figure.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Unit {
    /// Bytes of flash or RAM.
    Bytes,
    /// Instructions executed.
    Instructions,
    /// Nanoseconds of simulated time.
    Nanoseconds,
    /// A number of saves. It has no budget: a test asserts it exactly.
    Saves,
}

/// A row of the table.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Row {
    /// Its name in `budgets.toml` and in JSON.
    pub key: &'static str,
    /// The title in the tables.
    pub title: &'static str,
    /// The unit of its figure.
    pub unit: Unit,
    /// What is counted.
    pub counts: &'static str,
    /// The figures of other implementations for the same work; may be empty.
    pub others: &'static str,
}

const fn row(
    unit: Unit,
    key: &'static str,
    title: &'static str,
    counts: &'static str,
    others: &'static str,
) -> Row {
    Row {
        key,
        title,
        unit,
        counts,
        others,
    }
}

const fn bytes(key: &'static str, title: &'static str, counts: &'static str) -> Row {
    row(Unit::Bytes, key, title, counts, "")
}

const fn instructions(
    key: &'static str,
    title: &'static str,
    counts: &'static str,
    others: &'static str,
) -> Row {
    row(Unit::Instructions, key, title, counts, others)
}

const fn time(key: &'static str, title: &'static str, counts: &'static str) -> Row {
    row(Unit::Nanoseconds, key, title, counts, "")
}

/// Every row, in the order of the table. A model may not have all of them.
pub const ROWS: &[Row] = &[
    bytes(
        "flash",
        "flash",
        "everything that is programmed: vectors, code, constants, initial values",
    ),
    bytes(
        "flash_core",
        "- core",
        "the crate plumbline: measurement, protocol, node, store",
    ),
    row(
        Unit::Bytes,
        "flash_protocol",
        "- - node and protocol",
        "part of core: the functions of the modules node, param, and fsc, canopen, devicenet or j1939, including inlined functions",
        "CANopenNode 17656",
    ),
    bytes(
        "flash_driver",
        "- driver",
        "the firmware's own code: main loop, CAN, flash, board",
    ),
    bytes(
        "flash_libraries",
        "- libraries and HAL",
        "hardware drivers and other dependencies",
    ),
    bytes(
        "flash_runtime",
        "- runtime",
        "the compiler's runtime, and the startup code",
    ),
    bytes("flash_vectors", "- vectors", "the vector table"),
    bytes(
        "flash_constants",
        "- constants",
        "constants that the compiler has merged or that have no name",
    ),
    bytes("flash_padding", "- padding", "gaps that no symbol covers"),
    bytes(
        "ram",
        "RAM with the stack's peak",
        "static RAM and the peak of the stack",
    ),
    bytes(
        "ram_core",
        "- core",
        "statics of the crate plumbline; the sensor itself is a static of the driver",
    ),
    bytes(
        "ram_driver",
        "- driver",
        "statics of the firmware's own code, including the sensor, the store and the receive queue",
    ),
    bytes("ram_libraries", "- libraries and HAL", "statics of crates"),
    bytes(
        "ram_runtime",
        "- runtime",
        "statics of the compiler and of the startup code",
    ),
    bytes("ram_padding", "- padding", "gaps between statics"),
    bytes(
        "stack",
        "- stack, peak",
        "from the top of the stack to the lowest value of the stack pointer, including interrupts, in the complete scenario: boot with \
         blank memory, bit rate detection, every request, cyclic mode, saves with and without the erase of a page, bus-off and \
         recovery, power cycle, LOAD, restart",
    ),
    instructions(
        "idle_poll",
        "idle poll",
        "one call of Communication::is_idle without input and without a due deadline: the median over 100 ms",
        "CANopenNode 424, zencan 738",
    ),
    instructions(
        "read_request",
        "inclination request to reply",
        "every call of the node for one request: Communication::receive, transmit with the reply and once more without a frame, and all calls \
         up to the next is_idle that returns true; the maximum of 20; without the driver",
        "SDO upload: CANopenNode 905, zencan 1443",
    ),
    instructions(
        "read_reply",
        "- until the reply is returned",
        "of these, Communication::receive to the end of the transmit that returns the reply; the maximum of 20",
        "",
    ),
    instructions(
        "write_request",
        "parameter write to reply",
        "the same for a request that writes a parameter (the cyclic time)",
        "",
    ),
    instructions(
        "sync",
        "SYNC to reply",
        "the same for a synchronous message whose reply contains the angles; with DeviceNet, a poll command",
        "SYNC to TPDO of two 16-bit values: CANopenNode 701, zencan 1254",
    ),
    instructions(
        "sync_reply",
        "- until the reply is returned",
        "of these, Communication::receive to the end of the transmit that returns the reply; the maximum of 20",
        "",
    ),
    instructions(
        "lss_request",
        "LSS inquiry to reply",
        "the same for the LSS inquiry of the node-ID",
        "",
    ),
    instructions(
        "block_segment",
        "segment of an SDO block",
        "the same for the start of a block upload whose block has one segment",
        "",
    ),
    instructions(
        "j1939_ssi2",
        "J1939, SSI2",
        "every call of the node for one cyclic SSI2 without a request: Communication::tick that composes and queues it, transmit and the          calls up to the next is_idle that returns true; the median over 300 ms",
        "",
    ),
    instructions(
        "j1939_request",
        "J1939, request (59904) to answer",
        "as the inclination request, for a request for SSI2",
        "",
    ),
    instructions(
        "j1939_parameter",
        "J1939, parameter request (61184) to answer",
        "the same for an angle by the bytes of an SDO",
        "",
    ),
    instructions(
        "j1939_claim",
        "J1939, contention to address claim",
        "the same for a claim of the own address with a higher NAME, which the own claim answers",
        "",
    ),
    instructions(
        "publish",
        "new values, change-of-state check",
        "one call of Communication::finish, which publishes values as after a sample; with DeviceNet while a COS connection compares each word \
         with the one last sent; the maximum of 20",
        "",
    ),
    instructions(
        "sample_off",
        "sample, filter off",
        "Acquisition::sample: calibration, low-pass, angles, limit checks; the maximum of 100 samples in many directions",
        "",
    ),
    instructions(
        "sample_average",
        "sample, recursive filter and moving average",
        "the same with both filters of the TILTIX on two angles, 250 entries",
        "",
    ),
    instructions(
        "sample_butterworth",
        "sample, Butterworth",
        "the same with the Butterworth filter of order 8 on three components",
        "",
    ),
    instructions(
        "sample_critically_damped",
        "sample, critically damped",
        "the same with the critically damped filter of order 8 on three components",
        "",
    ),
    instructions(
        "sample_fir_10",
        "sample, FIR 10 Hz",
        "the same with the FIR filter at 10 Hz on three components",
        "",
    ),
    instructions("sample_fir_5", "sample, FIR 5 Hz", "the same at 5 Hz", ""),
    instructions("sample_fir_1", "sample, FIR 1 Hz", "the same at 1 Hz", ""),
    instructions(
        "sample_fir_half",
        "sample, FIR 0.5 Hz",
        "the same at 0.5 Hz",
        "",
    ),
    instructions(
        "sample_fusion",
        "sample, Kalman filter",
        "the same with the Kalman filter of acceleration and angular rate",
        "",
    ),
    instructions(
        "calibration",
        "- calibration",
        "Calibration::apply: offset, gain, cross axes, temperature; the maximum of all samples",
        "",
    ),
    instructions(
        "step_butterworth",
        "- low-pass, Butterworth",
        "LowPass::step: order 8 on three components; the maximum of 100",
        "the sections alone 429",
    ),
    instructions(
        "step_critically_damped",
        "- low-pass, critically damped",
        "LowPass::step: order 8 on three components; the maximum of 100",
        "",
    ),
    instructions(
        "step_fir",
        "- low-pass, FIR",
        "Fir::step: the maximum of 100 at each frequency",
        "",
    ),
    instructions(
        "step_fusion",
        "- Kalman filter",
        "Fusion::step: the maximum of 100",
        "",
    ),
    instructions(
        "perpendicular",
        "- both angles",
        "definition::perpendicular: both angles of a vector; the maximum of all samples",
        "",
    ),
    instructions(
        "angle",
        "- per angle",
        "half of the previous row, rounded up",
        "",
    ),
    instructions(
        "tilt",
        "- tilt",
        "definition::tilt: one of the angles, of a normalised vector; the maximum of all samples",
        "",
    ),
    instructions(
        "atan2",
        "- atan2",
        "Angle::atan2: the maximum of all samples",
        "65-entry table 56, idsp 122, CORDIC 304, CMSIS-DSP 559, micromath 786, libm atan2f 1400",
    ),
    instructions(
        "tune_butterworth",
        "new cut-off, Butterworth",
        "LowPass::tune: the coefficients from the frequency, and all states set to the last output; the maximum of three frequencies",
        "coefficients with libm 8613",
    ),
    instructions(
        "tune_critically_damped",
        "new cut-off, critically damped",
        "the same for the critically damped filter",
        "",
    ),
    instructions(
        "save",
        "save",
        "Store::save, every Store::step with the flash driver below it, Communication::stored: the median of the saves that fill both \
         pages of blank memory and erase one; while flash is busy the processor is stalled, which takes time but no instructions",
        "",
    ),
    instructions(
        "save_most",
        "save, worst case",
        "the maximum of these: a save into the first record of a page, which is first checked to be blank or erased",
        "",
    ),
    instructions(
        "boot",
        "boot",
        "all executed instructions, including interrupts, from power-up with a saved bit rate until the first frame is in a mailbox (to 1 us), \
         and all cycles of the processor; two thirds of them search the parameter memory",
        "",
    ),
    time(
        "boot_time",
        "power-up to first frame",
        "from power-up with a saved bit rate to the start of the first boot-up message on the wire",
    ),
    time(
        "boot_erase_time",
        "- with a page to erase ahead",
        "the same if one page is more than half full and the other one is not erased: this start erases the other one",
    ),
    time(
        "first_angle",
        "power-up to first angle",
        "from power-up with a saved bit rate to the start of the first reply with an angle on the wire; inclination requests every 500 us \
         from the boot-up message on",
    ),
    time(
        "sync_median",
        "end of SYNC to reply, median",
        "from the end of the SYNC frame, its last bit, to the start of the reply on the wire at 1 Mbit/s, the 3 us of intermission \
         included; the median of 2500 phases, 2 us apart, against the firmware's sampling and ticks, with the slowest filter",
    ),
    time(
        "sync_worst",
        "end of SYNC to reply, worst case",
        "the longest of these times",
    ),
    time(
        "read_median",
        "end of inclination request to reply, median",
        "the same for the inclination request",
    ),
    time(
        "read_worst",
        "end of inclination request to reply, worst case",
        "the longest of these times",
    ),
    time(
        "heater_worst",
        "- SYNC, while the heater is regulated",
        "the longest time of the reply at phases 2 us apart against a change of the heater's duty: from 60 us before the earliest position of the \
         change in the sampling period to 40 us after the latest one, in two passes",
    ),
    time(
        "heater_read_worst",
        "- inclination request, while the heater is regulated",
        "the same for the inclination request",
    ),
    time(
        "led_worst",
        "- SYNC, while LEDs change",
        "the same at phases against a change of the LEDs: of the run LED, or of the error LED, which flashes from the warning limit of the CAN \
         controller on",
    ),
    time(
        "led_read_worst",
        "- inclination request, while LEDs change",
        "the same for the inclination request",
    ),
    time(
        "save_worst",
        "- SYNC, while a save programs",
        "the longest time of the reply to SYNC at phases 2 us apart against a save that erases no page; replies that wait for \
         another frame of the sensor do not count; a half-word takes 70 us, the longest time of the datasheet",
    ),
    time(
        "save_read_worst",
        "- inclination request, while a save programs",
        "the same for the inclination request",
    ),
    time(
        "erase_worst",
        "- SYNC, during a save without an erased page",
        "the longest time of the reply to SYNC at phases against a save that must erase a page first: 500 us apart, around the worst \
         one 20 us, around the worst of these 2 us; a page takes 40 ms, the longest time of the datasheet",
    ),
    row(
        Unit::Saves,
        "saves_between",
        "- saves between two of these",
        "the number of saves with an erased page between two saves without an erased page, while the power stays on; a start erases a page ahead",
        "",
    ),
    time(
        "boot_worst",
        "- request, after the boot-up message",
        "the longest time of the reply to a request from the boot-up message to the first angle, after power-up with a saved bit rate: at \
         phases 2 us apart; of the phases in which the processor sleeps, only one",
    ),
];

impl Row {
    /// The row with this key.
    pub fn find(key: &str) -> Option<&'static Self> {
        ROWS.iter().find(|row| row.key == key)
    }

    /// A figure with the unit of this row.
    pub fn show(&self, figure: u64) -> Shown {
        Shown(self.unit, figure)
    }
}

/// A figure with its unit.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Shown(Unit, u64);

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(unit, figure) = *self;
        f.pad(&match unit {
            Unit::Bytes => format!("{figure} B"),
            Unit::Instructions | Unit::Saves => figure.to_string(),
            Unit::Nanoseconds if figure < 1_000_000 => format!("{:.2} us", figure as f64 / 1e3),
            Unit::Nanoseconds => format!("{:.1} ms", figure as f64 / 1e6),
        })
    }
}
