//! GEMAC IS1D 00 P20 in the metal housing, one axis, the older type, with a heated measuring cell.
#![cfg_attr(target_os = "none", no_std, no_main)]

use plumbline::fsc::Article;
use plumbline::model::gemac::is1dm::{self, Is1dm};

/// The article that this firmware replaces.
const ARTICLE: &Article = &is1dm::METAL;

firmware_stm32::firmware!(Is1dm, ARTICLE);
