//! The bits that a program can write, by the SVD of the maker, and that no test inverts: each with the reason. All others are inverted.

use super::Inverted;
use crate::rig::*;
use std::collections::BTreeSet;
use stm32_sim::board::Spi;
use stm32_sim::chip::Chip;
use stm32_sim::svd::{Device, Register};

/// Registers of all peripherals of a kind, or those whose names start so, and bits of them.
type Row = (&'static str, u32);

/// On both chips.
const BOTH: &[Row] = &[
    // States, and commands: a bit that a write sets and the hardware clears.
    ("CAN.esr", !0),
    ("CAN.msr", !0),
    ("CAN.rf", !0),
    ("CAN.tsr", !0),
    ("FLASH.sr", !0),
    ("GPIO.bsrr", !0),
    ("GPIO.brr", !0),
    ("IWDG.kr", !0),
    ("PWR.cr", 0b11 << 2),
    ("RCC.csr", 0xFF << 24),
    ("SPI.sr", !0),
    ("TIM.egr", !0),
    ("TIM.sr", !0),
    // Data: of one frame, of one byte, of one period.
    ("CAN.tx", !0),
    ("SPI.dr", !0),
    ("TIM.cnt", !0),
    // Each operation writes these registers; in between they are locked.
    ("FLASH.cr", !0),
    ("FLASH.keyr", !0),
    ("FLASH.optkeyr", !0),
    // A lock needs a sequence of writes.
    ("GPIO.lckr", !0),
    // Wake-up from standby mode, which is not used.
    ("PWR.csr", !0),
    // LSE and RTC, which are not used.
    ("RCC.bdcr", !0),
    // Commands, and requests of an interrupt that is masked in the NVIC.
    ("RCC.cir", !0),
    // I2S, which is off in SPI_I2SCFGR.
    ("SPI.i2spr", !0),
    // Requests of an interrupt that is masked in the NVIC, and of DMA, whose channels are off.
    ("TIM.dcr", !0),
    ("TIM.dier", !0),
    ("TIM.dmar", !0),
];

const F103: &[Row] = &[
    // EVENTOUT: it reaches only a pin with an alternate function, and PA0 has none.
    ("AFIO.evcr", !0),
    // The value line only.
    ("AFIO.mapr2", !0),
    // On an STM32F103 a program cannot read it, and writes it ten times a second.
    ("DBGMCU.cr", !0),
    ("FLASH.ar", !0),
];

const F446: &[Row] = &[
    // The option bytes change with OPTSTRT only, and are locked.
    ("FLASH.optcr", !0),
    // Peripherals on AHB2 and AHB3, which are not used.
    ("RCC.ahb2", !0),
    ("RCC.ahb3", !0),
    // RM0390: bit 23 is reserved, SWS is a state.
    ("RCC.cfgr", 1 << 23 | 0b11 << 2),
    // 1: the clock of a bus is not gated. It takes more current.
    ("RCC.ckgatenr", !0),
    // PLLI2S and PLLSAI, and clocks from them, which are not used.
    ("RCC.cr", 1 << 26 | 1 << 28),
    ("RCC.dckcfgr2", !0),
    ("RCC.plli2scfgr", !0),
    ("RCC.pllsaicfgr", !0),
    // A spread of the clock needs SSCGEN, MODPER and INCSTEP.
    ("RCC.sscgr", !0),
    // CCxNP: for inputs.
    ("TIM.ccer", 0x8888),
];

/// The CAN controller of the sensor.
pub fn can() -> &'static [&'static str] {
    match chip() {
        Chip::F103 => &["CAN"],
        Chip::F446 => &["CAN1"],
    }
}

/// The other peripherals with a clock, except those that only some products use: TIM4 and ADC1.
pub fn others() -> Vec<&'static str> {
    let spi = match board().facts().spi {
        Spi::Spi1 => "SPI1",
        Spi::Spi2 => "SPI2",
    };
    let mut all = vec![
        "DBGMCU", "FLASH", "GPIOA", "GPIOB", "GPIOC", "IWDG", "PWR", "RCC", "TIM3", spi,
    ];
    all.extend((chip() == Chip::F103).then_some("AFIO"));
    all
}

/// The bits that exist in the registers of the processor (PM0056, PM0214).
pub fn of_the_processor() -> Inverted {
    let interrupts = match chip() {
        Chip::F103 => 60,
        Chip::F446 => 97,
    };
    let mut all = Inverted::from([
        // SysTick: CSR, RVR.
        (0xE000_E010, 0b111),
        (0xE000_E014, 0x00FF_FFFF),
        // VTOR, AIRCR, SCR, CCR, SHPR1 to SHPR3, SHCSR without the states.
        (0xE000_ED08, 0x3FFF_FF80),
        (0xE000_ED0C, 0x0700),
        (0xE000_ED10, 0x0016),
        (0xE000_ED14, 0x031B),
        (0xE000_ED18, 0xF0F0_F0F0),
        (0xE000_ED1C, 0xF0F0_F0F0),
        (0xE000_ED20, 0xF0F0_F0F0),
        (0xE000_ED24, 0x0007_0000),
    ]);
    for interrupt in 0..interrupts {
        // NVIC_ISER, NVIC_IPR.
        *all.entry(0xE000_E100 + interrupt / 32 * 4).or_default() |= 1 << (interrupt % 32);
        all.insert(0xE000_E400 + interrupt / 4 * 4, 0xF0F0_F0F0);
    }
    if chip() == Chip::F446 {
        // CPACR, MPU_CTRL. The regions of the MPU have no effect while it is off.
        all.extend([(0xE000_ED88, 0xF << 20), (0xE000_ED94, 0b111)]);
    }
    all
}

/// Checks that all bits of these peripherals are inverted that the SVD has, except exactly those of the list.
pub fn check(inverted: &Inverted, peripherals: &[&str]) {
    let (package, device, rows) = match chip() {
        Chip::F103 => ("stm32f1", "stm32f103", F103),
        Chip::F446 => ("stm32f4", "stm32f446", F446),
    };
    let device = Device::open(package, device);
    let registers: Vec<Register> = peripherals
        .iter()
        .flat_map(|name| device.registers(name))
        .collect();
    let mut differences = BTreeSet::new();
    for register in &registers {
        let writable = register.writable.unwrap_or(0);
        let left_out = writable & !inverted.get(&register.address).unwrap_or(&0);
        let (peripheral, name) = register.name.split_once('.').expect("PERIPHERAL.REGISTER");
        let kind = match peripheral {
            "GPIOA" | "GPIOB" | "GPIOC" => "GPIO",
            _ => peripheral.trim_end_matches(|last: char| last.is_ascii_digit()),
        };
        let name = format!("{kind}.{name}");
        let row = |rows: &[Row]| {
            let found = rows.iter().find(|(start, _)| name.starts_with(start));
            found.map_or(0, |(_, bits)| writable & bits)
        };
        let reads = name == "DBGMCU.cr" && silicon().debug_reads;
        let expected = if reads { 0 } else { row(BOTH) | row(rows) };
        if left_out != expected {
            let at = &register.name;
            differences.insert(format!(
                "{at}: {left_out:#x}, but the list has {expected:#x}"
            ));
        }
    }
    assert!(differences.is_empty(), "not inverted: {differences:#?}");
}
