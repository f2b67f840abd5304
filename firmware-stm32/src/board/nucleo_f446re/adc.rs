//! The converter that measures the supply.

use crate::board::{delay, pac, supply_millivolts};

/// Starts the converter at the divider of the supply: 16 MHz (36 MHz at most), with a sampling time of 30 us for PC0.
pub fn start_adc() {
    // SAFETY: the main loop is the only code that uses these registers.
    let (rcc, adc, common) = unsafe {
        (
            pac::RCC::steal(),
            pac::ADC1::steal(),
            pac::ADC_COMMON::steal(),
        )
    };
    rcc.apb2enr().modify(|_, w| w.adc1en().set_bit());
    // The clock runs after this write.
    cortex_m::asm::dsb();
    // Off: a disturbance can have changed what the next writes do not.
    adc.cr2().reset();
    adc.cr1().reset();
    adc.smpr2().reset();
    adc.sqr1().reset();
    common.ccr().write(|w| w.adcpre().div4());
    adc.smpr1().write(|w| w.smp10().cycles480());
    // SAFETY: channel 10 is PC0.
    adc.sqr3().write(|w| unsafe { w.sq1().bits(10) });
    adc.cr2().write(|w| w.adon().set_bit());
    // The converter is stable after 3 us (DS10693, tSTAB).
    delay(4);
}

/// True if the converter has its configuration, which a disturbance can change.
fn is_set(adc: &pac::ADC1) -> bool {
    // SAFETY: reads a register.
    let common = unsafe { pac::ADC_COMMON::steal() };
    adc.cr1().read().bits() == 0
        && adc.cr2().read().bits() == 1
        && adc.smpr1().read().bits() == 0b111
        && adc.smpr2().read().bits() == 0
        && adc.sqr1().read().bits() == 0
        && adc.sqr3().read().bits() == 10
        && common.ccr().read().bits() == 1 << 16
}

/// The result of the conversion that the last call has started, in mV at the supply; starts the next one, which takes 31 us.
pub fn supply() -> Option<u16> {
    // SAFETY: the main loop is the only code that uses this register.
    let adc = unsafe { pac::ADC1::steal() };
    if !is_set(&adc) {
        start_adc();
    }
    let ended = adc.sr().read().eoc().bit_is_set();
    let result = ended.then(|| supply_millivolts(adc.dr().read().data().bits()));
    adc.cr2().write(|w| w.adon().set_bit().swstart().set_bit());
    result
}
