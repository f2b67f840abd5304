//! The identity of a device in its data sheet (EDS), or in a configuration file (DCF), which also has the serial number.

use super::text_of;
use crate::error::Fault;
use crate::master::Protocol;
use descriptors::unit::Sheet;
use plumbline::model::catalog::Product;

/// Whether a text is a data sheet: it has sections, which a sheet of values has not.
pub fn is_data_sheet(text: &str) -> bool {
    text.lines().any(|line| line.trim_start().starts_with('['))
}

/// The text of a file in UTF-8, UTF-16 or Latin-1.
pub fn text(bytes: &[u8]) -> String {
    text_of(bytes)
}

/// The identity in a data sheet, for a unit of this product.
///
/// # Errors
/// One sentence: it cannot be read, is of another protocol, or has no identity.
pub fn sheet(text: &str, product: &Product) -> Result<Sheet, Fault> {
    let own = Protocol::of(product);
    let Some(format) = &own.data_sheet else {
        return Err(Fault::NoDataSheet(product.name));
    };
    let values = match super::format::of(text) {
        Some((protocol, other)) if protocol != own => {
            return Err(Fault::OfProtocol(other.name, product.name, format.name));
        }
        _ => (format.values)(text)?,
    };
    if values.is_empty() {
        return Err(Fault::NoIdentity);
    }
    Ok(Sheet {
        product: None,
        values,
    })
}
