//! GEMAC IS2TK090-C-RL, two axes, with a heated measuring cell.
#![cfg_attr(target_os = "none", no_std, no_main)]

use plumbline::fsc::Article;
use plumbline::model::gemac::is2tk::{self, Is2tk};

/// The article that this firmware replaces.
const ARTICLE: &Article = &is2tk::METAL;

firmware_stm32::firmware!(Is2tk, ARTICLE);
