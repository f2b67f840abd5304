//! The converter that measures the supply.

use crate::board::{SUPPLY_CHANNEL, delay, pac, supply_millivolts};

/// Sampling times of 239.5 cycles.
const LONGEST: u32 = 0x3FFF_FFFF;

/// Starts the converter at the divider of the supply: 10.7 MHz (14 MHz at most), calibrated, with a sampling time of 22 us.
pub fn start_adc() {
    // SAFETY: the main loop is the only code that uses these registers.
    let (rcc, adc) = unsafe { (pac::RCC::steal(), pac::ADC1::steal()) };
    rcc.apb2enr().modify(|_, w| w.adc1en().set_bit());
    // The clock runs after this write.
    cortex_m::asm::dsb();
    // Off: otherwise a disturbed converter would start again with a conversion.
    adc.cr2().reset();
    adc.cr1().reset();
    adc.sqr1().reset();
    // SAFETY: all values of these registers are valid: the longest time for all channels, and one channel.
    unsafe {
        adc.smpr1().write(|w| w.bits(LONGEST));
        adc.smpr2().write(|w| w.bits(LONGEST));
        adc.sqr3().write(|w| w.bits(SUPPLY_CHANNEL));
    }
    adc.cr2().write(|w| w.adon().set_bit());
    // The converter is stable after 1 us (DS5319, tSTAB).
    delay(2);
    adc.cr2().write(|w| w.adon().set_bit().rstcal().set_bit());
    while adc.cr2().read().rstcal().bit_is_set() {}
    adc.cr2().write(|w| w.adon().set_bit().cal().set_bit());
    while adc.cr2().read().cal().bit_is_set() {}
}

/// True if the converter has its configuration, which a disturbance can change.
fn is_set(adc: &pac::ADC1) -> bool {
    adc.cr1().read().bits() == 0
        && adc.cr2().read().bits() == 1
        && adc.smpr1().read().bits() == LONGEST & 0x00FF_FFFF
        && adc.smpr2().read().bits() == LONGEST
        && adc.sqr1().read().bits() == 0
        && adc.sqr3().read().bits() == SUPPLY_CHANNEL
}

/// The result of the conversion that the last call has started, in mV at the supply; starts the next one, which takes 24 us.
pub fn supply() -> Option<u16> {
    // SAFETY: the main loop is the only code that uses this register.
    let adc = unsafe { pac::ADC1::steal() };
    if !is_set(&adc) {
        start_adc();
    }
    let ended = adc.sr().read().eoc().bit_is_set();
    let result = ended.then(|| supply_millivolts(adc.dr().read().data().bits()));
    // Writing the value that the register has starts a conversion (RM0008, ADC_CR2.ADON).
    adc.cr2().write(|w| w.adon().set_bit());
    result
}
