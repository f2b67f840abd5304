//! The object 5F00h with the diagnostic data ([`diagnosis`](crate::diagnosis)). It is not a row of a dictionary, because the originals do not
//! have it; the objects of [`program`](super::program) are none for the same reason.

use super::Abort;
use super::lookup::find_row;
use super::product::{ContextOf, Product};
use super::protocol::Services;
use super::sdo::message::{self, Address, Request};
use crate::application::Application;
use crate::diagnosis::{Diagnosis, OBJECT};
use crate::time::Instant;

/// The high byte of the index.
pub(super) const GROUP: u8 = OBJECT.to_be_bytes()[0];

impl<P: Product> Services<P> {
    /// The answer to a request for an object that the original does not have; None: it is for another one, or one of the product.
    #[cold]
    #[inline(never)]
    pub(super) fn answer_extra(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        request: [u8; 8],
    ) -> Option<[u8; 8]> {
        let request = Request::parse(request);
        let (Request::Upload(address) | Request::Download(address, _)) = request else {
            return None;
        };
        if find_row::<P>(address.index, address.sub).is_some() {
            return None;
        }
        if !P::Application::HAS_DIAGNOSIS || address.index != OBJECT {
            return self.answer_program(cx, now, address, request);
        }
        let is_read = matches!(request, Request::Upload(_));
        Some(answer(cx.diagnosis(), address, is_read))
    }
}

fn answer(diagnosis: &Diagnosis, address: Address, is_read: bool) -> [u8; 8] {
    match diagnosis.value(address.sub) {
        None => message::abort(address, Abort::NoSubIndex),
        Some(_) if !is_read => message::abort(address, Abort::ReadOnly),
        Some(number) => {
            let size = if address.sub == 0 { 1 } else { 4 };
            message::number_reply(address, number, size)
        }
    }
}
