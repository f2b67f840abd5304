//! The kinds of sensors: the products of the catalogue, and a product with both CANopen and J1939 in J1939.

use super::{Sensor, j1939};
use plumbline::can::{Frame, standard};
use plumbline::model::catalog::{PRODUCTS, Product, Protocol};

/// The number of kinds of sensors for [`Sensor::of_kind`].
pub const KINDS: usize = PRODUCTS.len() + 1;

impl Sensor {
    /// A product of the catalogue, or the IMS360 in J1939.
    pub fn of_kind(kind: usize) -> Self {
        match PRODUCTS.get(kind % KINDS) {
            Some(product) => Self::new(product),
            None => {
                let mut sensors = PRODUCTS.iter().filter_map(Self::in_j1939);
                sensors.next().expect("a product with J1939")
            }
        }
    }

    /// A sensor with both protocols, in J1939; None if the product has CANopen only.
    pub fn in_j1939(product: &'static Product) -> Option<Self> {
        let Protocol::Canopen(tables) = &product.protocol else {
            return None;
        };
        tables.j1939?;
        let mut sensor = Self::new(product);
        sensor.measure();
        for request in [
            [0x2F, 0x00, 0x31, 1, 1, 0, 0, 0],
            [0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e'],
        ] {
            let id = standard(0x600 + u16::from(sensor.node_id));
            let frame = Frame::data(id, &request).expect("8 bytes");
            sensor.node.receive(sensor.now, &frame);
            sensor.settle();
        }
        while sensor.saves == 0 {
            sensor.step_store();
        }
        sensor.boot();
        sensor.measure();
        assert!(sensor.j1939.is_some(), "J1939 is stored");
        Some(sensor)
    }

    /// The first reading: the node goes on the bus.
    fn measure(&mut self) {
        self.node.sample(self.now, &bench::script::LEVEL);
        self.settle();
    }

    /// A change of the protocol, after a restart.
    pub(super) fn find_protocol(&mut self) {
        if !matches!(&self.product.protocol, Protocol::Canopen(tables) if tables.j1939.is_some()) {
            return;
        }
        match (j1939::is_in_force(&*self.node), &self.j1939) {
            (true, None) => self.j1939 = Some(j1939::Known::default()),
            (false, Some(_)) => self.j1939 = None,
            _ => {}
        }
    }
}
