//! Compares each modelled register with the public SVD: value after a reset, access, reserved bits. There is a table for each chip.

use bench::Flash;
use plumbline::measure::Reading;
use stm32_sim::board::Board;
use stm32_sim::io::{Io, Width};
use stm32_sim::peripherals::Peripherals;
use stm32_sim::svd::{Device, Register};

/// A chip of the simulator.
struct Chip {
    /// A board with it.
    board: Board,
    /// The peripheral access crate and the module in it.
    source: (&'static str, &'static str),
    /// The modelled peripherals, by their names in the crate.
    peripherals: &'static [&'static str],
    /// Writes that enable all clocks.
    clocks: &'static [(u32, u32)],
    /// The registers that are not modelled: an access stops the run.
    not_modelled: &'static [&'static str],
    /// Differences in the value after a reset: register, the bits, the reason.
    resets: &'static [(&'static str, u32, &'static str)],
    /// Registers whose reserved bits are not compared, with the reason.
    reserved: &'static [(&'static str, &'static str)],
    /// Addresses without a register that can be read: start and end.
    also_answers: &'static [(u32, u32)],
    /// Registers that can only be written, and refuse to be read.
    write_only: &'static [&'static str],
}

const STM32F103: Chip = Chip {
    board: Board::BluePill,
    source: ("stm32f1", "stm32f103"),
    peripherals: &[
        "ADC1", "AFIO", "CAN", "DBGMCU", "FLASH", "GPIOA", "GPIOB", "GPIOC", "GPIOD", "GPIOE",
        "IWDG", "PWR", "RCC", "SPI1", "TIM3", "TIM4",
    ],
    clocks: &[(0x4002_1018, 0x127D), (0x4002_101C, 0x1200_0006)],
    not_modelled: &[
        "ADC1.htr",
        "ADC1.jdr1",
        "ADC1.jdr[0]",
        "ADC1.jdr2",
        "ADC1.jdr[1]",
        "ADC1.jdr3",
        "ADC1.jdr[2]",
        "ADC1.jdr4",
        "ADC1.jdr[3]",
        "ADC1.jofr1",
        "ADC1.jofr[0]",
        "ADC1.jofr2",
        "ADC1.jofr[1]",
        "ADC1.jofr3",
        "ADC1.jofr[2]",
        "ADC1.jofr4",
        "ADC1.jofr[3]",
        "ADC1.jsqr",
        "ADC1.ltr",
        "AFIO.evcr",
        "AFIO.mapr2",
        "RCC.bdcr",
        "SPI1.i2spr",
        "SPI1.rxcrcr",
        "SPI1.txcrcr",
        "TIM3.cnt",
        "TIM3.dcr",
        "TIM3.dier",
        "TIM3.dmar",
        "TIM3.sr",
        "TIM4.ccmr1_input",
        "TIM4.ccmr1_output",
        "TIM4.ccr1",
        "TIM4.ccr2",
        "TIM4.ccr[0]",
        "TIM4.ccr[1]",
        "TIM4.dcr",
        "TIM4.dmar",
    ],
    resets: &[
        (
            "AFIO.mapr",
            0x0400_0000,
            "RM0008, AFIO_MAPR: SWJ_CFG reads as undefined",
        ),
        ("CAN.mcr", 0x0001_0002, "RM0008, CAN_MCR: 00010002h"),
        ("CAN.msr", 0x0000_0C02, "RM0008, CAN_MSR: 00000C02h"),
        ("CAN.tsr", 0x1C00_0000, "RM0008, CAN_TSR: 1C000000h"),
        ("CAN.btr", 0x0123_0000, "RM0008, CAN_BTR: 01230000h"),
        ("CAN.fmr", 0x2A1C_0E01, "RM0008, CAN_FMR: 2A1C0E01h"),
        ("GPIOB.idr", 1 << 8, "RXD of a recessive bus is high"),
    ],
    reserved: &[
        ("CAN.tx[0].tdtr", "the model stores the complete word"),
        ("CAN.tx[1].tdtr", "as above"),
        ("CAN.tx[2].tdtr", "as above"),
    ],
    write_only: &["TIM3.egr", "TIM4.egr"],
    // Filter banks 14 to 27 of the connectivity line: a write is a violation.
    also_answers: &[(0x4000_66B0, 0x4000_6720)],
};

const STM32F446: Chip = Chip {
    board: Board::NucleoF446,
    source: ("stm32f4", "stm32f446"),
    peripherals: &[
        "ADC1",
        "ADC_COMMON",
        "CAN1",
        "DBGMCU",
        "FLASH",
        "GPIOA",
        "GPIOB",
        "GPIOC",
        "GPIOD",
        "GPIOE",
        "IWDG",
        "PWR",
        "RCC",
        "SPI2",
        "TIM3",
        "TIM4",
    ],
    clocks: &[
        (0x4002_3830, 0x0010_001F),
        (0x4002_3840, 0x1200_4006),
        (0x4002_3844, 0x0000_0100),
    ],
    not_modelled: &[
        "ADC1.htr",
        "ADC1.jdr1",
        "ADC1.jdr[0]",
        "ADC1.jdr2",
        "ADC1.jdr[1]",
        "ADC1.jdr3",
        "ADC1.jdr[2]",
        "ADC1.jdr4",
        "ADC1.jdr[3]",
        "ADC1.jofr1",
        "ADC1.jofr[0]",
        "ADC1.jofr2",
        "ADC1.jofr[1]",
        "ADC1.jofr3",
        "ADC1.jofr[2]",
        "ADC1.jofr4",
        "ADC1.jofr[3]",
        "ADC1.jsqr",
        "ADC1.ltr",
        "ADC_COMMON.cdr",
        "RCC.ahb2enr",
        "RCC.ahb2lpenr",
        "RCC.ahb2rstr",
        "RCC.ahb3enr",
        "RCC.ahb3lpenr",
        "RCC.ahb3rstr",
        "RCC.bdcr",
        "RCC.ckgatenr",
        "RCC.dckcfgr2",
        "RCC.plli2scfgr",
        "RCC.pllsaicfgr",
        "RCC.sscgr",
        "SPI2.i2spr",
        "SPI2.rxcrcr",
        "SPI2.txcrcr",
        "TIM3.cnt",
        "TIM3.dcr",
        "TIM3.dier",
        "TIM3.dmar",
        "TIM3.sr",
        "TIM4.ccmr1_input",
        "TIM4.ccmr1_output",
        "TIM4.ccr1",
        "TIM4.ccr2",
        "TIM4.ccr[0]",
        "TIM4.ccr[1]",
        "TIM4.dcr",
        "TIM4.dmar",
    ],
    resets: &[
        ("CAN1.btr", 0x0123_0000, "RM0390, CAN_BTR: 01230000h"),
        ("DBGMCU.idcode", 0x0000_0030, "RM0390: DEV_ID is 421h"),
        ("FLASH.optcr", 0b1100, "README: brown-out level 3"),
        ("GPIOA.idr", 1 << 11, "RXD of a recessive bus is high"),
        ("GPIOA.ospeedr", 0x0C00_0000, "RM0390: 0C000000h for port A"),
    ],
    reserved: &[
        ("CAN1.tx[0].tdtr", "the model stores the complete word"),
        ("CAN1.tx[1].tdtr", "as above"),
        ("CAN1.tx[2].tdtr", "as above"),
        ("RCC.apb1rstr", "RM0390: bit 27 is CECRST"),
    ],
    write_only: &["TIM3.egr", "TIM4.egr"],
    also_answers: &[],
};

impl Chip {
    /// The peripherals after a reset, with their clocks.
    fn machine(&self, with_clocks: bool) -> Peripherals {
        let motion = Box::new(Reading::default());
        let flash = Flash::blank(self.board.chip().facts().geometry);
        let mut machine = Peripherals::new(self.board, [1, 2, 3], flash, motion);
        for (address, value) in self.clocks.iter().filter(|_| with_clocks) {
            let written = machine.write(1, *address, Width::Word, *value);
            written.expect("a clock enable register");
        }
        machine
    }

    /// The addresses of the words of the peripherals.
    fn pages(&self) -> impl Iterator<Item = u32> {
        let device = Device::open(self.source.0, self.source.1);
        let bases: Vec<u32> = self
            .peripherals
            .iter()
            .map(|name| device.base(name))
            .collect();
        bases
            .into_iter()
            .flat_map(|base| (base..base + 0x400).step_by(4))
    }

    fn registers(&self) -> Vec<Register> {
        let device = Device::open(self.source.0, self.source.1);
        let all = self.peripherals.iter();
        all.flat_map(|name| device.registers(name)).collect()
    }
}

fn get(machine: &mut Peripherals, register: &Register) -> Option<u32> {
    let read = machine.read(2, register.address, Width::Word);
    let read = read.or_else(|_| machine.read(2, register.address, Width::HalfWord));
    read.ok()
}

fn put(machine: &mut Peripherals, register: &Register, value: u32) -> bool {
    machine
        .write(3, register.address, Width::Word, value)
        .is_ok()
}

/// The differences, one line each.
fn differences(chip: &Chip) -> Vec<String> {
    let mut found = Vec::new();
    let mut not_modelled = Vec::new();
    let registers = chip.registers();
    for register in &registers {
        let name = register.name.as_str();
        // Enabling the clocks changes registers of RCC.
        let machine = || chip.machine(!name.starts_with("RCC"));
        let before = get(&mut machine(), register);
        let mut tell =
            |text: String| found.push(format!("{name} at {:#010x}: {text}", register.address));
        let Some(before) = before else {
            if chip.write_only.contains(&name) && register.readable.is_none() {
                continue;
            }
            if chip.not_modelled.contains(&name) {
                not_modelled.push(name.to_owned());
            } else {
                tell("not modelled".to_owned());
            }
            continue;
        };
        let other: u32 = chip
            .resets
            .iter()
            .filter(|it| it.0 == name)
            .map(|it| it.1)
            .sum();
        let reset = if register.readable.is_some() {
            register.reset
        } else {
            0
        };
        if (before ^ reset) & !other != 0 {
            tell(format!("{before:#x} after a reset instead of {reset:#x}"));
        }
        let Some(writable) = register.writable else {
            let mut machine = machine();
            put(&mut machine, register, !before);
            if get(&mut machine, register) != Some(before) {
                tell("can be written".to_owned());
            }
            continue;
        };
        if chip.reserved.iter().any(|it| it.0 == name) {
            continue;
        }
        for bit in (0..32).filter(|bit| writable >> bit & 1 == 0) {
            let mut machine = machine();
            put(&mut machine, register, before | 1 << bit);
            let after = get(&mut machine, register).unwrap_or_default();
            if (after ^ before) >> bit & 1 != 0 {
                tell(format!(
                    "bit {bit} is reserved or read-only, but it is stored"
                ));
            }
        }
    }
    // A read must succeed only at the address of a register.
    for address in chip.pages() {
        let mut machine = chip.machine(true);
        let read = machine.read(2, address, Width::Word);
        let is_known = chip
            .also_answers
            .iter()
            .any(|it| (it.0..it.1).contains(&address));
        if read.is_ok() && !is_known && !registers.iter().any(|it| it.address == address) {
            found.push(format!("{address:#010x}: no register, but it can be read"));
        }
    }
    for name in chip.not_modelled {
        if !not_modelled.iter().any(|it| it == name) {
            found.push(format!("{name} is modelled: remove it from the list"));
        }
    }
    found
}

#[test]
fn registers_of_stm32f103_match_svd() {
    let differences = differences(&STM32F103);
    assert!(differences.is_empty(), "\n{}", differences.join("\n"));
}

#[test]
fn registers_of_stm32f446_match_svd() {
    let differences = differences(&STM32F446);
    assert!(differences.is_empty(), "\n{}", differences.join("\n"));
}
