//! The GEMAC reference line: another product plus active compensation of the thermal drift (section 9.3).

use super::application::{Axes, Gemac};
use crate::fsc::projection::Codes;
use crate::fsc::table::{Access, Function, LedTable, Roles};
use crate::fsc::{Article, Product, StatusBit};
use core::marker::PhantomData;

/// Product `P` with a heated measuring cell.
pub struct Heated<P>(PhantomData<P>);

impl<P: Product + Axes> Product for Heated<P> {
    type Application = Gemac<P, true>;

    const ROLES: Roles = P::ROLES;
    const ACCESS: &'static [Access] = P::ACCESS;
    const FUNCTIONS: &'static [Function] = P::FUNCTIONS;
    const STATUS: [StatusBit; 8] = P::STATUS;
    const LEDS: LedTable = P::LEDS;
    const CODES: Codes = P::CODES;

    fn set_article(application: &mut Self::Application, article: &Article) {
        application.set_limit(article.limit);
    }
}
