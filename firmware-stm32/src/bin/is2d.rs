//! GEMAC IS2D 90 P20, two axes, the older type.
#![cfg_attr(target_os = "none", no_std, no_main)]

use plumbline::fsc::Article;
use plumbline::model::gemac::is2d::{self, Is2d};

/// The article that this firmware replaces.
const ARTICLE: &Article = &is2d::PLASTIC;

firmware_stm32::firmware!(Is2d, ARTICLE);
