//! Optional services: a product selects them by type and does not pay for those that it does not have.

/// A service that a product has ([`Present`]) or does not have ([`Absent`]), with the state `T`.
pub trait Feature<T>: Send + 'static {
    /// Whether the product has the service.
    const PRESENT: bool;
    /// The state before the start.
    const INITIAL: Self;

    /// The state of the service.
    fn get(&self) -> Option<&T>;

    /// The state of the service, to change it.
    fn get_mut(&mut self) -> Option<&mut T>;
}

/// The state of a service before the start. If all its bits are 0, it needs no flash.
pub trait Initial: Send + 'static {
    /// The state before the start.
    const INITIAL: Self;
}

impl Initial for () {
    const INITIAL: Self = ();
}

/// The product does not have the service.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Absent;

/// The product has the service with the state `T`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Present<T>(T);

impl<T> Feature<T> for Absent {
    const PRESENT: bool = false;
    const INITIAL: Self = Self;

    fn get(&self) -> Option<&T> {
        None
    }

    fn get_mut(&mut self) -> Option<&mut T> {
        None
    }
}

impl<T: Initial> Feature<T> for Present<T> {
    const PRESENT: bool = true;
    const INITIAL: Self = Self(T::INITIAL);

    fn get(&self) -> Option<&T> {
        Some(&self.0)
    }

    fn get_mut(&mut self) -> Option<&mut T> {
        Some(&mut self.0)
    }
}
