//! Which product a sensor is. If the article and the software version of the sensor leave a doubt, the tool asks.

use super::Wanted;
use crate::failure::Failure;
use crate::identify::{Found, protocol_of, speaks};
use crate::output::Terminal;
use plumbline::model::catalog::Product;

/// The product for a session.
///
/// # Errors
/// Several products fit or none does, the wanted one has another protocol, or a question was answered with no.
pub(super) fn decide(
    found: &Found,
    wanted: &Wanted,
    terminal: &mut Terminal,
) -> Result<&'static Product, Failure> {
    match wanted.product {
        Some(product) => {
            permitted(found, product)?;
            if wanted.sheet.is_none() {
                confirmed(found, product, terminal)?;
            }
            Ok(product)
        }
        None => told(found, wanted.all_yes, terminal),
    }
}

/// Refuses a product of another protocol.
fn permitted(found: &Found, wanted: &Product) -> Result<(), Failure> {
    if speaks(wanted, found.protocol()) {
        return Ok(());
    }
    let message = format!(
        "{} speaks {}, but the sensor speaks {}: give another --product",
        wanted.name,
        protocol_of(wanted),
        found.protocol()
    );
    Err(Failure::usage("wrong-product", message))
}

/// Asks about a product that does not fit the sensor.
fn confirmed(
    found: &Found,
    wanted: &'static Product,
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let fits = |own: &&Product| own.name == wanted.name;
    if found.products.is_empty() || found.products.iter().any(fits) {
        return Ok(());
    }
    let (own, name) = (names(found), wanted.name);
    let version = match &found.firmware {
        Some(version) => format!(", software version {version}"),
        None => String::new(),
    };
    let question = format!(
        "The sensor says that it is {own} (article {}{version}). Use the tables of {name} anyway?",
        article(found)
    );
    if (terminal.confirm)(&question) {
        return Ok(());
    }
    let message = format!(
        "the sensor says that it is {own}, not {name}: leave out --product, or use --yes for the tables of {name}"
    );
    Err(Failure::usage("wrong-product", message))
}

/// The product that the sensor tells. If several fit, the user is asked about each one; `all_yes` cannot answer that.
fn told(
    found: &Found,
    all_yes: bool,
    terminal: &mut Terminal,
) -> Result<&'static Product, Failure> {
    let (article, names) = (article(found), names(found));
    match &found.products[..] {
        [only] => Ok(only),
        [] if found.is_owned => Err(Failure::refused(
            "owned",
            format!(
                "another master owns the sensor with {}, so the product is unknown: stop that master, or listen with --cyclic --product NAME",
                found.target.named()
            ),
        )),
        [] => Err(Failure::usage(
            "unknown-product",
            format!(
                "the article {article} is not in the catalogue: say what it is like with --product NAME, or give its data sheet with --eds FILE"
            ),
        )),
        several => {
            let mut several = several.iter().filter(|_| !all_yes);
            let chosen = several.find(|product| {
                let question = format!(
                    "The sensor has the article {article}, which fits several products ({names}), and does not report its software version. Is it {}?",
                    product.name
                );
                (terminal.confirm)(&question)
            });
            chosen.copied().ok_or_else(|| {
                let message =
                    format!("the article {article} fits several products ({names}): choose one with --product NAME");
                Failure::usage("ambiguous-product", message)
            })
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
