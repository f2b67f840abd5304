//! GEMAC IS1TK360-C-RL, one axis, with a heated measuring cell.
#![cfg_attr(target_os = "none", no_std, no_main)]

use plumbline::fsc::Article;
use plumbline::model::gemac::is1tk::{self, Is1tk};

/// The article that this firmware replaces.
const ARTICLE: &Article = &is1tk::METAL;

firmware_stm32::firmware!(Is1tk, ARTICLE);
