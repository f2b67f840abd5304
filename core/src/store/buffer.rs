//! The buffer of the store: its size, and whether the product stores the usage of the device.

#[cfg(doc)]
use super::Store;

/// The buffer of a [`Store`]: an array of bytes.
pub trait Buffer: Send + AsRef<[u8]> + AsMut<[u8]> + 'static {
    /// All bytes 0.
    const ZERO: Self;
    /// The number of bytes.
    const SIZE: usize;
    /// Whether the product stores the usage of the device. If not, an image does not contain the code for it.
    const USAGE: bool;
}

impl<const N: usize> Buffer for [u8; N] {
    const ZERO: Self = [0; N];
    const SIZE: usize = N;
    const USAGE: bool = true;
}

/// The buffer of a product that keeps its usage if `USAGE` is true.
#[derive(Debug)]
pub struct Records<const N: usize, const USAGE: bool>([u8; N]);

impl<const N: usize, const USAGE: bool> AsRef<[u8]> for Records<N, USAGE> {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

impl<const N: usize, const USAGE: bool> AsMut<[u8]> for Records<N, USAGE> {
    fn as_mut(&mut self) -> &mut [u8] {
        &mut self.0
    }
}

impl<const N: usize, const USAGE: bool> Buffer for Records<N, USAGE> {
    const ZERO: Self = Self([0; N]);
    const SIZE: usize = N;
    const USAGE: bool = USAGE;
}
