//! The records of the device: its calibration, the identity of the unit, and its usage. They are at the beginning of the buffer of the
//! store, and are written before the first parameters of a slot.

use super::{Buffer, Store};
use crate::measure::calibration::{self, Calibration};
use crate::store::record::{self, CALIBRATION_AT, CALIBRATION_SIZE, HEADER};
use crate::store::survey::{Place, Survey};
use crate::store::unit::{self, Unit};
use crate::store::usage::{self, Usage};
use core::ops::Range;
use embedded_storage::nor_flash::NorFlash;

impl<M: NorFlash, B: Buffer> Store<M, B> {
    /// Begins to save a new calibration, followed by the newest parameters. Call [`step`](Self::step) until the save has ended. Only
    /// for a store without a save since [`open`](Self::open). The save fails if the stored parameters are longer than the buffer:
    /// those of a newer firmware can be.
    pub fn calibrate(&mut self, calibration: &Calibration) {
        let mut unit = [0; unit::SIZE];
        let length = copy(self.identity(), &mut unit);
        let unit = unit.get(..length).unwrap_or_default();
        self.renew(Some(&calibration.encode()), unit);
    }

    /// Begins to save the identity of the unit, followed by the newest parameters, as [`calibrate`](Self::calibrate) does.
    pub fn identify(&mut self, unit: &Unit) {
        let mut bytes = [0; unit::SIZE];
        let length = unit.encode(self.owner.image, &mut bytes);
        let unit = bytes.get(..length.unwrap_or(0)).unwrap_or_default();
        let calibration = self.calibration().first_chunk().copied();
        self.renew(calibration.as_ref(), unit);
    }

    /// Begins to save these records of the device, followed by the newest parameters.
    fn renew(&mut self, calibration: Option<&[u8; calibration::SIZE]>, unit: &[u8]) {
        let mut parameters = B::ZERO;
        let stored = self.boot().parameters;
        let length = stored.map(|stored| copy(stored, parameters.as_mut()));
        self.seal_device(calibration, unit);
        // The slots contain other ones.
        for slot in &mut self.slots {
            slot.has_device = false;
        }
        match length {
            Some(length) => self.save_after_device(|buffer| {
                let parameters = parameters.as_ref().get(..length)?;
                buffer.get_mut(..length)?.copy_from_slice(parameters);
                Some(length)
            }),
            None => self.begin(self.device),
        }
    }

    /// Reads the records of the device from the memory into the buffer.
    pub(super) fn read_device(&mut self, calibration: Place, identity: Place, usage: usize) {
        let mut bytes = [0; calibration::SIZE];
        let mut unit = [0; unit::SIZE];
        // A read that fails gives zeros: the calibration that changes nothing, and an identity that gives nothing.
        // An old calibration is shorter: it has no zero rate.
        let place = bytes.get_mut(..calibration.length).unwrap_or_default();
        let _ = self.memory.read(calibration.address as u32, place);
        let unit = unit.get_mut(..identity.length).unwrap_or_default();
        let _ = self.memory.read(identity.address as u32, unit);
        if B::USAGE && usage > 0 {
            let mut bytes = [0; usage::SIZE];
            self.has_usage = self.memory.read(usage as u32, &mut bytes).is_ok();
            self.usage = Usage::decode(&bytes);
        }
        self.seal_device((calibration.address > 0).then_some(&bytes), unit);
    }

    /// Writes the records of the device into the buffer: the calibration, if there is one, and the encoded identity, if it is not
    /// empty.
    fn seal_device(&mut self, calibration: Option<&[u8; calibration::SIZE]>, unit: &[u8]) {
        let sequence = self.sequence.wrapping_add(1);
        self.is_calibrated = calibration.is_some();
        self.unit = unit.len();
        // Both fit into each buffer of a store.
        let size = calibration.and_then(|bytes| {
            record::encode_calibration(self.buffer.as_mut(), self.owner.serial, sequence, bytes)
        });
        let start = size.unwrap_or(0);
        let rest = self.buffer.as_mut().get_mut(start..).unwrap_or_default();
        let size = (!unit.is_empty())
            .then(|| record::encode_unit(rest, sequence, unit))
            .flatten();
        self.device = start + size.unwrap_or(0);
        if B::USAGE && self.has_usage {
            self.seal_usage();
        }
    }

    /// Writes the record of the usage into the buffer, behind the other records of the device.
    pub(super) fn seal_usage(&mut self) {
        let sequence = self.sequence.wrapping_add(1);
        let place = self.buffer.as_mut().get_mut(self.device..);
        let usage = self.usage.encode(self.owner.serial);
        let size = record::encode_usage(place.unwrap_or_default(), sequence, &usage);
        self.device += size.unwrap_or(0);
    }

    /// Whether a slot contains the records of the device that are in the buffer.
    pub(super) fn is_device(&mut self, survey: &Survey) -> bool {
        let calibration = self.calibration_place();
        let identity = self.identity_place();
        survey.calibration.length == calibration.len()
            && self.is_at(survey.calibration.address, calibration)
            && survey.unit.length == self.unit
            && self.is_at(survey.unit.address, identity)
            && (!B::USAGE || survey.usage > 0 || !self.has_usage)
    }

    /// Whether a calibration and an identity that are not complete are those in the buffer, so that nothing is lost.
    pub(super) fn has(&mut self, torn: [Place; 2]) -> bool {
        let places = [self.calibration_place(), self.identity_place()];
        torn.into_iter().zip(places).all(|(torn, place)| {
            torn.address == 0 || !place.is_empty() && self.is_at(torn.address, place)
        })
    }

    /// Whether this part of the buffer is at an address.
    fn is_at(&mut self, address: usize, part: Range<usize>) -> bool {
        let bytes = self.buffer.as_ref().get(part).unwrap_or_default();
        bytes.is_empty()
            || (address > 0
                && bytes.iter().zip(address..).all(|(own, at)| {
                    let mut byte = [0];
                    self.memory.read(at as u32, &mut byte).is_ok() && byte == [*own]
                }))
    }

    /// The check of the records of the device. Of the calibration it has the part of an old one, so that an update of the firmware
    /// finds the check of its parameters.
    pub(super) fn check(&self) -> u8 {
        let calibration = self.calibration();
        let part = calibration.get(..calibration::ACCELEROMETER_SIZE);
        record::check(part.unwrap_or_default(), self.identity())
    }

    /// The calibration in the buffer; empty if there is none.
    pub(super) fn calibration(&self) -> &[u8] {
        let buffer = self.buffer.as_ref();
        buffer.get(self.calibration_place()).unwrap_or_default()
    }

    fn calibration_place(&self) -> Range<usize> {
        let size = if self.is_calibrated {
            calibration::SIZE
        } else {
            0
        };
        CALIBRATION_AT..CALIBRATION_AT + size
    }

    /// The encoded identity in the buffer; empty if there is none.
    pub(super) fn identity(&self) -> &[u8] {
        self.buffer
            .as_ref()
            .get(self.identity_place())
            .unwrap_or_default()
    }

    fn identity_place(&self) -> Range<usize> {
        let start = if self.is_calibrated {
            CALIBRATION_SIZE
        } else {
            0
        };
        start + HEADER..start + HEADER + self.unit
    }
}

/// Copies the bytes to the beginning of a buffer that is not shorter. Returns their number.
fn copy(bytes: &[u8], into: &mut [u8]) -> usize {
    for (to, from) in into.iter_mut().zip(bytes) {
        *to = *from;
    }
    bytes.len()
}
