//! Explicit requests: received frames, fragments and the unconnected port, and their responses.

use super::explicit::{self, Data, FRAGMENT, Failure, Request, is_response, service};
use super::fragment::{self, Kind};
use super::identifiers::group_2;
use super::objects;
use super::protocol::{ContextOf, Devicenet};
use super::table::Product;
use crate::can::Frame;
use crate::time::Instant;

/// The form of a response that is not a text.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    /// A frame without fragmentation.
    Plain,
    /// A complete fragment, as the request; unfragmented if it does not fit.
    Fragment,
}

impl<P: Product> Devicenet<P> {
    /// Handles a frame on the explicit connection.
    pub(super) fn explicit(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) {
        let &[header, ref body @ ..] = frame.bytes() else {
            return;
        };
        let Some(&service) = body.first() else {
            return;
        };
        if !self.connections.accepts_from(header & explicit::MAC) {
            return;
        }
        if header & FRAGMENT != 0 {
            return self.fragment(cx, now, header, body);
        }
        if !is_response(service) {
            self.receiver.stop();
            self.serve(cx, now, header, body, Form::Plain);
        }
    }

    /// Handles a fragment of a request, or the acknowledge of a fragment of a response.
    pub(super) fn fragment(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        header: u8,
        bytes: &[u8],
    ) {
        match fragment::kind(bytes) {
            Some(Kind::Acknowledge { count, status }) => self.sender.acknowledge(count, status),
            Some(Kind::Part) => {
                let Some((answer, is_complete)) = self.receiver.receive(bytes) else {
                    return;
                };
                let (data, length) = fragment::acknowledge(header, answer);
                self.send(cx, group_2::RESPONSE, data, length);
                let (body, length) = self.receiver.body();
                if let Some(body) = body.get(..length)
                    && is_complete
                    && body.first().is_some_and(|service| !is_response(*service))
                {
                    self.serve(cx, now, header, body, Form::Plain);
                }
            }
            Some(Kind::Whole) => {
                self.receiver.stop();
                let body = bytes.get(1..).unwrap_or(&[]);
                if body.first().is_some_and(|service| !is_response(*service)) {
                    self.serve(cx, now, header, body, Form::Fragment);
                }
            }
            None => {}
        }
        cx.shell.wake_up();
    }

    /// Serves a request of the owner on the explicit connection, and answers it.
    fn serve(&mut self, cx: &mut ContextOf<P>, now: Instant, header: u8, body: &[u8], form: Form) {
        if self.connections.requested(now) || self.sender.is_running() {
            self.sender.stop();
            cx.shell.wake_up();
        }
        let master = header & explicit::MAC;
        let result = match Request::parse(body) {
            Ok(request) => objects::serve(self, cx, now, master, &request),
            Err(failure) => Err(failure),
        };
        let service = body.first().copied().unwrap_or(0);
        self.respond(cx, header, service, result, form);
        if service != service::GET {
            self.update_io(cx);
        }
    }

    /// Handles a request to the unconnected port.
    pub(super) fn unconnected(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) {
        let &[header, ref body @ ..] = frame.bytes() else {
            return;
        };
        let Some(&service) = body.first() else {
            return;
        };
        if header & FRAGMENT != 0 || is_response(service) {
            return;
        }
        const NOT_SUPPORTED: Failure = Failure::RESOURCE.with(3);
        let result = match service {
            service::ALLOCATE | service::RELEASE => match Request::parse(body) {
                Ok(request) if objects::is_unconnected(&request) => {
                    objects::devicenet::link(self, now, header & explicit::MAC, &request)
                }
                Ok(_) => Err(NOT_SUPPORTED),
                Err(failure) => Err(failure),
            },
            _ => Err(NOT_SUPPORTED),
        };
        self.respond(cx, header, service, result, Form::Plain);
        self.update_io(cx);
    }

    /// Queues the response to a request.
    fn respond(
        &mut self,
        cx: &mut ContextOf<P>,
        header: u8,
        service: u8,
        result: Result<Data, Failure>,
        form: Form,
    ) {
        let header = header & explicit::ECHO;
        let plain = match result {
            Ok(Data::Bytes { bytes, length }) => {
                explicit::unfragmented(header, service, bytes, length)
            }
            Ok(Data::Text(text)) => {
                // Sent by `tick`, after the frames that wait.
                self.sender.start(header, service, text);
                return cx.shell.wake_up();
            }
            Err(failure) => explicit::error(header, failure),
        };
        let whole = match form {
            Form::Plain => None,
            Form::Fragment => fragment::whole(plain),
        };
        let (data, length) = whole.unwrap_or(plain);
        self.send(cx, group_2::RESPONSE, data, length);
    }
}
