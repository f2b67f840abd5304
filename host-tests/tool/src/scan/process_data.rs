//! Nodes that a scan knows only by their process data. Their messages do not show the identity of the node, and do not show its address
//! with certainty.
//!
//! | frames of one identifier | node |
//! |---|---|
//! | 00h, status, angles within their range, counter + 1 with each period | GEMAC, cyclic mode (section 9.9.3): the Reply-Parameter-ID |
//! | 3C0h + MAC ID, each after 405h + 8 x MAC ID | DeviceNet, poll: another master owns the slave |
//! | 340h + MAC ID, each before 402h + 8 x MAC ID | DeviceNet, change of state or cyclic with acknowledge |
//! | 340h + MAC ID, if all others are of DeviceNet | DeviceNet, likely |
//! | 181h to 1FFh, 281h, 381h, 481h .., if all others are of CANopen, and one is a sign of it or all have one node-ID | CANopen, likely: the node-ID of the default COB-ID |
//!
//! The data of another device can have the form of cyclic mode, with a counter of its own. Two frames are enough for the Reply-Parameter-ID as
//! delivered, and if no other identifier is on the bus; otherwise five are necessary. Where another protocol is sure, only the
//! Reply-Parameter-ID as delivered counts.

use super::listen::Frames;
use crate::master::fsc::{factory_reply, tables};
use plumbline::can::{CanId, Frame};
use plumbline::devicenet::identifiers::{Group1, MAC_MAX, group_2, group_2_id};
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

/// The node that sends process data.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Node {
    /// A GEMAC sensor in cyclic mode with this Reply-Parameter-ID.
    Cyclic { reply: CanId, axes: usize },
    /// A DeviceNet slave. Without `is_sure` it is likely.
    Slave { mac: u8, is_sure: bool },
    /// Likely a CANopen node, with the identifier of its first TPDO.
    Pdo { node: u8, id: u16 },
}

/// The nodes, each once, in the order of their first frames. `is_other`: the bus has another protocol than GEMAC for sure.
pub(super) fn nodes(frames: &Frames, is_other: bool) -> Vec<Node> {
    let mut ids: Vec<CanId> = Vec::new();
    for (_, frame) in frames {
        if !frame.is_remote() && !ids.contains(&frame.can_id()) {
            ids.push(frame.can_id());
        }
    }
    let all = |is_own: fn(u16) -> bool| {
        let mut frames = frames.iter();
        frames.all(|(_, frame)| frame.can_id().bits() <= 0x7FF && is_own(bits(frame)))
    };
    let is_canopen = all(is_canopen_id) && (frames.iter().any(is_sign) || is_one_node(&ids));
    let is_devicenet = all(is_devicenet_id);
    let is_alone = ids.len() == 1;
    let mut nodes: Vec<Node> = Vec::new();
    for id in ids {
        let of_id = frames.iter().filter(|(_, frame)| frame.can_id() == id);
        let (times, own): (Vec<Instant>, Vec<&Frame>) =
            of_id.map(|(at, frame)| (*at, frame)).unzip();
        let node = cyclic(id, &times, &own, is_alone)
            .filter(|_| !is_other || factory_reply(id).is_some())
            .or_else(|| slave(id, &own, frames, is_devicenet))
            .or_else(|| pdo(id, &own).filter(|_| is_canopen));
        let is_same = |known: &Node| match (known, node) {
            (Node::Pdo { node: known, .. }, Some(Node::Pdo { node, .. })) => *known == node,
            (Node::Slave { mac: known, .. }, Some(Node::Slave { mac, .. })) => *known == mac,
            _ => false,
        };
        if let Some(node) = node
            && !nodes.iter().any(is_same)
        {
            nodes.push(node);
        }
    }
    // A slave that another master polls shows that the bus is one of DeviceNet.
    let is_owned = |node: &Node| matches!(node, Node::Slave { is_sure: true, .. });
    if nodes.iter().any(is_owned) {
        nodes.retain(|node| !matches!(node, Node::Cyclic { .. }));
    }
    nodes
}

/// The 11 bits of an identifier.
fn bits(frame: &Frame) -> u16 {
    (frame.can_id().bits() & 0x7FF) as u16
}

/// Whether CANopen has a message with this identifier.
fn is_canopen_id(id: u16) -> bool {
    match id {
        0x000 | 0x100 | 0x7E4 | 0x7E5 => true,
        0x080..=0x0FF => true,
        0x181..=0x67F | 0x701..=0x77F => id & 0x7F != 0,
        _ => false,
    }
}

/// Whether a frame of 11 bits is one that only CANopen has: NMT, SYNC, heartbeat. Any machine can use the identifiers of PDOs.
fn is_sign((_, frame): &(Instant, Frame)) -> bool {
    match (bits(frame), frame.bytes()) {
        (0x000, [1 | 2 | 0x80..=0x82, node]) => *node <= 127,
        (0x080, [] | [_]) => !frame.is_remote(),
        (0x701..=0x77F, [0x00 | 0x04 | 0x05 | 0x7F]) => true,
        _ => false,
    }
}

/// Whether all these identifiers of 11 bits belong to one node-ID.
fn is_one_node(ids: &[CanId]) -> bool {
    let is_of_node = |id: &&CanId| !matches!(id.bits(), 0x000 | 0x080 | 0x100 | 0x7E4 | 0x7E5);
    let mut nodes = ids.iter().filter(is_of_node).map(|id| id.bits() & 0x7F);
    let first = nodes.next();
    nodes.all(|node| Some(node) == first)
}

/// Whether a slave of DeviceNet or its master has a message with this identifier.
fn is_devicenet_id(id: u16) -> bool {
    id >= Group1::ChangeOrCyclic.id(0)
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

/// A sensor in cyclic mode: all frames have the form, in most frames the counter is one more than in the frame before, and most frames come
/// with a period. A frame can be lost, or be the reply to a request.
fn cyclic(id: CanId, times: &[Instant], frames: &[&Frame], is_alone: bool) -> Option<Node> {
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
    (2 * counted >= frames.len() && is_periodic(times, frames))
        .then_some(Node::Cyclic { reply: id, axes })
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

/// A slave of DeviceNet that sends I/O messages with this identifier.
fn slave(id: CanId, own: &[&Frame], frames: &Frames, is_devicenet: bool) -> Option<Node> {
    let standard = u16::try_from(id.bits()).ok()?;
    let mac = (standard & u16::from(MAC_MAX)) as u8;
    let is_poll = standard == Group1::PollResponse.id(mac);
    if !is_devicenet || !(is_poll || standard == Group1::ChangeOrCyclic.id(mac)) {
        return None;
    }
    // A poll comes before its response. An acknowledge comes after its message.
    let other = match is_poll {
        true => group_2::POLL,
        false => group_2::ACKNOWLEDGE,
    };
    let other = CanId::standard(group_2_id(mac, other));
    let both: Vec<CanId> = frames
        .iter()
        .map(|(_, frame)| frame.can_id())
        .filter(|own| [id, other].contains(own))
        .collect();
    let wanted = if is_poll { [other, id] } else { [id, other] };
    let pairs = both.windows(2).filter(|pair| *pair == wanted).count();
    let is_sure = pairs >= 2;
    let is_likely = !is_poll && is_steady(own);
    (is_sure || is_likely).then_some(Node::Slave { mac, is_sure })
}

/// At least two data frames with the same length.
fn is_steady(frames: &[&Frame]) -> bool {
    let is_same = |frame: &&Frame| !frame.is_remote() && frame.dlc() == frames[0].dlc();
    frames.len() >= 2 && frames.iter().all(is_same)
}

/// A TPDO with its default COB-ID.
fn pdo(id: CanId, frames: &[&Frame]) -> Option<Node> {
    let id = u16::try_from(id.bits()).ok()?;
    let node = (id & 0x7F) as u8;
    let is_tpdo = matches!(id & 0x780, 0x180 | 0x280 | 0x380 | 0x480) && node != 0;
    (is_tpdo && is_steady(frames)).then_some(Node::Pdo { node, id })
}

#[cfg(test)]
mod tests;
