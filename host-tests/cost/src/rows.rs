//! The rows of the table: the title and the exact definition of each.

use std::fmt;

/// The unit of a figure.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Unit {
    /// Bytes of flash or RAM.
    Bytes,
    /// Instructions that the processor executed.
    Instructions,
    /// Simulated time in nanoseconds.
    Nanoseconds,
    /// The number of saves until a page must be erased.
    Saves,
}

/// A row of the table.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Row {
    /// Its name in `figures.toml` and in JSON.
    pub key: &'static str,
    /// The title in the tables.
    pub title: &'static str,
    /// The unit of its figure.
    pub unit: Unit,
    /// True if its figure is recorded, and may not grow unnoticed.
    pub guard: bool,
    /// What the figure counts, as text in the table.
    pub counts: &'static str,
}

const fn row(
    unit: Unit,
    guard: bool,
    key: &'static str,
    title: &'static str,
    counts: &'static str,
) -> Row {
    Row {
        key,
        title,
        unit,
        guard,
        counts,
    }
}

const fn bytes(key: &'static str, title: &'static str, counts: &'static str) -> Row {
    row(Unit::Bytes, true, key, title, counts)
}

/// A part of the flash or of the RAM: only its sum means something to a user.
const fn part(key: &'static str, title: &'static str, counts: &'static str) -> Row {
    row(Unit::Bytes, false, key, title, counts)
}

const fn load(key: &'static str, title: &'static str, counts: &'static str) -> Row {
    row(Unit::Instructions, true, key, title, counts)
}

const fn time(key: &'static str, title: &'static str, counts: &'static str) -> Row {
    row(Unit::Nanoseconds, true, key, title, counts)
}

/// Every row, in the order of the table. A model may not have all of them.
pub const ROWS: &[Row] = &[
    bytes(
        "flash",
        "flash",
        "everything that is programmed: vectors, code, constants, initial values",
    ),
    part(
        "flash_core",
        "- core",
        "the crate plumbline: measurement, protocol, node, store",
    ),
    part(
        "flash_protocol",
        "- - node and protocol",
        "part of core: the functions of the modules node, param, and fsc, canopen, devicenet or j1939, including inlined functions",
    ),
    part(
        "flash_driver",
        "- driver",
        "the firmware's own code: main loop, CAN, flash, board",
    ),
    part(
        "flash_libraries",
        "- libraries and HAL",
        "hardware drivers and other dependencies",
    ),
    part(
        "flash_runtime",
        "- runtime",
        "the compiler's runtime, and the startup code",
    ),
    part("flash_vectors", "- vectors", "the vector table"),
    part(
        "flash_constants",
        "- constants",
        "constants that the compiler has merged or that have no name",
    ),
    part("flash_padding", "- padding", "gaps that no symbol covers"),
    bytes(
        "ram",
        "RAM with the stack's peak",
        "static RAM and the peak of the stack",
    ),
    part(
        "ram_core",
        "- core",
        "statics of the crate plumbline; the sensor itself is a static of the driver",
    ),
    part(
        "ram_driver",
        "- driver",
        "statics of the firmware's own code, including the sensor, the store and the receive queue",
    ),
    part("ram_libraries", "- libraries and HAL", "statics of crates"),
    part(
        "ram_runtime",
        "- runtime",
        "statics of the compiler and of the startup code",
    ),
    part("ram_padding", "- padding", "gaps between statics"),
    bytes(
        "stack",
        "- stack, peak",
        "from the top of the stack to the lowest value of the stack pointer, including interrupts, in the complete scenario: boot with \
         blank memory, bit rate detection, every request, cyclic mode, saves with and without the erase of a page, bus-off and \
         recovery, power cycle, LOAD, restart",
    ),
    load(
        "load_off",
        "load of a sample, filter off",
        "all executed instructions in a sampling period of 5 ms without messages, interrupts and driver included: the mean of 100",
    ),
    load(
        "load_average",
        "- in addition, recursive filter and moving average",
        "what is added by both filters of the TILTIX on two angles, 250 entries",
    ),
    load(
        "load_butterworth",
        "- in addition, Butterworth",
        "what is added by the Butterworth filter of order 8 on three components",
    ),
    load(
        "load_critically_damped",
        "- in addition, critically damped",
        "what is added by the critically damped filter of order 8 on three components",
    ),
    load(
        "load_fir_10",
        "- in addition, FIR 10 Hz",
        "what is added by the FIR filter at 10 Hz on three components",
    ),
    load("load_fir_5", "- in addition, FIR 5 Hz", "the same at 5 Hz"),
    load("load_fir_1", "- in addition, FIR 1 Hz", "the same at 1 Hz"),
    load(
        "load_fir_half",
        "- in addition, FIR 0.5 Hz",
        "the same at 0.5 Hz",
    ),
    load(
        "load_fusion",
        "- in addition, Kalman filter",
        "what is added by the Kalman filter of acceleration and angular rate",
    ),
    load(
        "boot",
        "boot",
        "all executed instructions, including interrupts, from power-up with a saved bit rate until the first frame is in a mailbox (to 1 us); \
         two thirds of them search the parameter memory",
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
        "write_median",
        "end of a parameter write to reply, median",
        "the same for a request that writes a parameter (the cyclic time); the median of 20",
    ),
    time(
        "lss_median",
        "end of an LSS inquiry to reply, median",
        "the same for the LSS inquiry of the node-ID",
    ),
    time(
        "block_median",
        "end of an SDO block request to its segment, median",
        "the same for the start of a block upload whose block has one segment",
    ),
    time(
        "j1939_request",
        "J1939, end of request (59904) to answer, median",
        "the same for a request for SSI2",
    ),
    time(
        "j1939_parameter",
        "J1939, end of parameter request (61184) to answer, median",
        "the same for an angle by the bytes of an SDO",
    ),
    time(
        "j1939_claim",
        "J1939, end of contention to address claim, median",
        "the same for a claim of the own address with a higher NAME, which the own claim answers",
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
        false,
        "saves_between",
        "- saves between two of these",
        "the number of saves with an erased page between two saves without an erased page, while the power stays on; a start erases a page ahead",
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
