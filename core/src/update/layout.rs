//! The memory layouts of the boards with a bootloader, and their numbers in a [`Header`](super::Header).

/// Where the program of a board is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Layout {
    /// The name of the board.
    pub name: &'static str,
    /// The number of the board.
    pub board: u16,
    /// The number of the layout.
    pub number: u8,
    /// The address of the program.
    pub start: u32,
    /// The size of the slot in bytes.
    pub size: usize,
    /// The address of the second slot, which takes a download while the program stays complete; None: a download replaces the program.
    pub download: Option<u32>,
    /// The address of the boot record.
    pub record: u32,
    /// The address of the public key, in the write-protected flash of the bootloader. A probe programs it.
    pub key: u32,
}

/// Blue Pill: one slot of 53 KiB behind 8 KiB for the bootloader.
pub const BLUEPILL: Layout = Layout {
    name: "bluepill",
    board: 1,
    number: 1,
    start: 0x0800_2000,
    size: 53 * 1024,
    download: None,
    record: 0x0800_F400,
    key: 0x0800_1FC0,
};

/// Nucleo-F103RB: two slots of 58 KiB behind 8 KiB for the bootloader.
pub const NUCLEO_F103RB: Layout = Layout {
    name: "nucleo-f103rb",
    board: 2,
    number: 2,
    start: 0x0800_2000,
    size: 58 * 1024,
    download: Some(0x0801_0800),
    record: 0x0801_F000,
    key: 0x0800_1FC0,
};

/// Nucleo-F446RE: two slots of 128 KiB, sectors 5 and 6, behind 16 KiB for the bootloader, sector 0. The boot record is in sector 7.
///
/// Sectors 1 and 4 are not used. The 64 KiB of sector 4 are too small for the IMS360, and its erase is only 0.5 s shorter.
pub const NUCLEO_F446RE: Layout = Layout {
    name: "nucleo-f446re",
    board: 3,
    number: 3,
    start: 0x0802_0000,
    size: 128 * 1024,
    download: Some(0x0804_0000),
    record: 0x0806_0000,
    key: 0x0800_3FC0,
};

/// All layouts.
pub const LAYOUTS: [Layout; 3] = [BLUEPILL, NUCLEO_F103RB, NUCLEO_F446RE];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slots_and_boot_record_follow_each_other_without_a_gap() {
        for layout in LAYOUTS {
            let end = layout.start + layout.size as u32;
            let second = layout.download.map(|start| {
                assert_eq!(start, end, "{}", layout.name);
                start + layout.size as u32
            });
            assert_eq!(layout.record, second.unwrap_or(end), "{}", layout.name);
        }
    }
}
