//! The models by name.

use crate::thermal::Body;
use plumbline::canopen::Model as _;
use plumbline::fsc::{self, Product, Sensor};
use plumbline::model::jn2101::{Application, Jn2101};
use plumbline::model::{is1, is1d, is1tk, is2, is2d, is2tk};
use plumbline::node::{Boot, Node};
use plumbline::store::{ImageId, Loaded};
use plumbline::time::Instant;

/// What a model speaks.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Protocol {
    /// GEMAC's function select codes.
    Fsc,
    /// CANopen.
    Canopen,
}

/// What the bench needs to know of a model to bring it to life.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    /// The name on the command line and in traces: `is2`.
    pub name: &'static str,
    /// What it speaks.
    pub protocol: Protocol,
    /// The identification of its images in nonvolatile memory.
    pub image: ImageId,
    /// The size of an image's payload in bytes.
    pub payload: usize,
    /// The measuring cell, where the model has a heater for it.
    pub cell: Option<Body>,
    /// Starts a node as after power-up: the time, what nonvolatile memory holds, the serial number.
    pub boot: fn(now: Instant, loaded: Loaded, serial: u32) -> Box<dyn Node>,
}

/// Every model.
pub const MODELS: &[Model] = &[
    model::<is1::OneAxis>("is1", &is1::BP_CL, |now, loaded, serial| {
        Box::new(is1::Is1::new(&is1::BP_CL, now, Boot { loaded, serial }))
    }),
    model::<is2::TwoAxes>("is2", &is2::BP_CL, |now, loaded, serial| {
        Box::new(is2::Is2::new(&is2::BP_CL, now, Boot { loaded, serial }))
    }),
    model::<is1::OneAxis>("is1d", &is1d::PLASTIC, |now, loaded, serial| {
        Box::new(is1d::Is1d::new(
            &is1d::PLASTIC,
            now,
            Boot { loaded, serial },
        ))
    }),
    model::<is2::TwoAxes>("is2d", &is2d::PLASTIC, |now, loaded, serial| {
        Box::new(is2d::Is2d::new(
            &is2d::PLASTIC,
            now,
            Boot { loaded, serial },
        ))
    }),
    heated::<is1tk::OneAxis>("is1tk", &is1tk::METAL, |now, loaded, serial| {
        Box::new(is1tk::Is1tk::new(
            &is1tk::METAL,
            now,
            Boot { loaded, serial },
        ))
    }),
    heated::<is2tk::TwoAxes>("is2tk", &is2tk::METAL, |now, loaded, serial| {
        Box::new(is2tk::Is2tk::new(
            &is2tk::METAL,
            now,
            Boot { loaded, serial },
        ))
    }),
    Model {
        name: "jn2101",
        protocol: Protocol::Canopen,
        image: Application::IMAGE,
        payload: Jn2101::PAYLOAD,
        // Its temperature can be read (4080h): that of the scene is the cell's own.
        cell: None,
        boot: |now, loaded, serial| Box::new(Jn2101::new(now, Boot { loaded, serial })),
    },
];

/// A product of an FSC model.
const fn model<M: fsc::Model>(
    name: &'static str,
    product: &'static Product,
    boot: fn(Instant, Loaded, u32) -> Box<dyn Node>,
) -> Model {
    Model {
        name,
        protocol: Protocol::Fsc,
        image: product.image,
        payload: Sensor::<M>::PAYLOAD,
        cell: None,
        boot,
    }
}

/// A product of an FSC model with a heater: 4 W, which hold 82 degC down to -40 degC with some to spare.
const fn heated<M: fsc::Model>(
    name: &'static str,
    product: &'static Product,
    boot: fn(Instant, Loaded, u32) -> Box<dyn Node>,
) -> Model {
    Model {
        cell: Some(Body {
            rise: 150.0,
            time_constant: 90.0,
        }),
        ..model::<M>(name, product, boot)
    }
}

/// The model of this name.
pub fn find(name: &str) -> Option<&'static Model> {
    MODELS.iter().find(|model| model.name == name)
}
