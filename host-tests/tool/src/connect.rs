//! From the options of the command line to a session with one sensor: bit rate, address, product.

use crate::adapter::{Adapter, Mode};
use crate::client::Link;
use crate::client::devicenet::Slave;
use crate::client::fsc::Sensor;
use crate::failure::Failure;
use crate::identify::{self, Found, protocol_of};
use crate::number::identifier;
use crate::session::{Session, Target};
use plumbline::can::{BitRate, CanId};
use plumbline::model::catalog::{PRODUCTS, Product, Protocol};
use plumbline::param::ParameterId;
use plumbline::time::{Duration, after, millis};

/// The order in which unknown rates are tried: the common ones first.
pub const RATES: [BitRate; 10] = [
    BitRate::K250,
    BitRate::K125,
    BitRate::K500,
    BitRate::M1,
    BitRate::K100,
    BitRate::K50,
    BitRate::K20,
    BitRate::K800,
    BitRate::K62_5,
    BitRate::K10,
];

/// How long a rate is listened to. A lone CANopen node repeats its boot-up message all the time.
const DWELL: Duration = millis(120);

/// How long a sensor that must be there is asked: one that has just been switched on makes its duplicate MAC ID check first.
const PATIENCE: Duration = millis(3000);

/// Where the sensor is, as far as the user says.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// The bit rate.
    pub rate: Option<BitRate>,
    /// The address.
    pub target: Option<Target>,
    /// The product.
    pub product: Option<&'static Product>,
}

/// The address of the options `--id`, `--node` and `--mac`.
///
/// # Errors
/// More than one is given, or one is out of its range.
pub fn target(
    id: Option<&str>,
    node: Option<u8>,
    mac: Option<u8>,
) -> Result<Option<Target>, Failure> {
    match (id, node, mac) {
        (None, None, None) => Ok(None),
        (Some(id), None, None) => {
            let bits = identifier(id)
                .map_err(|text| Failure::usage("bad-value", format!("--id {id}: {text}")))?;
            let request = CanId::from_bits(bits);
            Ok(Some(Target::Fsc(Sensor {
                request,
                reply: None,
            })))
        }
        (None, Some(node @ 1..=127), None) => Ok(Some(Target::Canopen(node))),
        (None, None, Some(mac @ 0..=63)) => Ok(Some(Target::Devicenet(Slave { mac }))),
        (None, Some(_), None) => Err(Failure::usage("out-of-range", "a node-ID is 1 to 127")),
        (None, None, Some(_)) => Err(Failure::usage("out-of-range", "a MAC ID is 0 to 63")),
        _ => Err(Failure::usage(
            "too-many-addresses",
            "give one of --id (GEMAC), --node (CANopen) and --mac (DeviceNet)",
        )),
    }
}

/// Opens the adapter and finds the sensor; it is asked only with reads.
///
/// Without a rate, the tool listens at all rates first. On a bus with traffic it asks only at the rate of the traffic.
///
/// # Errors
/// Nobody answers, or those of the adapter.
pub fn find(adapter: Box<dyn Adapter>, wanted: &Wanted) -> Result<(Link, Found), Failure> {
    let mut link = Link::new(adapter);
    let capabilities = link.adapter().capabilities();
    let mut heard = false;
    let rates: Vec<Option<BitRate>> = match wanted.rate {
        Some(rate) => vec![Some(rate)],
        None if !capabilities.needs_rate => vec![None],
        None => match talking(&mut link)? {
            Some(rate) => {
                heard = true;
                vec![Some(rate)]
            }
            None => RATES.iter().copied().map(Some).collect(),
        },
    };
    let targets = match (wanted.target, wanted.product) {
        (Some(target), _) => vec![target],
        (None, Some(product)) => vec![factory_target(product)],
        (None, None) => factory_targets(),
    };
    for rate in &rates {
        link.open(*rate, Mode::Active)?;
        let is_expected =
            rates.len() == 1 && (wanted.target.is_some() || wanted.product.is_some() || heard);
        let until = after(link.now(), if is_expected { PATIENCE } else { millis(0) });
        loop {
            for target in &targets {
                // A sensor that detects the bit rate needs a frame before it answers.
                for _ in 0..2 {
                    let found = identify::ask(&mut link, *target)?;
                    if let Some(found) = found.filter(|found| is_wanted(found, wanted)) {
                        return Ok((link, found));
                    }
                }
            }
            for sensor in link.take_booted() {
                let found = identify::ask(&mut link, Target::Fsc(sensor))?;
                if let Some(found) = found.filter(|found| is_wanted(found, wanted)) {
                    return Ok((link, found));
                }
            }
            if link.now() >= until {
                break;
            }
        }
        link.adapter().close();
    }
    let addresses: Vec<String> = targets.iter().map(described).collect();
    let rates = match rates[..] {
        [Some(rate)] => format!(" at {}", rate.name()),
        [None] => String::new(),
        _ => " at any bit rate".to_owned(),
    };
    Err(Failure::silent(
        "no-answer",
        format!(
            "nobody answers at {}{rates}: check power and wiring, or find the sensor with `plumbline scan`",
            addresses.join(", ")
        ),
    ))
}

/// The address of a product as delivered.
pub fn factory_target(product: &Product) -> Target {
    let factory = |id: ParameterId| product.parameters[usize::from(id.0)].factory;
    match &product.protocol {
        Protocol::Fsc(tables) => Target::Fsc(Sensor {
            request: CanId::from_bits(factory(tables.roles.set_id)),
            reply: None,
        }),
        Protocol::Canopen(tables) => Target::Canopen(factory(tables.node_id) as u8),
        Protocol::Devicenet(tables) => Target::Devicenet(Slave {
            mac: factory(tables.roles.mac_id) as u8,
        }),
    }
}

/// The addresses of all products as delivered, each once.
pub fn factory_targets() -> Vec<Target> {
    let mut targets = Vec::new();
    for product in PRODUCTS {
        let target = factory_target(product);
        if !targets.contains(&target) {
            targets.push(target);
        }
    }
    targets
}

/// Whether a sensor is the one of the user. A boot-up message can be that of another sensor.
fn is_wanted(found: &Found, wanted: &Wanted) -> bool {
    match (found.target, wanted.target) {
        (Target::Fsc(found), Some(Target::Fsc(wanted))) => found.request == wanted.request,
        (Target::Fsc(_), Some(_)) => false,
        (_, Some(_)) => true,
        (_, None) => wanted
            .product
            .is_none_or(|product| protocol_of(product) == found.protocol()),
    }
}

fn described(target: &Target) -> String {
    match target {
        Target::Fsc(_) => format!("identifier {}h", target.address()),
        Target::Canopen(node) => format!("node-ID {node}"),
        Target::Devicenet(slave) => format!("MAC ID {}", slave.mac),
    }
}

/// The rate at which somebody talks; the tool only listens.
///
/// # Errors
/// The adapter has no listen-only mode, or has failed.
pub fn talking(link: &mut Link) -> Result<Option<BitRate>, Failure> {
    for rate in RATES {
        if let Err(failure) = link.open(Some(rate), Mode::Listen) {
            if failure.code == "no-listen-only" {
                let message = "the adapter has no listen-only mode: give the bit rate with --rate";
                return Err(Failure::bus("no-listen-only", message));
            }
            // An adapter does not have every rate.
            continue;
        }
        let until = after(link.now(), DWELL);
        if link.receive(until)?.is_some() {
            link.adapter().close();
            return Ok(Some(rate));
        }
        link.adapter().close();
    }
    Ok(None)
}

/// A session with the sensor.
///
/// # Errors
/// Nobody answers, the product is not known, or those of the adapter.
pub fn session(adapter: Box<dyn Adapter>, wanted: &Wanted) -> Result<(Session, Found), Failure> {
    let (link, found) = find(adapter, wanted)?;
    let product = found.decide(wanted.product)?;
    Ok((Session::new(link, found.target, product), found))
}
