use super::*;

const CR: u32 = 0x00;
const CFGR: u32 = 0x04;
const CIR: u32 = 0x08;
const CSR: u32 = 0x24;

struct Bench {
    rcc: Rcc,
    violations: Violations,
    cycle: u64,
}

impl Bench {
    fn new() -> Self {
        Self {
            rcc: Rcc::new(Chip::F103, false),
            violations: Violations::default(),
            cycle: 100,
        }
    }

    fn write(&mut self, offset: u32, value: u32) {
        self.rcc
            .write(self.cycle, offset, value, &mut self.violations)
            .unwrap();
    }

    fn read(&mut self, offset: u32) -> u32 {
        self.rcc.read(self.cycle, offset).unwrap()
    }

    /// Polls RCC_CR as firmware does; returns the elapsed cycles.
    fn wait(&mut self, flag: u32) -> u64 {
        let start = self.cycle;
        while self.read(CR) & flag == 0 {
            self.cycle += 1;
        }
        self.cycle - start
    }

    /// Crystal times 8, APB1 / 2: the clocks of the board.
    fn run_at_64_mhz(&mut self) {
        self.write(CR, 0x0001_0083);
        self.wait(HSE_READY);
        // PLLMUL 0110: times 8. PLLSRC: crystal.
        self.write(CFGR, 0x0019_0000);
        self.write(CR, 0x0101_0083);
        self.wait(PLL_READY);
        // PPRE1 100: / 2. SW: PLL.
        self.write(CFGR, 0x0019_0402);
    }

    fn reasons(&self) -> Vec<&'static str> {
        self.violations.list().iter().map(|it| it.reason).collect()
    }
}

#[test]
fn reset_values() {
    // RM0008, sections 7.3.1 to 7.3.10; HSICAL, the calibration, is left 0.
    let mut bench = Bench::new();
    for (offset, value) in [
        (CR, 0x83),
        (CFGR, 0),
        (0x08, 0),
        (0x0C, 0),
        (0x10, 0),
        (0x14, 0x14),
        (0x18, 0),
        (0x1C, 0),
        (CSR, 0x0C00_0000),
    ] {
        assert_eq!(bench.read(offset), value, "offset {offset:02X}h");
    }
    assert_eq!(bench.rcc.hclk(), 8_000_000);
}

#[test]
fn crystal_and_pll_need_startup_time_and_give_64_mhz_with_pclk1_at_32() {
    let mut bench = Bench::new();
    bench.write(CR, 0x0001_0083);
    // 2 ms at 8 MHz
    assert_eq!(bench.wait(HSE_READY), 16_000);
    bench.write(CFGR, 0x0019_0000);
    bench.write(CR, 0x0101_0083);
    // 200 us at 8 MHz
    assert_eq!(bench.wait(PLL_READY), 1_600);
    bench.write(CFGR, 0x0019_0402);
    assert_eq!(bench.read(CFGR), 0x0019_040A, "SWS says PLL");
    assert_eq!(
        (bench.rcc.hclk(), bench.rcc.pclk1(), bench.rcc.pclk2()),
        (64_000_000, 32_000_000, 64_000_000)
    );
    assert_eq!(bench.rcc.timebase().frequency(), 64_000_000);
    assert_eq!(bench.reasons(), [""; 0]);
}

#[test]
fn clock_switch_waits_until_source_is_ready() {
    let mut bench = Bench::new();
    bench.write(CR, 0x0001_0083);
    bench.write(CFGR, 1);
    assert_eq!(bench.read(CFGR) & SOURCE_STATUS, 0, "still HSI");
    let event = bench.rcc.next_event().unwrap();
    assert_eq!(event, 100 + 16_000);
    bench.cycle = event;
    assert_eq!(bench.read(CFGR) & SOURCE_STATUS, 1 << 2);
    assert_eq!(bench.rcc.next_event(), None);
}

#[test]
fn broken_crystal_never_becomes_ready() {
    let mut bench = Bench::new();
    bench.rcc.break_crystal(true);
    bench.write(CR, 0x0001_0083);
    bench.write(CFGR, 1);
    bench.cycle = 8_000_000 * 3600;
    assert_eq!(bench.read(CR), 0x0001_0083);
    assert_eq!(bench.rcc.next_event(), None);
}

#[test]
fn prescalers_match_manual() {
    // RM0008, RCC_CFGR: HPRE, PPRE1, PPRE2
    let mut bench = Bench::new();
    for (hpre, divisor) in [
        (0, 1),
        (7, 1),
        (8, 2),
        (9, 4),
        (10, 8),
        (11, 16),
        (12, 64),
        (13, 128),
        (14, 256),
        (15, 512),
    ] {
        bench.write(CFGR, hpre << 4);
        assert_eq!(bench.rcc.hclk(), 8_000_000 / divisor, "HPRE {hpre}");
    }
    for (ppre, divisor) in [(0, 1), (3, 1), (4, 2), (5, 4), (6, 8), (7, 16)] {
        bench.write(CFGR, ppre << 8 | (7 - ppre) << 11);
        assert_eq!(bench.rcc.pclk1(), 8_000_000 / divisor, "PPRE1 {ppre}");
    }
    bench.write(CFGR, 5 << 11);
    assert_eq!(bench.rcc.pclk2(), 2_000_000);
}

#[test]
fn pll_factors_and_inputs_match_manual() {
    for (cfgr, frequency) in [
        (0x0000_0000, 8_000_000),  // HSI / 2, times 2
        (0x0038_0000, 64_000_000), // HSI / 2, times 16
        (0x003C_0000, 64_000_000), // 1111 is also times 16
        (0x0001_0000, 16_000_000), // crystal, times 2
        (0x001D_0000, 72_000_000), // crystal, times 9
        (0x001F_0000, 36_000_000), // crystal / 2, times 9
    ] {
        let rcc = Rcc {
            cfgr,
            ..Rcc::new(Chip::F103, false)
        };
        assert_eq!(rcc.pll_frequency(), frequency, "RCC_CFGR {cfgr:08X}h");
    }
}

#[test]
fn pclk1_above_36_mhz_is_violation() {
    let mut bench = Bench::new();
    bench.run_at_64_mhz();
    bench.write(CFGR, 0x0019_0002);
    assert_eq!(bench.reasons(), ["PCLK1 above 36 MHz"]);
}

#[test]
fn switching_off_clock_in_use_is_violation() {
    let mut bench = Bench::new();
    bench.run_at_64_mhz();
    bench.write(CR, 0x0000_0081);
    assert_eq!(bench.read(CR) & 0x0303_0000, 0x0303_0000);
    assert_eq!(bench.reasons(), ["the clock in use is switched off"]);
    bench.write(CFGR, 0x001D_0402);
    assert_eq!(bench.rcc.hclk(), 64_000_000);
    assert_eq!(bench.reasons()[1], "the PLL is set up while it runs");
}

#[test]
fn enable_and_reset_bits_select_peripherals() {
    let mut bench = Bench::new();
    // CANEN is bit 25 of APB1ENR, SPI1EN bit 12 of APB2ENR.
    let (can, spi1) = (Gate::Apb1(25), Gate::Apb2(12));
    assert!(!bench.rcc.is_clocked(can) && !bench.rcc.is_clocked(spi1));
    bench.write(0x1C, 1 << 25);
    assert!(bench.rcc.is_clocked(can) && !bench.rcc.is_clocked(spi1));
    bench.write(0x18, 1 << 12);
    assert!(bench.rcc.is_clocked(spi1));
    bench.write(0x0C, 1 << 12);
    assert!(bench.rcc.is_in_reset(spi1) && !bench.rcc.is_in_reset(can));
    bench.write(0x0C, 0);
    assert!(!bench.rcc.is_in_reset(spi1));
}

#[test]
fn reset_flags_accumulate_until_cleared() {
    let mut bench = Bench::new();
    bench.write(CSR, REMOVE_FLAGS);
    assert_eq!(bench.read(CSR), 0);
    bench.rcc.reset(1000, ResetCause::Software);
    assert_eq!(bench.read(CSR), 0x1400_0000);
    bench.rcc.reset(2000, ResetCause::Watchdog);
    assert_eq!(bench.read(CSR), 0x3400_0000);
    bench.rcc.reset(3000, ResetCause::PowerOn);
    assert_eq!(bench.read(CSR), 0x0C00_0000);
}

#[test]
fn reset_selects_hsi_and_time_continues() {
    let mut bench = Bench::new();
    bench.run_at_64_mhz();
    let cycle = bench.cycle + 64_000;
    let time = bench.rcc.timebase().time_at(cycle);
    bench.rcc.reset(cycle, ResetCause::Watchdog);
    assert_eq!(bench.rcc.timebase().time_at(cycle), time);
    assert_eq!(bench.rcc.timebase().frequency(), 8_000_000);
}

#[test]
fn lsi_becomes_ready_after_startup() {
    let mut bench = Bench::new();
    bench.write(CSR, LSI_ON);
    assert_eq!(bench.read(CSR) & 0b11, 0b01);
    bench.cycle += 85 * 8;
    assert_eq!(bench.read(CSR) & 0b11, 0b11);
}

#[test]
fn security_system_selects_hsi_and_raises_nmi_until_cleared() {
    let mut bench = Bench::new();
    bench.run_at_64_mhz();
    bench.write(CR, 0x0109_0083);
    let now = bench.rcc.timebase().time_at(bench.cycle);
    bench.rcc.stop_crystal(now + MICROSECOND);
    assert_eq!(bench.rcc.next_event(), Some(bench.cycle + 64));
    bench.cycle += 63;
    assert_eq!(bench.read(CIR), 0);
    bench.cycle += 1;
    // CSSF; HSE and PLL off; SW and SWS say HSI.
    assert_eq!(bench.read(CIR), 1 << 7);
    assert!(bench.rcc.nmi());
    assert_eq!(bench.read(CR), 0x0008_0083);
    assert_eq!(bench.read(CFGR), 0x0019_0400);
    assert_eq!(bench.rcc.hclk(), 8_000_000);
    assert_eq!(bench.rcc.timebase().frequency(), 8_000_000);
    bench.write(CIR, 1 << 23);
    assert_eq!(bench.read(CIR), 0);
    assert!(!bench.rcc.nmi());
    assert!(bench.reasons().is_empty());
}

#[test]
fn clock_stops_with_crystal_without_security_system_until_reset() {
    let mut bench = Bench::new();
    bench.run_at_64_mhz();
    let now = bench.rcc.timebase().time_at(bench.cycle);
    bench.rcc.stop_crystal(now);
    bench.rcc.settle(bench.cycle);
    assert!(bench.rcc.is_stopped() && !bench.rcc.nmi());
    bench.rcc.reset(bench.cycle, ResetCause::Watchdog);
    assert!(!bench.rcc.is_stopped());
    assert_eq!(bench.rcc.hclk(), 8_000_000);
}

#[test]
fn crystal_that_is_not_in_use_stops_without_effect_on_clock() {
    let mut bench = Bench::new();
    bench.write(CR, 0x0001_0083);
    bench.wait(HSE_READY);
    let now = bench.rcc.timebase().time_at(bench.cycle);
    bench.rcc.stop_crystal(now);
    assert_eq!(bench.read(CR) & HSE_READY, 0);
    assert!(!bench.rcc.is_stopped() && !bench.rcc.nmi());
}

#[test]
fn lsi_is_ready_while_watchdog_runs() {
    let mut bench = Bench::new();
    let now = bench.rcc.timebase().time_at(bench.cycle);
    bench.rcc.watchdog_runs(now);
    assert_eq!(bench.read(CSR) & 0b11, 0);
    bench.cycle += 85 * 8;
    assert_eq!(bench.read(CSR) & 0b11, 0b10);
    bench.rcc.reset(bench.cycle, ResetCause::Software);
    assert_eq!(bench.read(CSR) & 0b11, 0);
}

#[test]
fn reserved_bits_are_violations_and_are_not_stored() {
    for (offset, reserved) in [
        (CFGR, 0xF880_0000),
        (0x0C, 0xFFC7_0002),
        (0x10, 0xC501_3600),
        (0x14, 0xFFFF_FAA8),
        (0x18, 0xFFC7_0002),
        (0x1C, 0xC501_3600_u32),
    ] {
        for bit in (0..32).filter(|bit| reserved >> bit & 1 != 0) {
            let mut bench = Bench::new();
            let before = bench.read(offset);
            bench.write(offset, before | 1 << bit);
            assert_eq!(
                bench.reasons(),
                ["reserved bits are written"],
                "{offset:X}h"
            );
            assert_eq!(bench.read(offset), before);
        }
    }
}
mod f446;

#[test]
fn disturbance_changes_the_pll_in_use_and_stops_the_clock_without_it() {
    let mut bench = Bench::new();
    bench.run_at_64_mhz();
    // PLLMUL: times 9.
    assert_eq!(bench.rcc.disturb(bench.cycle, CFGR, 1 << 18), Some(true));
    assert_eq!(bench.rcc.hclk(), 72_000_000);
    assert_eq!(bench.rcc.disturb(bench.cycle, CFGR, 1 << 31), Some(false));
    assert_eq!(bench.rcc.disturb(bench.cycle, CR, 1 << 24), Some(true));
    assert!(bench.rcc.is_stopped());
}

#[test]
fn disturbed_hse_is_a_failure_of_the_clock_security_system() {
    // HSEON, HSEBYP.
    for bit in [1 << 16, 1 << 18] {
        let mut bench = Bench::new();
        bench.run_at_64_mhz();
        bench.write(CR, 0x0109_0083);
        assert_eq!(bench.rcc.disturb(bench.cycle, CR, bit), Some(true));
        assert!(bench.rcc.nmi());
        assert_eq!(bench.rcc.hclk(), 8_000_000);
    }
}
