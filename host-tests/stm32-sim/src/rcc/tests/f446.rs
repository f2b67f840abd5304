//! The RCC of the STM32F446 on a Nucleo.

use super::*;

const PLLCFGR: u32 = 0x04;
const CFGR: u32 = 0x08;
const CSR: u32 = 0x74;

/// M 4, N 128, P 2, from HSE.
const PLL: u32 = 0x2440_2004;

fn bench() -> Bench {
    Bench {
        rcc: Rcc::new(Chip::F446, true),
        ..Bench::new()
    }
}

#[test]
fn reset_values_match_manual() {
    // RM0390, section 6.3; HSICAL is left 0.
    let mut bench = bench();
    for (offset, value) in [
        (CR, 0x83),
        (PLLCFGR, 0x2400_3010),
        (CFGR, 0),
        (0x0C, 0),
        (0x10, 0),
        (0x20, 0),
        (0x24, 0),
        (0x30, 0x0010_0000),
        (0x40, 0),
        (0x44, 0),
        (CSR, 0x0E00_0000),
        (0x8C, 0),
    ] {
        assert_eq!(bench.read(offset), value, "offset {offset:02X}h");
    }
    assert_eq!(bench.rcc.hclk(), 16_000_000);
}

#[test]
fn clock_of_the_st_link_and_pll_give_128_mhz_with_pclk1_at_32() {
    let mut bench = bench();
    bench.write(PLLCFGR, PLL);
    bench.write(CR, 0x0005_0083);
    // 2 us at 16 MHz
    assert_eq!(bench.wait(HSE_READY), 32);
    bench.write(CR, 0x0105_0083);
    // 200 us at 16 MHz
    assert_eq!(bench.wait(PLL_READY), 3_200);
    bench.write(CFGR, 0x0000_9402);
    assert_eq!(bench.read(CFGR), 0x0000_940A, "SWS says PLL");
    let rcc = &bench.rcc;
    assert_eq!(
        (rcc.hclk(), rcc.pclk1(), rcc.pclk2()),
        (128_000_000, 32_000_000, 64_000_000)
    );
    assert_eq!(rcc.timer_clock(), 64_000_000);
    assert_eq!(bench.reasons(), [""; 0]);
}

/// No crystal is mounted on the Nucleo (UM1724).
#[test]
fn hse_needs_bypass() {
    let mut bench = bench();
    bench.write(CR, 0x0001_0083);
    bench.cycle += 160_000_000;
    assert_eq!(bench.read(CR) & HSE_READY, 0);
}

#[test]
fn limits_of_clocks_and_pll_match_manual() {
    for (pll, cfgr, reason) in [
        // 180 MHz: N 180.
        (
            0x2440_2D04,
            0x0000_9402,
            Some("SYSCLK above 168 MHz, without over-drive"),
        ),
        (PLL, 0x0000_8002, Some("PCLK1 above 45 MHz")),
        (PLL, 0x0000_1402, Some("PCLK2 above 90 MHz")),
        // M 3: 2.67 MHz. N 40: 80 MHz.
        (
            0x2440_2003,
            0,
            Some("the PLL needs an input of 1 to 2 MHz and an oscillator of 100 to 432 MHz"),
        ),
        (
            0x2440_0A04,
            0,
            Some("the PLL needs an input of 1 to 2 MHz and an oscillator of 100 to 432 MHz"),
        ),
        (PLL, 0x0000_9402, None),
    ] {
        let mut bench = bench();
        bench.write(PLLCFGR, pll);
        bench.write(CR, 0x0005_0083);
        bench.wait(HSE_READY);
        bench.write(CR, 0x0105_0083);
        bench.wait(PLL_READY);
        bench.write(CFGR, cfgr);
        assert_eq!(
            bench.reasons().first().copied(),
            reason,
            "{pll:08X}h {cfgr:08X}h"
        );
    }
    let mut bench = bench();
    bench.write(CR, 0x0100_0083);
    bench.write(PLLCFGR, PLL);
    assert_eq!(bench.reasons(), ["the PLL is set up while it runs"]);
    assert_eq!(bench.read(PLLCFGR), 0x2400_3010);
}

#[test]
fn gates_of_ahb1_and_apb1_enable_and_reset_peripherals() {
    let mut bench = bench();
    let (gpiob, spi2) = (Gate::Ahb1(1), Gate::Apb1(14));
    bench.write(0x30, 0x0010_0002);
    bench.write(0x40, 1 << 14);
    assert!(bench.rcc.is_clocked(gpiob) && bench.rcc.is_clocked(spi2));
    bench.write(0x10, 1 << 1);
    assert!(bench.rcc.is_in_reset(gpiob) && !bench.rcc.is_in_reset(spi2));
}

#[test]
fn flags_of_power_on_are_cleared_by_software() {
    let mut bench = bench();
    assert_eq!(bench.read(CSR), 0x0E00_0000);
    bench.write(CSR, REMOVE_FLAGS);
    assert_eq!(bench.read(CSR), 0);
    bench.rcc.reset(1000, ResetCause::Software);
    assert_eq!(bench.read(CSR), 0x1400_0000);
}
