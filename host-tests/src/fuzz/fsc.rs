//! Frames for an FSC sensor, and the check of the frames that it sends.
//!
//! Most frames are requests of the product's codes, mostly with permitted values.

use super::{Source, value};
use plumbline::application::Faults;
use plumbline::can::{Frame, extended, standard};
use plumbline::fsc::Condition;
use plumbline::fsc::table::Access;
use plumbline::model::catalog::Product;
use plumbline::model::listing::fsc::Tables;
use plumbline::node::Readout;

/// A frame: mostly a request, mostly with a valid code.
pub fn frame(source: &mut impl Source, tables: &Tables, product: &Product) -> Frame {
    let factory = |id: plumbline::param::ParameterId| {
        standard(product.parameters[usize::from(id.0)].factory as u16)
    };
    let raw = source.number();
    let id = match source.byte() {
        0..=199 => factory(tables.roles.set_id),
        200..=229 => factory(tables.roles.sync_id),
        230..=242 => standard(raw as u16),
        _ => extended(raw),
    };
    let data = data(source, tables, product);
    let frame = if source.byte() < 8 {
        Frame::remote(id, data.len())
    } else {
        Frame::data(id, &data)
    };
    frame.expect("at most eight bytes")
}

fn data(source: &mut impl Source, tables: &Tables, product: &Product) -> Vec<u8> {
    let access = &tables.access[usize::from(source.byte()) % tables.access.len()];
    match source.byte() {
        0..=99 => write(source, access, product),
        100..=129 => vec![access.read],
        // A function, mostly with its signature.
        130..=169 => {
            let function = &tables.functions[usize::from(source.byte()) % tables.functions.len()];
            let signature = function.signature;
            let signature = if source.byte() < 200 { signature } else { &[] };
            [&[function.code], signature].concat()
        }
        // The factory Set-Parameter-ID, to which most requests are sent.
        170..=179 => {
            let set_id = tables
                .access
                .iter()
                .find(|access| access.parameters == [tables.roles.set_id]);
            let factory = product.parameters[usize::from(tables.roles.set_id.0)].factory;
            let code = set_id.map_or(0, |access| access.write);
            [&[code][..], &factory.to_le_bytes()].concat()
        }
        _ => {
            let length = source.byte() % 9;
            (0..length).map(|_| source.byte()).collect()
        }
    }
}

/// A write, mostly of permitted values.
fn write(source: &mut impl Source, access: &Access, product: &Product) -> Vec<u8> {
    let mut data = vec![access.write];
    for id in access.parameters {
        let parameter = &product.parameters[usize::from(id.0)];
        let bytes = value(parameter, source).to_le_bytes();
        data.extend(bytes.iter().take(parameter.data_type.size().into()));
    }
    // Sometimes too short or too long.
    match source.byte() {
        0..=9 => data.truncate(usize::from(source.byte()) % data.len()),
        10..=14 => data.push(source.byte()),
        _ => {}
    }
    data.truncate(8);
    data
}

/// Checks a frame that the sensor sent. `heated`: the product has a heater.
///
/// # Panics
/// If an FSC sensor never sends such a frame.
pub fn check(frame: &Frame, tables: &Tables, heated: bool) {
    assert!(!frame.is_remote(), "{frame:?}");
    let [_, status, ..] = *frame.bytes() else {
        panic!("a reply has a code and a status: {frame:?}");
    };
    for (bit, row) in tables.status.iter().enumerate() {
        let never = match row.condition {
            Condition::Never => true,
            Condition::Fault(faults) => faults == Faults::WARM_UP && !heated,
            _ => false,
        };
        assert!(
            !never || status >> bit & 1 == 0,
            "bit {bit} {}: {frame:?}",
            row.name
        );
    }
}

/// Whether the angles are within the range of the sensor.
pub fn is_possible(readout: Readout) -> bool {
    let within = readout.y.is_none_or(|y| (-9000..=9000).contains(&y));
    (-9000..36_000).contains(&readout.x) && within
}
