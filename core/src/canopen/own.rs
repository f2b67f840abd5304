//! What a product adds to the standard: own objects, which neither CiA 301 nor a table of parameters describes, and rules for its stored
//! parameters.
//!
//! The dictionary has the address, the type and the access of an own object ([`Object::own`](super::Object::own)).
//! [`Product::OWN`] has its functions, in the same order. State that is not a parameter is in
//! [`Product::State`]. [`Product::adapt`] changes parameters that were taken from the
//! memory, [`Product::settled`] can begin a save that no master has requested.
//!
//! A parameter is a number. For a text that is stored, the letters are parameters without an object, four in each of the type
//! [`U32`](crate::param::DataType::U32); the functions of the own object read and write them.

use super::Abort;
use super::product::{ContextOf, ParametersOf, Product};

/// The functions of an own object of product `P`. A closure that uses its arguments needs the product:
/// `Own::<Mast>::number(0x2300, 0, |_, cx| cx.values.faults().0.into())`.
pub struct Own<P: Product> {
    pub(super) index: u16,
    pub(super) sub: u8,
    pub(super) read: Read<P>,
    pub(super) write: Option<Write<P>>,
    pub(super) stored: Option<Stored<P>>,
}

/// Returns the contents of an own object.
pub(super) enum Read<P: Product> {
    /// The object cannot be read.
    No,
    Number(Number<P>),
    Text(Text<P>),
}

/// Returns the number in an own object.
type Number<P> = fn(&<P as Product>::State, &ContextOf<P>) -> u32;

/// Returns the text in an own object.
type Text<P> = fn(&<P as Product>::State, &ContextOf<P>) -> <P as Product>::Text;

/// Writes an own object. On an error, nothing has changed.
type Write<P> = fn(&mut Scope<'_, P>, &[u8]) -> Result<Then, Abort>;

/// Handles the end of a save that the object has begun. The argument is true if the save has succeeded.
type Stored<P> = fn(&mut Scope<'_, P>, bool);

/// The data that a function of the product can access.
pub struct Scope<'a, P: Product> {
    /// Parameters, values and the protocol-neutral half of the node.
    pub cx: &'a mut ContextOf<P>,
    /// The state of the product.
    pub state: &'a mut P::State,
    /// The parameters in the nonvolatile memory.
    pub stored: &'a ParametersOf<P>,
    /// The errors of 1003h.
    pub history: &'a mut P::History,
}

impl<P: Product> Scope<'_, P> {
    /// Begins a save of these parameters. Refused while another save is running.
    pub fn save(&mut self, parameters: ParametersOf<P>) -> Result<Then, Abort> {
        if self.cx.is_saving() {
            return Err(Abort::DeviceState);
        }
        self.cx.save(parameters);
        Ok(Then::Save)
    }
}

/// Parameters that were taken from the memory, and what a product can change with them.
pub struct Taken<'a, P: Product> {
    /// The parameters in RAM: all of them at a start, otherwise those of the communication profile were taken.
    pub parameters: &'a mut ParametersOf<P>,
    /// The state of the product.
    pub state: &'a mut P::State,
    /// The parameters in the nonvolatile memory.
    pub stored: &'a ParametersOf<P>,
    /// The errors of 1003h.
    pub history: &'a mut P::History,
}

/// What follows a write of an own object.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Then {
    /// The reply is sent at once.
    Reply,
    /// The reply is sent at the end of the save that the function has begun with [`Scope::save`].
    Save,
    /// The reply is sent, then the node is reset as by the NMT command: node-ID and bit rate keep their present values.
    Reset,
    /// The reply is sent, then the node restarts as after power-up.
    Restart,
}

impl<P: Product> Own<P> {
    /// A number that is read with this function. A signed number can have more bits than its type.
    pub const fn number(index: u16, sub: u8, read: Number<P>) -> Self {
        Self {
            read: Read::Number(read),
            ..Self::plain(index, sub)
        }
    }

    /// A text that is read with this function.
    pub const fn text(index: u16, sub: u8, read: Text<P>) -> Self {
        Self {
            read: Read::Text(read),
            ..Self::plain(index, sub)
        }
    }

    /// An object that can only be written, with this function. The data has the size of the number, or is a text.
    pub const fn command(index: u16, sub: u8, write: Write<P>) -> Self {
        Self::plain(index, sub).written(write)
    }

    /// The same, written with this function.
    pub const fn written(self, write: Write<P>) -> Self {
        Self {
            write: Some(write),
            ..self
        }
    }

    /// The same with this function after a save that it has begun. The function may change parameters in RAM, so other parameters are
    /// not written during the save.
    pub const fn after_save(self, stored: Stored<P>) -> Self {
        Self {
            stored: Some(stored),
            ..self
        }
    }

    const fn plain(index: u16, sub: u8) -> Self {
        Self {
            index,
            sub,
            read: Read::No,
            write: None,
            stored: None,
        }
    }
}
