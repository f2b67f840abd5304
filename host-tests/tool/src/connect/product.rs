//! Which product a sensor is. If the article and the software version of the sensor leave a doubt, the tool asks.

use super::Wanted;
use crate::error::{Error, RequestError, SensorError};
use crate::identify::Found;
use crate::master::Protocol;
use crate::output::Terminal;
use crate::question::{Name, Question, Version};
use plumbline::model::catalog::Product;

/// The product for a session.
///
/// # Errors
/// Several products fit or none does, the wanted one has another protocol, or a question was answered with no.
pub(super) fn decide(
    found: &Found,
    wanted: &Wanted,
    terminal: &mut Terminal,
) -> Result<&'static Product, Error> {
    match wanted.product {
        Some(product) => {
            permitted(found, product)?;
            if wanted.sheet.is_none() {
                confirmed(found, product, terminal)?;
            }
            Ok(product)
        }
        None => told(found, terminal),
    }
}

/// Refuses a product of another protocol.
fn permitted(found: &Found, wanted: &Product) -> Result<(), Error> {
    if found.target.protocol().is_of(wanted) {
        return Ok(());
    }
    Err(
        RequestError::ProductProtocol(wanted.name, Protocol::of(wanted).name, found.protocol())
            .into(),
    )
}

/// Asks about a product that does not fit the sensor.
fn confirmed(
    found: &Found,
    wanted: &'static Product,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let fits = |own: &&Product| own.name == wanted.name;
    if found.products.is_empty() || found.products.iter().any(fits) {
        return Ok(());
    }
    let (own, name) = (names(found), wanted.name);
    let question = Question::OtherProduct {
        told: own.clone(),
        article: article(found).to_owned(),
        version: found
            .firmware
            .clone()
            .map_or(Version::Unknown, Version::Reported),
        product: name.to_owned(),
    };
    if terminal.ask(&question)? {
        return Ok(());
    }
    Err(RequestError::OtherProduct(own, name).into())
}

/// The product that the sensor tells. If several fit, the user is asked about each one; `--yes` does not answer that.
fn told(found: &Found, terminal: &mut Terminal) -> Result<&'static Product, Error> {
    let (article, names) = (article(found), names(found));
    match &found.products[..] {
        [only] => Ok(only),
        [] if found.is_owned => Err(SensorError::OwnedUnknown(found.target.named()).into()),
        [] => Err(RequestError::UnknownArticle(article.to_owned()).into()),
        several => {
            // Who answers all questions with yes is not asked.
            let is_asked = !terminal.yes.contains(&Name::All);
            for product in several.iter().filter(|_| is_asked) {
                let question = Question::WhichProduct {
                    article: article.to_owned(),
                    products: names.clone(),
                    product: product.name.to_owned(),
                };
                if terminal.ask(&question)? {
                    return Ok(product);
                }
            }
            Err(RequestError::Several(article.to_owned(), names).into())
        }
    }
}

fn article(found: &Found) -> &str {
    found.article.as_deref().unwrap_or("unknown")
}

fn names(found: &Found) -> String {
    let names: Vec<&str> = found.products.iter().map(|product| product.name).collect();
    names.join(" or ")
}
