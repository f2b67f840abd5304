use super::*;
use embedded_storage::nor_flash::NorFlash;

/// Erases a page and programs three half-words, until the power is cut.
fn work(flash: &mut Flash) -> Result<(), FlashError> {
    flash.erase(0, PAGE_SIZE as u32)?;
    (0..3).try_for_each(|at| flash.write(2 * at, &[0x12, 0x34]))
}

#[test]
fn operation_fuse_counts_erases_and_half_words() {
    for others in 0..5 {
        let mut flash = Flash::default();
        flash.cut_in_operation_after(others, 1);
        let result = work(&mut flash);
        assert_eq!(result.is_err(), others < 4);
        assert_eq!(flash.is_cut(), others < 4);
        assert_eq!(flash.erased(), others.min(1));
        assert_eq!(flash.programmed(), 2 * others.saturating_sub(1).min(3));
    }
}

#[test]
fn sector_is_programmed_again_towards_0() {
    let mut flash = Flash::blank(Geometry::STM32F446);
    assert_eq!(
        flash.program_unit(0x4000, &[0x12, 0x34, 0xF6, 0x78]),
        Ok(())
    );
    assert_eq!(flash.program_unit(0x4002, &[0x0F]), Ok(()));
    assert_eq!(
        flash.bytes()[0x4000..0x4005],
        [0x12, 0x34, 0x06, 0x78, 0xFF]
    );
    assert_eq!(flash.erase_page_at(0x4000), Ok(()));
    assert_eq!(flash.bytes(), [0xFF; 0x8000]);
    assert_eq!((flash.programmed(), flash.erased()), (5, 1));
}

#[test]
fn power_cut_leaves_half_word_between_old_and_new_value() {
    for seed in 0..100 {
        let mut flash = Flash::default();
        flash.cut_in_operation_after(0, seed);
        assert_eq!(flash.write(0, &[0x0F, 0xF0]), Err(FlashError::PowerCut));
        assert_eq!(
            [flash.bytes()[0] & 0x0F, flash.bytes()[1] & 0xF0],
            [0x0F, 0xF0]
        );
    }
}
