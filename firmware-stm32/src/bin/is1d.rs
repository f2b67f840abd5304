//! GEMAC IS1D 00 P20, one axis, the older type.
#![cfg_attr(target_os = "none", no_std, no_main)]

use plumbline::fsc::Article;
use plumbline::model::gemac::is1d::{self, Is1d};

/// The article that this firmware replaces.
const ARTICLE: &Article = &is1d::PLASTIC;

firmware_stm32::firmware!(Is1d, ARTICLE);
