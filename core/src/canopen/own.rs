//! The functions of the own objects of a product: objects that neither CiA 301 nor a table of parameters describes.
//!
//! The dictionary has the address, the type and the access of an own object ([`Object::own`](super::Object::own)).
//! [`Product::OWN`](super::Product::OWN) has its functions, in the same order. State that is not a parameter is in
//! [`Product::State`](super::Product::State).

use super::Abort;
use crate::application::Application;
use crate::node::Context;
use crate::param::Parameters;

/// The functions of an own object, for application `A`, state `S` of the product and texts `T`.
pub struct Own<A: Application, S, T> {
    pub(super) index: u16,
    pub(super) sub: u8,
    pub(super) read: Read<A, S, T>,
    pub(super) write: Option<Write<A, S>>,
    pub(super) stored: Stored<A, S>,
}

/// Returns the contents of an own object.
pub(super) enum Read<A: Application, S, T> {
    /// The object cannot be read.
    No,
    Number(fn(&S, &Context<A>) -> u32),
    Text(fn(&S, &Context<A>) -> T),
}

/// Writes an own object. On an error, nothing has changed.
type Write<A, S> = fn(&mut Scope<'_, A, S>, &[u8]) -> Result<Then, Abort>;

/// Handles the end of a save that the object has begun. The argument is true if the save has succeeded.
type Stored<A, S> = fn(&mut Scope<'_, A, S>, bool);

/// The data that a function of an own object can access.
pub struct Scope<'a, A: Application, S> {
    /// Parameters, values and the protocol-neutral half of the node.
    pub cx: &'a mut Context<A>,
    /// The state of the product.
    pub state: &'a mut S,
    /// The parameters in the nonvolatile memory.
    pub stored: &'a Parameters<A::Table>,
}

impl<A: Application, S> Scope<'_, A, S> {
    /// Begins a save of these parameters. Refused while another save is running.
    pub fn save(&mut self, parameters: Parameters<A::Table>) -> Result<Then, Abort> {
        if self.cx.is_saving() {
            return Err(Abort::DeviceState);
        }
        self.cx.save(parameters);
        Ok(Then::Save)
    }
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

impl<A: Application, S, T> Own<A, S, T> {
    /// A number that is read with this function. A signed number can have more bits than its type.
    pub const fn number(index: u16, sub: u8, read: fn(&S, &Context<A>) -> u32) -> Self {
        Self {
            read: Read::Number(read),
            ..Self::plain(index, sub)
        }
    }

    /// A text that is read with this function.
    pub const fn text(index: u16, sub: u8, read: fn(&S, &Context<A>) -> T) -> Self {
        Self {
            read: Read::Text(read),
            ..Self::plain(index, sub)
        }
    }

    /// An object that can only be written, with this function. The data has the size of the number, or is a text.
    pub const fn command(index: u16, sub: u8, write: Write<A, S>) -> Self {
        Self::plain(index, sub).written(write)
    }

    /// The same, written with this function.
    pub const fn written(self, write: Write<A, S>) -> Self {
        Self {
            write: Some(write),
            ..self
        }
    }

    /// The same with this function after a save.
    pub const fn after_save(self, stored: Stored<A, S>) -> Self {
        Self { stored, ..self }
    }

    const fn plain(index: u16, sub: u8) -> Self {
        Self {
            index,
            sub,
            read: Read::No,
            write: None,
            stored: |_, _| {},
        }
    }
}
