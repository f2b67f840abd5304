//! GEMAC IS2D 90 P20 in the metal housing, two axes, the older type, with a heated measuring cell.
#![cfg_attr(target_os = "none", no_std, no_main)]

use plumbline::fsc::Article;
use plumbline::model::gemac::is2dm::{self, Is2dm};

/// The article that this firmware replaces.
const ARTICLE: &Article = &is2dm::METAL;

firmware_stm32::firmware!(Is2dm, ARTICLE);
