//! GEMAC IS2xx090-C-xL, two axes.
#![cfg_attr(target_os = "none", no_std, no_main)]

use plumbline::fsc::Article;
use plumbline::model::gemac::is2::{self, Is2};

/// The article that this firmware replaces. The others are in the document of the product, for example `&is2::MA_BL`.
const ARTICLE: &Article = &is2::BP_CL;

firmware_stm32::firmware!(Is2, ARTICLE);
