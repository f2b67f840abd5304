//! Identifies the microcontroller: many parts with the name STM32F103 are clones of other manufacturers.
//!
//! An STM32F103 has a Cortex-M3 r1p1, the others have a later one. Their identifier in DBGMCU_IDCODE can be read by a program. That of an
//! STM32F103 reads 0 unless a debugger is connected (errata sheet ES096).

/// CPUID of the STM32F103: Cortex-M3 r1p1.
pub const STM32F103: u32 = 0x411F_C231;

/// CPUID of the STM32F446: Cortex-M4 r0p1.
pub const STM32F446: u32 = 0x410F_C241;

/// The revision in DBGMCU_IDCODE of the GD32F103.
const REV_GD32: u32 = 0x1303;

/// The name of the part if it is not the microcontroller of ST with the CPUID `genuine`; None if it can be this microcontroller.
pub const fn substitute(genuine: u32, cpuid: u32, idcode: u32) -> Option<&'static str> {
    if cpuid == genuine {
        return None;
    }
    Some(match idcode >> 16 {
        REV_GD32 => "a GD32F103",
        _ => "a clone (CS32F103, APM32F103 or another)",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_are_named_by_processor_and_revision() {
        let name = |cpuid, idcode| substitute(STM32F103, cpuid, idcode);
        assert_eq!(name(0x411F_C231, 0), None);
        // With a debugger, the microcontroller of ST has an identifier too.
        assert_eq!(name(0x411F_C231, 0x2003_6410), None);
        assert_eq!(name(0x412F_C231, 0x1303_0410), Some("a GD32F103"));
        let other = Some("a clone (CS32F103, APM32F103 or another)");
        assert_eq!(name(0x412F_C231, 0x2003_6410), other);
        assert_eq!(name(0x412F_C231, 0), other);
        assert_eq!(substitute(STM32F446, 0x410F_C241, 0x1000_6421), None);
    }
}
