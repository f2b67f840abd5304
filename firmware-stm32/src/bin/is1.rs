//! GEMAC IS1xx360-C-xL, one axis.
#![cfg_attr(target_os = "none", no_std, no_main)]

use plumbline::fsc::Article;
use plumbline::model::gemac::is1::{self, Is1};

/// The article that this firmware replaces. The others are in the document of the product, for example `&is1::MA_BL`.
const ARTICLE: &Article = &is1::BP_CL;

firmware_stm32::firmware!(Is1, ARTICLE);
