//! Which product a sensor is. If the article and the software version of the sensor leave a doubt, the tool asks.

use super::Wanted;
use crate::error::Error;
use crate::identify::Found;
use crate::master::Protocol;
use crate::output::Terminal;
use crate::question::{Name, Question};
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
    let message = format!(
        "{} speaks {}, but the sensor speaks {}: give another --product",
        wanted.name,
        Protocol::of(wanted).name,
        found.protocol()
    );
    Err(Error::usage("wrong-product", message))
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
        version: found.firmware.clone(),
        product: name.to_owned(),
    };
    if terminal.ask(&question)? {
        return Ok(());
    }
    let message = format!(
        "the sensor says that it is {own}, not {name}: leave out --product, or use --yes for the tables of {name}"
    );
    Err(Error::usage("wrong-product", message))
}

/// The product that the sensor tells. If several fit, the user is asked about each one; `--yes` does not answer that.
fn told(found: &Found, terminal: &mut Terminal) -> Result<&'static Product, Error> {
    let (article, names) = (article(found), names(found));
    match &found.products[..] {
        [only] => Ok(only),
        [] if found.is_owned => Err(Error::refused(
            "owned",
            format!(
                "another master owns the sensor with {}, so the product is unknown: stop that master, or listen with --cyclic --product NAME",
                found.target.named()
            ),
        )),
        [] => Err(Error::usage(
            "unknown-product",
            format!(
                "the article {article} is not in the catalogue: say what it is like with --product NAME, or give its data sheet with --eds FILE"
            ),
        )),
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
            let message = format!(
                "the article {article} fits several products ({names}): choose one with --product NAME"
            );
            Err(Error::usage("ambiguous-product", message))
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
