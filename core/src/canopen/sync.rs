//! The SYNC consumer (CiA 301, 7.2.5): which frames are a SYNC.

use crate::can::Frame;

/// Whether `frame`, whose identifier is the SYNC's, is a SYNC: without data, or with a counter.
///
/// No sensor has a SYNC start value (sub-index 6 of a TPDO), so the counter itself has no meaning for them.
pub fn is_sync(frame: &Frame) -> bool {
    !frame.is_remote() && frame.dlc() <= 1
}
