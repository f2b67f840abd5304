//! Faults of the accelerometer, of its line and of its registers: which ones an is2 reports, after which time, and how they end. No reply
//! without an error has a wrong angle. `invalid.rs` has the answers of the other products to a fault.

use crate::accelerometer::{ERRORS, RATE, angle, memory, quick};
use crate::rig::*;
use bench::BusRate;
use stm32_sim::board::Board;
use stm32_sim::gpio::{Pin, PortName};
use stm32_sim::ism330dhcx::{Fault, Ism330dhcx, Sibling};

/// The registers by their addresses in the datasheet.
const FUNC_CFG_ACCESS: u8 = 0x01;
const WHO_AM_I: u8 = 0x0F;
const FIFO_TAG: u8 = 0x78;
const FIFO_STATUS2: u8 = 0x3B;

/// Changes the accelerometer at this time in picoseconds.
type Change = fn(&mut Ism330dhcx, u64);

/// A fault that the sensor reports.
struct Reported {
    name: &'static str,
    begin: Change,
    end: Change,
    /// The earliest and the latest time of the report in ms after the begin, and those of its end after the end of the fault.
    begins: (u64, u64),
    ends: (u64, u64),
}

/// No samples for 100 ms. The part is found within 5 ms, and has a value 45 ms later; the times of a poll are added.
const GONE: (u64, u64) = (95, 170);
const FOUND: (u64, u64) = (0, 130);

/// An axis is stuck after 32 values, 38 ms. Then there are no samples for 100 ms.
const STUCK: (u64, u64) = (130, 210);

/// The temperature is stuck after 10 s at the clock of the part. Then there are no readings for 100 ms. The noise of the simulated thermometer
/// ends it within 2 s.
const COLD: (u64, u64) = (8_000, 10_300);
const WARM: (u64, u64) = (0, 2_100);

/// After values without an error for 0.5 s. Up to 31 of them are from before the end of a stuck axis.
const CLEAN: (u64, u64) = (460, 800);

const REPORTED: [Reported; 13] = [
    Reported {
        name: "line stuck at 0",
        begin: |part, now| part.set_fault(now, Fault::Silent(0)),
        end: |part, now| part.set_fault(now, Fault::None),
        begins: GONE,
        // After an answer, the next attempt is 100 ms later.
        ends: (0, 230),
    },
    Reported {
        name: "line stuck at 1",
        begin: |part, now| part.set_fault(now, Fault::Silent(0xFF)),
        end: |part, now| part.set_fault(now, Fault::None),
        begins: GONE,
        ends: FOUND,
    },
    Reported {
        name: "no supply",
        begin: |part, _| part.unmount(),
        end: |part, now| part.power_on(now),
        begins: GONE,
        ends: FOUND,
    },
    Reported {
        name: "no samples",
        begin: |part, now| part.set_fault(now, Fault::Stopped),
        end: |part, now| part.set_fault(now, Fault::None),
        begins: GONE,
        ends: FOUND,
    },
    Reported {
        name: "X stuck",
        begin: |part, now| part.set_fault(now, Fault::Stuck(0, -712)),
        end: |part, now| part.set_fault(now, Fault::None),
        begins: STUCK,
        ends: CLEAN,
    },
    Reported {
        name: "temperature stuck",
        begin: |part, now| part.set_fault(now, Fault::StuckTemperature),
        end: |part, now| part.set_fault(now, Fault::None),
        begins: COLD,
        ends: WARM,
    },
    Reported {
        name: "no value changes",
        begin: |part, now| part.set_fault(now, Fault::Frozen),
        end: |part, now| part.set_fault(now, Fault::None),
        begins: STUCK,
        ends: CLEAN,
    },
    Reported {
        name: "wrong parity of each tag",
        begin: |part, _| part.spoil(FIFO_TAG, 1, u32::MAX),
        end: |part, _| part.spoil(FIFO_TAG, 0, 0),
        begins: GONE,
        ends: CLEAN,
    },
    Reported {
        name: "a bit error in each 50th byte",
        begin: |part, _| part.set_bit_errors(50),
        end: |part, _| part.set_bit_errors(0),
        begins: (95, 300),
        ends: CLEAN,
    },
    Reported {
        name: "a wrong bit in each second value",
        begin: |part, now| part.invert_each(now, 2, 10),
        end: |part, now| part.invert_each(now, 0, 0),
        // After 128 values.
        begins: (240, 330),
        // Up to 127 of the values without an error are from before the end.
        ends: (310, 800),
    },
    Reported {
        name: "a wrong bit in each 20th value",
        begin: |part, now| part.invert_each(now, 20, 13),
        end: |part, now| part.invert_each(now, 0, 0),
        // After 0.6 s.
        begins: (600, 900),
        ends: CLEAN,
    },
    Reported {
        name: "wrong identifier",
        begin: |part, _| part.spoil(WHO_AM_I, 1, u32::MAX),
        end: |part, _| part.spoil(WHO_AM_I, 0, 0),
        begins: GONE,
        ends: (0, 230),
    },
    Reported {
        name: "IIS2ICLX in its place",
        begin: |part, now| {
            part.set_sibling(Sibling::Iis2iclx);
            part.power_on(now);
        },
        end: |part, now| {
            part.set_sibling(Sibling::Ism330dhcx);
            part.power_on(now);
        },
        begins: GONE,
        ends: (0, 230),
    },
];

/// Polls until the status is `status`, and returns the time in ms. An angle without an error must be right within `tolerance`, in 0.01
/// degrees.
#[track_caller]
fn wait(rig: &mut Rig, status: u8, limit: u64, tolerance: u16, name: &str) -> u64 {
    let start = rig.bus.now().ticks();
    loop {
        let reply = rig.poll();
        let passed = (rig.bus.now().ticks() - start) / 1000;
        if reply[1] == status {
            return passed;
        }
        assert!(passed <= limit, "{name}: {reply:02X?} after {passed} ms");
        assert!(
            reply[1] != 0 || is_within(&reply, tolerance),
            "{name}: {reply:02X?}"
        );
        rig.run(4);
    }
}

/// 10 and 5 degrees. A count of the accelerometer is 0.014 degrees.
fn is_right(reply: &[u8]) -> bool {
    is_within(reply, 2)
}

pub fn is_within(reply: &[u8], tolerance: u16) -> bool {
    angle(reply, 2).abs_diff(1000) <= tolerance && angle(reply, 4).abs_diff(500) <= tolerance
}

/// Polls for this time; there must be no error, and each angle must be right.
#[track_caller]
fn stays_right(rig: &mut Rig, ms: u64, name: &str) {
    for passed in (0..ms).step_by(5) {
        let reply = rig.poll();
        assert_eq!(reply[1], 0, "{name}: {reply:02X?} after {passed} ms");
        assert!(is_right(&reply), "{name}: {reply:02X?} after {passed} ms");
        rig.run(4);
    }
}

#[test]
pub fn fault_is_reported_and_ends_within_its_times() {
    for Reported {
        name,
        begin,
        end,
        begins,
        ends,
    } in REPORTED
    {
        let mut rig = quick();
        let (io, now) = rig.io();
        begin(&mut io.imu, now);
        let tolerance = match name {
            // A wrong bit in the data, of which at most 0.06 degrees are left.
            "a bit error in each 50th byte" | "a wrong bit in each 20th value" => 8,
            // Half of 1024 counts.
            "a wrong bit in each second value" => 900,
            _ => 2,
        };
        let began = wait(&mut rig, ERRORS, begins.1, tolerance, name);
        // It is not reported in between.
        for _ in 0..400 {
            assert_eq!(rig.poll()[1], ERRORS, "{name}");
            rig.run(4);
        }
        let (io, now) = rig.io();
        end(&mut io.imu, now);
        let ended = wait(&mut rig, 0, ends.1, 2, name);
        println!("{name}: reported after {began} ms, ends after {ended} ms");
        assert!(
            began >= begins.0 && ended >= ends.0,
            "{name}: {began}, {ended}"
        );
        stays_right(&mut rig, 500, name);
    }
}

/// Otherwise it would heat without a limit.
#[test]
pub fn heater_is_off_while_the_temperature_is_stuck() {
    let mut rig = Rig::booted("is2tk", RATE);
    rig.run(500);
    assert!(rig.microcontroller().heater() > 0);
    let (io, now) = rig.io();
    io.imu.set_fault(now, Fault::StuckTemperature);
    rig.run(COLD.1);
    assert_eq!(rig.microcontroller().heater(), 0);
    let (io, now) = rig.io();
    io.imu.set_fault(now, Fault::None);
    rig.run(WARM.1);
    assert!(rig.microcontroller().heater() > 0);
}

/// What the driver restores before the sensor would report it.
#[test]
fn momentary_disturbance_changes_neither_status_nor_angle() {
    let disturbances: [(&str, Change); 9] = [
        ("one wrong parity", |part, _| part.spoil(FIFO_TAG, 1, 1)),
        ("one skipped counter", |part, _| {
            part.spoil(FIFO_TAG, 0b110, 1)
        }),
        ("one other sensor", |part, _| part.spoil(FIFO_TAG, 0x11, 1)),
        ("one lost word", |part, now| part.lose_words(now, 1)),
        ("two lost words", |part, now| part.lose_words(now, 2)),
        ("one wrong number of words", |part, _| {
            part.spoil(FIFO_STATUS2, 1, 1)
        }),
        ("one impossible number of words", |part, _| {
            part.spoil(FIFO_STATUS2, 4, 1)
        }),
        ("one wrong identifier", |part, _| {
            part.spoil(WHO_AM_I, 0xFF, 1)
        }),
        ("reset of the part", |part, now| part.power_on(now)),
    ];
    let mut rig = quick();
    for (name, disturb) in disturbances {
        for phase in [0, 1_700, 3_300] {
            rig.run_us(phase);
            let (io, now) = rig.io();
            disturb(&mut io.imu, now);
            stays_right(&mut rig, 400, name);
            // Until it is a single one again.
            rig.run(1_200);
        }
    }
}

/// A disturbed register of the part. The control registers are 10h to 17h; BOOT and SW_RESET return to 0.
#[test]
fn disturbed_register_of_the_accelerometer_is_restored_without_a_wrong_angle() {
    let registers = (0x07..=0x0A).chain(0x10..=0x19).chain([FUNC_CFG_ACCESS]);
    let mut rig = quick();
    for register in registers {
        let bits = match register {
            FUNC_CFG_ACCESS => 0xC0,
            0x12 => 0x7E,
            _ => 0xFF_u8,
        };
        for bit in (0..8).filter(|bit| bits >> bit & 1 != 0) {
            let name = format!("register {register:02X}h, bit {bit}");
            let (io, now) = rig.io();
            let before = io.imu.register(register);
            io.imu.upset(now, register, 1 << bit);
            assert_ne!(io.imu.register(register), before, "{name}");
            stays_right(&mut rig, 150, &name);
            assert_eq!(rig.io().0.imu.register(register), before, "{name}");
        }
    }
    // With a disturbed register, the accesses of the driver are violations.
    std::mem::forget(rig);
}

/// Without a pull-up the line can be low in the boot of the part, in which a write is a complaint of the simulator.
#[test]
fn nothing_is_written_in_a_boot_in_which_the_line_is_low() {
    for phase in [0, 1_700, 3_300] {
        let mut rig = quick();
        rig.run_us(phase);
        let (io, now) = rig.io();
        io.imu.power_on(now);
        io.imu.set_fault(now, Fault::Silent(0));
        rig.run(11);
        let (io, now) = rig.io();
        io.imu.set_fault(now, Fault::None);
        stays_right(&mut rig, 400, "line low in the boot");
    }
}

/// The same registers, values and behaviour, for vehicles.
#[test]
fn asm330lhh_is_accepted() {
    let mut rig = Rig::with("is2", BusRate::Fixed(RATE), memory());
    rig.io().0.imu.set_sibling(Sibling::Asm330lhh);
    rig.boot_up();
    rig.run(300);
    stays_right(&mut rig, 1_000, "ASM330LHH");
}

/// The IIS2ICLX has the same identifier, but two axes and a range of 2 g where the others have 8 g.
#[test]
fn iis2iclx_is_a_sensor_error_from_the_boot_up_messages_on() {
    for (x, y) in [(10.0, 5.0), (12.0, 0.0), (0.0, -15.0), (0.0, 0.0)] {
        let mut rig = Rig::with("is2", BusRate::Fixed(RATE), memory());
        rig.io().0.imu.set_sibling(Sibling::Iis2iclx);
        rig.bus.device_mut(rig.sensor).set_motion(tilt("is2", x, y));
        for _ in 0..2 {
            let boot_up = rig.expect(REPLY, 1000);
            assert_eq!(boot_up.bytes()[1], ERRORS, "{x} {y}");
        }
        for _ in 0..100 {
            assert_eq!(rig.poll()[1], ERRORS, "{x} {y}");
            rig.run(11);
        }
    }
}

/// Without motion the angle stays right. With motion it is wrong until the axis is known to be stuck.
#[test]
fn axis_stuck_at_each_value_is_reported_at_each_angle() {
    let mut rig = quick();
    for (x, axis, count) in [0.0, 40.0, 50.0].into_iter().flat_map(|x| {
        let axes = (0..3).flat_map(|axis| [0, 7, -2000].map(|count| (axis, count)));
        axes.map(move |(axis, count)| (x, axis, count))
    }) {
        rig.bus
            .device_mut(rig.sensor)
            .set_motion(tilt("is2", x, 0.0));
        rig.run(700);
        assert_eq!(rig.poll()[1], 0, "{x} deg, axis {axis}: {count}");
        let (io, now) = rig.io();
        io.imu.set_fault(now, Fault::Stuck(axis, count));
        rig.run(STUCK.1);
        assert_eq!(rig.poll()[1], ERRORS, "{x} deg, axis {axis}: {count}");
        let (io, now) = rig.io();
        io.imu.set_fault(now, Fault::None);
    }
}

/// Its values need 107 kbit/s. Edges of 50 MHz would ring on loose wires.
#[test]
pub fn spi_runs_at_2_mhz_with_slow_edges() {
    let mut rig = quick();
    let io = rig.io().0;
    assert_eq!(io.spi_bit_rate(), 2_000_000);
    let (port, pins) = match board() {
        Board::BluePill => (PortName::A, &[4, 5, 7][..]),
        Board::NucleoF103 => (PortName::B, &[12, 13, 15][..]),
        // At low speed the last bit of a transfer can be wrong there.
        Board::NucleoF446 => (PortName::B, &[][..]),
    };
    for pin in pins {
        let edges = io.gpio.highest_frequency(Pin(port, *pin));
        assert_eq!(edges, 10_000_000, "{port:?}{pin}");
    }
}
