//! The adapters of a bus. They are few, and the bus goes through them for each bit: a list takes less time than a map.

use super::AdapterId;
use super::line::Line;
use crate::adapter::Adapter;

/// An adapter and its connection to the wire.
pub(super) type Connected = (Adapter, Line);

/// The adapters in the order of their numbers.
#[derive(Default)]
pub(super) struct Adapters(Vec<(AdapterId, Connected)>);

impl Adapters {
    /// Adds an adapter. Its number must be higher than all others.
    pub(super) fn push(&mut self, id: AdapterId) {
        self.0.push((id, Connected::default()));
    }

    pub(super) fn remove(&mut self, id: AdapterId) {
        self.0.retain(|(one, _)| *one != id);
    }

    pub(super) fn get(&self, id: AdapterId) -> Option<&Connected> {
        self.iter().find(|(one, _)| **one == id).map(|(_, one)| one)
    }

    pub(super) fn get_mut(&mut self, id: AdapterId) -> Option<&mut Connected> {
        let mut all = self.iter_mut();
        all.find(|(one, _)| **one == id).map(|(_, one)| one)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (&AdapterId, &Connected)> {
        self.0.iter().map(|(id, one)| (id, one))
    }

    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = (&AdapterId, &mut Connected)> {
        self.0.iter_mut().map(|(id, one)| (&*id, one))
    }

    pub(super) fn values(&self) -> impl Iterator<Item = &Connected> {
        self.0.iter().map(|(_, one)| one)
    }

    pub(super) fn values_mut(&mut self) -> impl Iterator<Item = &mut Connected> {
        self.0.iter_mut().map(|(_, one)| one)
    }
}
