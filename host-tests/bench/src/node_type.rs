//! The type of a simulated sensor: its node and the owner of the records in its memory.

use crate::thermal::Body;
use plumbline::model::catalog::{self, Product, Settings};
use plumbline::node::{Boot, Node};
use plumbline::store::{ImageId, Owner};
use plumbline::time::{Duration, Instant, millis};

/// The size of the buffer of every simulated store: a record cannot be longer than a page of the Blue Pill.
pub const STORE_BUFFER: usize = 1024;

/// Thermal resistance of a heated measuring cell to its surroundings, in K/mW.
const RESISTANCE: f64 = 0.0375;

/// Time constant of a heated measuring cell, in s.
const TIME_CONSTANT: f64 = 90.0;

/// The time from power-up to the first reading as on a board, without and with a gyroscope: the accelerometer boots and turns on, and
/// the resampler needs some values.
const FIRST_READING: Duration = millis(56);
const FIRST_READING_WITH_RATE: Duration = millis(61);

/// The type of a simulated sensor.
#[derive(Clone, Copy, Debug)]
pub struct NodeType {
    /// The name on the command line and in traces: `is2`.
    pub name: &'static str,
    /// The order number of the article; None: the first one.
    pub article: Option<&'static str>,
    /// Identifies the product in its parameters record.
    pub image: ImageId,
    /// The version of the layout of that record.
    pub layout: u8,
    /// The measuring cell, if the sensor has a heater for it.
    pub cell: Option<Body>,
    /// The time from power-up to its first reading.
    pub first_reading: Duration,
    /// The start of a node of this type.
    pub starts: Starts,
}

/// The way to start a node.
#[derive(Clone, Copy, Debug)]
pub enum Starts {
    /// A product, which has its start in its own table.
    Product(&'static Product),
    /// A function, for a node that is not a product.
    Function(fn(Instant, &Boot) -> Box<dyn Node>),
}

impl NodeType {
    /// The owner of the records in the memory of a unit with this serial number.
    pub const fn owner(&self, serial: u32) -> Owner {
        Owner {
            image: self.image,
            layout: self.layout,
            serial,
        }
    }

    /// The product of the catalogue with this name, if there is one.
    pub fn find(name: &str) -> Option<Self> {
        catalog::find(name).map(Self::from)
    }

    /// The article with this type name or order number, if the product has it.
    pub fn with_article(self, wanted: &str) -> Option<Self> {
        let Starts::Product(product) = self.starts else {
            return None;
        };
        let article = product.articles().find(|article| article.is(wanted))?;
        Some(Self {
            article: Some(article.number),
            ..self
        })
    }

    /// Starts a node of this type.
    ///
    /// # Panics
    /// The product does not have the article.
    pub fn start(&self, now: Instant, boot: &Boot) -> Box<dyn Node> {
        match self.starts {
            Starts::Function(start) => start(now, boot),
            Starts::Product(product) => {
                let settings = Settings {
                    article: self.article,
                    now,
                    boot: *boot,
                };
                product.start(&settings).expect("an article of the product")
            }
        }
    }
}

impl From<&'static Product> for NodeType {
    /// The first article of a product, of the catalogue or of another crate.
    ///
    /// # Panics
    /// Its parameters do not fit into the memory.
    fn from(product: &'static Product) -> Self {
        assert!(
            product.store_buffer <= STORE_BUFFER,
            "the parameters of {} do not fit into a page",
            product.name
        );
        // The scene sets the temperature of the cell where clients can read it.
        let mut quantities = product.quantities.iter();
        let tells_temperature = quantities.any(|quantity| quantity.unit.ends_with("degC"));
        let heater = product.heater.filter(|_| !tells_temperature);
        Self {
            name: product.name,
            article: None,
            image: product.image,
            layout: product.layout,
            cell: heater.map(|heater| Body {
                rise: RESISTANCE * f64::from(heater.full_power),
                time_constant: TIME_CONSTANT,
            }),
            first_reading: if product.has_gyroscope {
                FIRST_READING_WITH_RATE
            } else {
                FIRST_READING
            },
            starts: Starts::Product(product),
        }
    }
}
