//! The node of a product, for a driver of any product.

use super::{Acquisition, Boot, CanNode, Communication, Node, Protocol, Restore};
use crate::application::Application;
use crate::param::Table;
use crate::store::{ImageId, Owner, Store};
use crate::time::Instant;

/// The node of a product. It is the only bound of a driver of any product: it has the start, the owner of the stored records, the sizes,
/// and the two halves of the node.
///
/// A driver with one thread uses it as a [`Node`], a driver with two priorities uses its [`halves`](Self::halves).
///
/// ```
/// use plumbline::node::{Boot, ProductNode};
/// use plumbline::time::Instant;
///
/// /// Starts a node in its place, for example in static memory.
/// fn start<N: ProductNode>(node: &mut N, article: &N::Article, boot: &Boot) {
///     assert!(N::FILTERS <= 14, "the controller has a bank for each filter");
///     node.start(article, Instant::from_ticks(0), boot);
/// }
///
/// use plumbline::model::gemac::is2::{BP_CL, Is2};
/// use plumbline::model::jn2101::Jn2101;
///
/// start(&mut Is2::INITIAL, &BP_CL, &Boot::default());
/// start(&mut Jn2101::INITIAL, &(), &Boot::default());
/// ```
pub trait ProductNode: Node + Send + Sized + 'static {
    /// The application, in the measuring half.
    type Application: Application;
    /// The protocol, in the communicating half.
    type Protocol: Protocol<Self::Application>;
    /// The articles of the product, from which a start selects one; `()` if there is only one.
    type Article: 'static;

    /// A node that is not started, for static memory. All bits are 0, so it needs no flash.
    const INITIAL: Self;
    /// The number of acceptance filters.
    const FILTERS: usize = <Self::Protocol as Protocol<Self::Application>>::FILTERS;
    /// Whether it can detect the bit rate. If not, a driver does not measure the [bit time](super::BusEvent::BitTime).
    const DETECTS: bool = <Self::Protocol as Protocol<Self::Application>>::DETECTS;

    /// Whether it requests self-tests of the accelerometer.
    const HAS_SELF_TEST: bool = Self::Application::HAS_SELF_TEST;
    /// Whether it needs the angular rate.
    const HAS_GYROSCOPE: bool = Self::Application::HAS_GYROSCOPE;

    /// The owner of the records in the store of a device with this serial number.
    fn owner(article: &Self::Article, serial: u32) -> Owner;

    /// Starts an [`INITIAL`](Self::INITIAL) node after power-up or a restart. If the stored parameters are not usable, it has the factory
    /// values, and the memory fault is active.
    fn start(&mut self, article: &Self::Article, now: Instant, boot: &Boot);

    /// The communicating and the measuring half, for a driver that handles frames at a higher priority than readings.
    fn halves(&mut self) -> (&mut CommunicationOf<Self>, &mut AcquisitionOf<Self>);
}

/// The communicating half of node `N`.
pub type CommunicationOf<N> =
    Communication<<N as ProductNode>::Application, <N as ProductNode>::Protocol>;

/// The measuring half of node `N`.
pub type AcquisitionOf<N> = Acquisition<<N as ProductNode>::Application>;

/// The store for node `N` in memory `M`.
pub type StoreOf<N, M> =
    Store<M, <<<N as ProductNode>::Application as Application>::Table as Table>::Buffer>;

/// The owner of the records of a product with application `A`.
pub(crate) const fn owner<A: Application>(image: ImageId, serial: u32) -> Owner {
    const { assert!(A::Table::LAYOUT >= 1) };
    Owner {
        image,
        layout: A::Table::LAYOUT,
        serial,
    }
}

impl<P: Restore> ProductNode for CanNode<P::Application, P> {
    type Application = P::Application;
    type Protocol = P;
    type Article = ();

    const INITIAL: Self = Self::INITIAL;

    fn owner((): &(), serial: u32) -> Owner {
        owner::<P::Application>(P::IMAGE, serial)
    }

    fn start(&mut self, (): &(), now: Instant, boot: &Boot) {
        self.start(now, boot);
    }

    fn halves(&mut self) -> (&mut CommunicationOf<Self>, &mut AcquisitionOf<Self>) {
        self.split()
    }
}
