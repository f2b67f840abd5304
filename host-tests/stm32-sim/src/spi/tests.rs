use super::*;

const CR1: u32 = 0x00;
const SR: u32 = 0x08;
const DR: u32 = 0x0C;

/// Master, software select, on, PCLK2 / 16, mode 0.
const ON: u32 = 0x035C;

/// Answers each byte with its complement.
#[derive(Default)]
struct Complement {
    bytes: Vec<u8>,
    times: Vec<Picoseconds>,
}

impl SpiPart for Complement {
    fn select(&mut self, _: Picoseconds, _: bool) {}

    fn transfer(&mut self, now: Picoseconds, byte: u8) -> u8 {
        self.bytes.push(byte);
        self.times.push(now);
        !byte
    }
}

struct Bench {
    spi: Spi,
    part: Complement,
    violations: Violations,
    clocks: Clocks,
    cycle: u64,
}

impl Bench {
    fn new(cr1: u32) -> Self {
        let clocks = Clocks {
            hclk: 64_000_000,
            pclk: 64_000_000,
        };
        let mut bench = Self {
            spi: Spi::default(),
            part: Complement::default(),
            violations: Violations::default(),
            clocks,
            cycle: 1000,
        };
        bench.write(CR1, cr1);
        bench
    }

    fn advance(&mut self) {
        self.spi
            .advance(self.cycle, self.clocks, |cycle| cycle, &mut self.part);
    }

    fn write(&mut self, offset: u32, value: u32) {
        self.advance();
        self.spi
            .write(self.cycle, offset, value, self.clocks, &mut self.violations)
            .unwrap();
    }

    fn read(&mut self, offset: u32) -> u32 {
        self.advance();
        self.spi.read(offset).unwrap()
    }

    fn reasons(&self) -> Vec<&'static str> {
        self.violations.list().iter().map(|it| it.reason).collect()
    }
}

#[test]
fn reset_values() {
    let mut spi = Spi::default();
    for (offset, value) in [(0x00, 0), (0x04, 0), (0x08, 2), (0x0C, 0), (0x10, 7)] {
        assert_eq!(spi.read(offset), Ok(value));
    }
}

#[test]
fn frame_takes_eight_bits_of_prescaled_clock() {
    let mut bench = Bench::new(ON);
    bench.write(DR, 0xA5);
    assert_eq!(bench.read(SR), TRANSMIT_EMPTY | BUSY);
    // 8 * 16 cycles
    bench.cycle = 1127;
    assert_eq!(bench.read(SR), TRANSMIT_EMPTY | BUSY);
    bench.cycle = 1128;
    assert_eq!(bench.read(SR), TRANSMIT_EMPTY | RECEIVED);
    assert_eq!(bench.read(DR), 0x5A);
    assert_eq!(bench.read(SR), TRANSMIT_EMPTY);
    assert_eq!(
        (&bench.part.bytes[..], &bench.part.times[..]),
        (&[0xA5][..], &[1128][..])
    );
    assert_eq!(bench.reasons(), [""; 0]);
}

#[test]
fn prescalers_divide_pclk2() {
    for code in 0..8 {
        let mut bench = Bench::new(0x0344 | code << 3);
        bench.clocks.pclk = 16_000_000;
        bench.write(DR, 0);
        // RM0008, SPI_CR1.BR: divided by 2 to 256; APB2 is HCLK / 4.
        let cycles = u64::from(8 * 4 * 2_u32.pow(code + 1));
        bench.cycle += cycles - 1;
        assert_eq!(bench.read(SR) & RECEIVED, 0);
        bench.cycle += 1;
        assert_eq!(bench.read(SR) & RECEIVED, RECEIVED);
    }
}

#[test]
fn frame_of_16_bits_sends_high_byte_first() {
    let mut bench = Bench::new(ON | SIXTEEN_BITS);
    bench.write(DR, 0x1234);
    bench.cycle += 16 * 16 - 1;
    assert_eq!(bench.read(SR) & RECEIVED, 0);
    bench.cycle += 1;
    assert_eq!(bench.read(DR), 0xEDCB);
    assert_eq!(bench.part.bytes, [0x12, 0x34]);
}

#[test]
fn second_frame_waits_in_buffer_and_follows_without_gap() {
    let mut bench = Bench::new(ON);
    bench.write(DR, 1);
    bench.write(DR, 2);
    assert_eq!(bench.read(SR), BUSY);
    bench.cycle = 1128;
    assert_eq!(bench.read(DR), 0xFE);
    assert_eq!(bench.read(SR), TRANSMIT_EMPTY | BUSY);
    bench.cycle = 1256;
    assert_eq!(bench.read(DR), 0xFD);
    assert_eq!(bench.part.times, [1128, 1256]);
}

#[test]
fn overrun_keeps_older_frame_and_is_cleared_by_dr_then_sr() {
    let mut bench = Bench::new(ON);
    bench.write(DR, 1);
    bench.write(DR, 2);
    bench.cycle = 2000;
    assert_eq!(bench.read(SR), TRANSMIT_EMPTY | RECEIVED | OVERRUN);
    assert_eq!(bench.read(DR), 0xFE);
    assert_eq!(bench.read(SR), TRANSMIT_EMPTY | OVERRUN);
    assert_eq!(bench.read(SR), TRANSMIT_EMPTY);
}

#[test]
fn interrupts_follow_flags_and_enables() {
    let mut bench = Bench::new(ON);
    assert!(!bench.spi.interrupt());
    bench.write(0x04, TRANSMIT_INTERRUPT);
    assert!(bench.spi.interrupt());
    bench.write(0x04, RECEIVE_INTERRUPT);
    assert!(!bench.spi.interrupt());
    bench.write(DR, 0);
    assert_eq!(bench.spi.next_event(), Some(1128));
    bench.cycle = 1128;
    bench.advance();
    assert!(bench.spi.interrupt());
}

#[test]
fn lost_frame_and_write_while_off_are_violations() {
    let mut bench = Bench::new(ON);
    for data in [1, 2, 3] {
        bench.write(DR, data);
    }
    assert_eq!(
        bench.reasons(),
        ["written while TXE is 0: the previous frame is lost"]
    );
    let mut bench = Bench::new(0);
    bench.write(DR, 1);
    assert_eq!(bench.reasons(), ["written while the SPI is off"]);
}

#[test]
fn unsupported_modes_are_violations() {
    for (cr1, reason) in [
        (ON | PHASE, "the part supports modes 0 and 3 only"),
        (ON | POLARITY, "the part supports modes 0 and 3 only"),
        // 64 MHz / 4
        (0x034C, "faster than the 10 MHz of the part"),
        (ON & !MASTER, "mode not modelled"),
        (ON & !SOFTWARE_SELECT, "mode not modelled"),
        (ON | LEAST_SIGNIFICANT_FIRST, "mode not modelled"),
        (ON & !INTERNAL_SELECT, "master mode fault: SSI is 0"),
    ] {
        assert_eq!(Bench::new(cr1).reasons(), [reason], "SPI_CR1 {cr1:04X}h");
    }
    assert_eq!(Bench::new(ON | PHASE | POLARITY).reasons(), [""; 0]);
}

/// BIDIMODE without BIDIOE, then RXONLY. OVR is cleared by a read of DR and then of SR.
#[test]
fn byte_and_overrun_of_a_mode_that_only_receives_stay_after_it() {
    for (mode, busy) in [(1 << 15, 0), (1 << 10, BUSY)] {
        let mut bench = Bench::new(ON);
        bench.write(CR1, ON | mode);
        assert_eq!(bench.read(SR), RECEIVED | OVERRUN | TRANSMIT_EMPTY | busy);
        bench.write(CR1, ON);
        assert_eq!(bench.read(SR), RECEIVED | OVERRUN | TRANSMIT_EMPTY);
        bench.read(DR);
        bench.read(SR);
        assert_eq!(bench.read(SR), TRANSMIT_EMPTY);
    }
}
