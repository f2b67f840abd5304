//! Requests on the Set-Parameter-ID (table 17) and their functions (sections 9.7 to 9.10).
//!
//! A refused request changes no parameter. Its reply contains the code and the status byte with CmdParamError set.

use super::projection::{Row, signature_of};
use super::protocol::{ContextOf, Fsc, ParametersOf};
use super::table::{Operation, Product};
use crate::application::Application;
use crate::can::Frame;
use crate::diagnosis::CODE;
use crate::param::number;
use crate::text::Text;
use crate::time::Instant;

/// The code of an update.
pub const UPDATE: u8 = 0x60;
/// Its signature.
pub const FLASH: &[u8] = b"FLASH";

impl<P: Product> Fsc<P> {
    const LOAD_SIGNATURE: &'static [u8] = signature_of(P::FUNCTIONS, Operation::Load);
    const SAVE_SIGNATURE: &'static [u8] = signature_of(P::FUNCTIONS, Operation::Save);
    const RESET_SIGNATURE: &'static [u8] = signature_of(P::FUNCTIONS, Operation::Alive);

    /// Answers the request in `frame`, which is no read. `row` is the row of its code.
    pub(super) fn request(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        frame: &Frame,
        row: Option<Row>,
    ) {
        let Some((&code, data)) = frame.bytes().split_first() else {
            // There is no code to echo, so there is no reply.
            self.raise_cmd_param_error();
            return;
        };
        if cx.is_saving() && self.must_wait(cx, row, data) {
            cx.shell.defer(frame);
            return;
        }
        let Some(row) = row else {
            self.unknown(cx, now, frame);
            return;
        };
        match row.operation {
            // `receive` answers reads.
            Operation::Read | Operation::Inclination => {}
            Operation::ReadStatus => {
                self.send(cx, row);
                self.sticky = 0;
            }
            Operation::Write => match self.write(cx, now, row, data) {
                Some(()) => self.acknowledge(cx, code),
                None => self.refuse(cx, code),
            },
            Operation::Load if data.starts_with(Self::LOAD_SIGNATURE) => {
                self.loading = true;
                cx.save(ParametersOf::<P>::factory());
            }
            Operation::Save if data.starts_with(Self::SAVE_SIGNATURE) => {
                self.loading = false;
                cx.save(cx.parameters);
            }
            Operation::Load | Operation::Save => self.refuse(cx, code),
            Operation::Own => match Self::serve_own(cx, code, data) {
                Some(data) => self.answer(cx, code, &data),
                None => self.refuse(cx, code),
            },
            Operation::Alive if data.starts_with(Self::RESET_SIGNATURE) => self.restart(cx, now),
            Operation::Alive => {
                // Other data is padding, except a signature that begins like the right one.
                if data.first() == Self::RESET_SIGNATURE.first() {
                    self.raise_cmd_param_error();
                }
                self.send(cx, row);
            }
        }
    }

    /// Performs the function of an own code.
    fn serve_own(cx: &mut ContextOf<P>, code: u8, data: &[u8]) -> Option<Text<6>> {
        let own = P::OWN.iter().find(|own| own.code == code)?;
        (own.serve)(cx, data)
    }

    /// Answers a code that the product does not have. Code 61h with a number reads a value of the [`diagnosis`](crate::diagnosis). A sensor
    /// behind a bootloader has that of an update: with the signature it restarts into the bootloader, without data it replies with the
    /// CRC-32 and the hardware of the program. All others are refused.
    #[cold]
    #[inline(never)]
    fn unknown(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) {
        match (frame.bytes(), cx.shell.program()) {
            (&[CODE, number], _) if P::Application::HAS_DIAGNOSIS => {
                match cx.diagnosis().value(number) {
                    Some(value) => {
                        let head = u32::from_le_bytes([CODE, self.sticky, number, 0]);
                        let word = u64::from(value) << 24 | u64::from(head);
                        cx.shell.send(Frame::word(self.in_force.reply, word, 7));
                    }
                    None => self.refuse(cx, CODE),
                }
            }
            ([UPDATE], Some(program)) => {
                // The sticky bits of the status: its other bits would make the replies to reads slower.
                let head = u16::from_le_bytes([UPDATE, self.sticky]);
                let hardware = u64::from(program.hardware.number()) << 48;
                let word = hardware | u64::from(program.crc) << 16 | u64::from(head);
                cx.shell.send(Frame::word(self.in_force.reply, word, 8));
            }
            ([UPDATE, data @ ..], Some(_)) if data.starts_with(FLASH) && cx.is_saving() => {
                cx.shell.defer(frame);
            }
            ([UPDATE, data @ ..], Some(_)) if data.starts_with(FLASH) => {
                self.acknowledge(cx, UPDATE);
                cx.shell.enter_bootloader();
                self.restart(cx, now);
            }
            ([code, ..], _) => self.refuse(cx, *code),
            ([], _) => {}
        }
    }

    fn refuse(&mut self, cx: &mut ContextOf<P>, code: u8) {
        self.raise_cmd_param_error();
        self.acknowledge(cx, code);
    }

    /// Writes parameters if their values are permitted. They act at once, except those that act after a restart. Bytes after the
    /// last value are ignored.
    fn write(&mut self, cx: &mut ContextOf<P>, now: Instant, row: Row, data: &[u8]) -> Option<()> {
        let was_cyclic = cx.parameters.get(P::ROLES.cyclic_mode);
        if row.has_several() || row.is_constrained() {
            // If one value is refused, all keep their old values.
            let before = cx.parameters;
            if Self::set(cx, row, data).is_none() || !cx.parameters.is_consistent() {
                cx.parameters = before;
                return None;
            }
        } else {
            Self::set(cx, row, data)?;
        }
        if !row.is_own() {
            cx.apply();
        } else if was_cyclic != cx.parameters.get(P::ROLES.cyclic_mode) {
            self.restart_cyclic(cx, now);
        } else if row.is_cyclic_time()
            && let Some(cyclic) = &mut self.cyclic
        {
            cyclic.set_period(now, cx.parameters.get(P::ROLES.cyclic_time));
            cx.shell.wake_up();
        }
        Some(())
    }

    /// Sets the parameters of a row in order. Stops at the first value that is missing or not permitted.
    fn set(cx: &mut ContextOf<P>, row: Row, mut data: &[u8]) -> Option<()> {
        let derived = data.is_empty();
        for item in P::CODES.items(row) {
            let id = item.parameter()?;
            let value = if derived {
                // Automatic zero point adjustment (section 9.2).
                P::Application::derive(id, &cx.values)?
            } else {
                let (bytes, rest) = data.split_at_checked(item.size.into())?;
                data = rest;
                number(bytes)
            };
            ParametersOf::<P>::check(id, value).ok()?;
            // SAVE stores all parameters, so the effect does not matter.
            P::Application::write(id, value, &cx.values, &mut cx.parameters).ok()?;
        }
        Some(())
    }

    /// Whether a request must wait until the running save has ended: a save, a load or a restart. A write must wait for a load,
    /// because the load replaces the parameters, and for requests that wait already.
    fn must_wait(&self, cx: &ContextOf<P>, row: Option<Row>, data: &[u8]) -> bool {
        match row.map(|row| row.operation) {
            Some(Operation::Load | Operation::Save) => true,
            Some(Operation::Alive) => data.starts_with(Self::RESET_SIGNATURE),
            Some(Operation::Write) => self.loading || cx.shell.has_deferred(),
            _ => false,
        }
    }
}
