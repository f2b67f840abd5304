//! How a scan recognises GEMAC sensors.
//!
//! | frames | sensor |
//! |---|---|
//! | any identifier, `FF ss id id id id vv vv` twice | boot-up message: the Set-Parameter-ID; sure exactly twice at once, or alone on the bus |
//! | 00h, status, angles within their range, counter + 1 with each period | cyclic mode (section 9.9.3): the Reply-Parameter-ID |
//!
//! The data of another device can have the form of cyclic mode, with a counter of its own. Two frames are enough for the Reply-Parameter-ID as
//! delivered, and if no other identifier is on the bus; otherwise five are necessary. Where another protocol is sure, only the
//! Reply-Parameter-ID as delivered counts.

use super::boot_up::{BootUps, boot_up};
use super::{PROTOCOL, factory_reply, tables};
use crate::master::Target;
use crate::master::fsc::request::Sensor;
use crate::number::shown;
use crate::scan::row::{By, Heard};
use crate::scan::signs::{Bus, Judge, Shown, Signs};
use plumbline::can::{CanId, Frame};
use plumbline::fsc::Condition;
use plumbline::fsc::table::{Function, Operation, Source};
use plumbline::j1939::identifier::Identifier;
use plumbline::model::catalog::{PRODUCTS, Product};
use plumbline::param::number;
use plumbline::time::{Duration, Instant, millis};

/// The bytes of the counter of cyclic mode.
const COUNTER: usize = 2;

/// The frames of cyclic mode with an identifier that another device can have.
const MANY: usize = 5;

/// The maximum delay of a frame after its period, in addition to a quarter of the period: adapters and computers collect frames.
const LATE: Duration = millis(50);

/// The first group of J1939 that is sent to all nodes, without its data page.
const BROADCAST: u32 = 0xF000;

pub(super) const SIGNS: Signs = Signs {
    node: |frame| boot_up(frame).map(|sensor| Target::Fsc(sensor).into()),
    // Other devices send frames of this form.
    is_own: false,
    judge,
    process_data,
    twins: None,
};

fn judge<'a>(bus: &'a Bus) -> Judge<'a> {
    let boot_ups = BootUps::of(bus.frames);
    Box::new(move |seen| match seen.sign.target {
        // One frame can be anything.
        Target::Fsc(sensor) if seen.times.len() >= 2 => Some(boot_ups.is_sure(sensor)),
        _ => None,
    })
}

/// The sensors in cyclic mode.
fn process_data(bus: &Bus) -> Vec<Shown> {
    let is_alone = bus.ids.len() == 1;
    let is_other = bus.is_other(&PROTOCOL);
    let all = bus.ids.iter().filter_map(|id| {
        let request = factory_reply(*id);
        let (times, frames) = bus.with(*id);
        let axes =
            cyclic(*id, &times, &frames, is_alone).filter(|_| !is_other || request.is_some())?;
        let kind = if axes == 1 { "angle" } else { "angles" };
        let by = By::Cyclic {
            reply: *id,
            request,
        };
        let heard = Heard {
            protocol: PROTOCOL.name,
            address: None,
            serial: None,
            text: Some(format!("GEMAC, {axes} {kind} at {}", shown(*id))),
            by,
        };
        let sensor = |request| Sensor {
            request,
            reply: Some(*id),
        };
        let target = request.map(|request| Target::Fsc(sensor(request)));
        Some(Shown {
            id: *id,
            heard,
            target,
        })
    });
    all.collect()
}

/// The reply with the angles of a product, and the product.
fn inclination(product: &'static Product) -> Option<(&'static Function, &'static Product)> {
    let mut functions = tables(product)?.functions.iter();
    let function = functions.find(|function| function.operation == Operation::Inclination)?;
    Some((function, product))
}

/// Whether only bits are set in a status byte that a product has.
fn is_status(status: u8, product: &Product) -> bool {
    let Some(tables) = tables(product) else {
        return false;
    };
    let mut bits = tables.status.iter().enumerate();
    bits.all(|(place, bit)| status >> place & 1 == 0 || bit.condition != Condition::Never)
}

/// The angles of a frame in cyclic mode, as many as a product has. Every angle must be within its range.
fn axes(frame: &Frame, function: &Function, product: &Product) -> Option<usize> {
    let [code, status, data @ ..] = frame.bytes() else {
        return None;
    };
    if !is_status(*status, product) {
        return None;
    }
    let (mut place, mut axes) = (0, 0);
    for field in function.reply {
        let data_type = field
            .source
            .data_type(product.parameters, product.quantities);
        let size = usize::from(data_type.size());
        let bytes = data.get(place..place + size)?;
        place += size;
        if let Source::Value(id) = field.source {
            let quantity = product.quantities.get(usize::from(id.0))?;
            let (low, high) = quantity.range;
            if !(low..=high).contains(&data_type.value(number(bytes))) {
                return None;
            }
            axes += 1;
        }
    }
    (*code == function.code && place == data.len()).then_some(axes)
}

/// The counter of a frame in cyclic mode.
fn counter(frame: &Frame) -> u16 {
    let from = frame.bytes().len().saturating_sub(COUNTER);
    number(frame.bytes().get(from..).unwrap_or_default()) as u16
}

/// The number of angles of a sensor in cyclic mode: all frames have the form, in most frames the counter is one more than in the frame before, and most frames come
/// with a period. A frame can be lost, or be the reply to a request.
fn cyclic(id: CanId, times: &[Instant], frames: &[&Frame], is_alone: bool) -> Option<usize> {
    let is_broadcast =
        |frame: &Frame| Identifier::of(frame).is_some_and(|id| id.pgn & 0xFFFF >= BROADCAST);
    let first = frames.first().filter(|frame| !frame.is_remote())?;
    let is_own = factory_reply(id).is_some() || (is_alone && !is_broadcast(first));
    let least = if is_own { 2 } else { MANY };
    if frames.len() < least || frames.iter().any(|frame| frame.is_remote()) {
        return None;
    }
    let axes = PRODUCTS
        .iter()
        .filter_map(inclination)
        .find_map(|(function, product)| {
            let axes = axes(first, function, product)?;
            let mut others = frames.iter();
            others
                .all(|frame| axes_are(frame, function, product, axes))
                .then_some(axes)
        })?;
    let pairs = frames.windows(2);
    let steps = pairs.map(|pair| counter(pair[1]).wrapping_sub(counter(pair[0])));
    let counted = steps.filter(|step| *step == 1).count();
    (2 * counted >= frames.len() && is_periodic(times, frames)).then_some(axes)
}

/// Whether three of four frames come when their counter says it. Of several frames with the same counter only the first one counts, because
/// the others are replies to requests.
fn is_periodic(times: &[Instant], frames: &[&Frame]) -> bool {
    let mut counted: Vec<(u64, u64)> = times
        .iter()
        .zip(frames)
        .map(|(at, frame)| {
            let periods = counter(frame).wrapping_sub(counter(frames[0]));
            let passed = at.ticks().saturating_sub(times[0].ticks());
            (u64::from(periods), passed)
        })
        .collect();
    counted.dedup_by_key(|(periods, _)| *periods);
    let Some(&(periods @ 1.., passed)) = counted.last() else {
        return false;
    };
    let period = passed / periods;
    let most = period / 4 + LATE.ticks();
    let on_time = counted.iter();
    let on_time = on_time.filter(|(place, passed)| (place * period).abs_diff(*passed) <= most);
    4 * on_time.count() >= 3 * counted.len()
}

fn axes_are(frame: &Frame, function: &Function, product: &Product, wanted: usize) -> bool {
    axes(frame, function, product) == Some(wanted)
}
