//! The pages of the memories of the microcontrollers.

/// Size of an erase unit of the STM32F103, in bytes.
pub const PAGE_SIZE: usize = 1024;

/// The pages of a memory.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Geometry {
    /// The number of pages.
    pub pages: usize,
    /// The size of a page in bytes.
    pub page_size: usize,
    /// Only an erased half-word can be programmed, except to 0000h.
    pub once_only: bool,
}

impl Geometry {
    /// Two pages of the STM32F103.
    pub const STM32F103: Self = Self {
        pages: 2,
        page_size: PAGE_SIZE,
        once_only: true,
    };

    /// Two sectors of 16 KiB of the STM32F446.
    pub const STM32F446: Self = Self {
        pages: 2,
        page_size: 16 * 1024,
        once_only: false,
    };

    /// The pages of a memory file of this length in bytes: the smallest memory that holds it; None if it is longer than each memory.
    pub fn of_file(length: u64) -> Option<Self> {
        let all = [Self::STM32F103, Self::STM32F446];
        all.into_iter()
            .find(|geometry| length <= geometry.size() as u64)
    }

    /// The size of all pages, in bytes.
    pub const fn size(self) -> usize {
        self.pages * self.page_size
    }
}
