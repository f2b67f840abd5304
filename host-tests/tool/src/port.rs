//! The adapter of a port: `demo:PRODUCT`, or an adapter of this computer.

use crate::demo;
use crate::error::{Error, RequestError};
use adapter::{Adapter, AdapterError};
use plumbline::model::catalog::PRODUCTS;

/// The adapter of a port. It is not open yet.
///
/// # Errors
/// The text is no port, or the port cannot be used.
pub fn connect(port: &str) -> Result<Box<dyn Adapter>, Error> {
    if let Some(product) = port.strip_prefix("demo:") {
        return Ok(match adapter::is_in_bus_time() {
            true => Box::new(demo::unpaced(product)?),
            false => Box::new(demo::adapter(product)?),
        });
    }
    if port == "demo" {
        let meant = "demo:is2".to_owned();
        return Err(AdapterError::Meant(port.to_owned(), meant).into());
    }
    if PRODUCTS.iter().any(|product| product.name == port) {
        let meant = format!("demo:{port}");
        return Err(AdapterError::Meant(port.to_owned(), meant).into());
    }
    adapter::connect(port).map_err(|failure| match failure {
        AdapterError::UnknownPort(port) => RequestError::UnknownPort(port).into(),
        other => other.into(),
    })
}
