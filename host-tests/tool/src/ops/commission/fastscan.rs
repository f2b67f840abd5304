//! Finds the next sensor by the fastscan of layer setting services (CiA 305). Sensors with equal node-IDs lose them for that, and those that
//! are done get theirs again.

use super::plan::{Item, Plan};
use super::state::{Row, State};
use super::{PAUSE, at, chosen};
use crate::error::{Error, SensorError, Silence};
use crate::identify::{self, Found};
use crate::link::Link;
use crate::master::canopen::lss;
use crate::master::{Target, factory_target};
use plumbline::time::{Duration, after, millis};

/// The longest time until a node has started with its new node-ID.
const START: Duration = millis(4000);

/// The longest time until the frame that ends configuration mode is sent.
const RELEASE: Duration = millis(50);

/// Waits for a sensor of the plan, and gives it its node-ID. After a failure no node stays in configuration mode.
pub(super) fn next<'a>(
    link: &mut Link,
    plan: &Plan,
    waiting: &[&'a Item],
    state: &mut State,
    wait: Duration,
) -> Result<(&'a Item, Found), Error> {
    let result = scan(link, plan, waiting, state, wait);
    if result.is_err() {
        let was_ending = link.set_ending(true);
        // The adapter can have failed. The frame must leave it before it is closed.
        let released = lss::release(link);
        let _ = released.and_then(|()| link.wait_for(RELEASE, |_| None::<()>));
        link.set_ending(was_ending);
    }
    result
}

fn scan<'a>(
    link: &mut Link,
    plan: &Plan,
    waiting: &[&'a Item],
    state: &mut State,
    wait: Duration,
) -> Result<(&'a Item, Found), Error> {
    let [first, ..] = waiting else {
        return Err(Silence::Request.into());
    };
    let (rate, delivered) = (link.rate(), factory_target(first.product()));
    let until = after(link.now(), wait);
    loop {
        // One whose commissioning was interrupted has its node-ID already, and perhaps its bit rate.
        for item in waiting {
            let serial = state.row(&item.name).and_then(|row| row.serial);
            let (Some(serial), Some(target)) = (serial, item.target()) else {
                continue;
            };
            let mut rates = vec![rate, item.rate().or(rate)];
            rates.dedup();
            for rate in rates {
                at(link, rate)?;
                if let Some(found) = identify::ask(link, target, identify::PATIENT)?
                    && found.serial == Some(serial)
                {
                    return Ok((item, found));
                }
            }
        }
        at(link, rate)?;
        if let Some(target) = delivered
            && identify::ask(link, target, identify::PATIENT)?.is_some()
        {
            lss::unaddress(link)?;
        }
        let Some([vendor, code, _, serial]) = lss::find(link)? else {
            // A node that fastscan has begun to select must not stay in configuration mode.
            lss::release(link)?;
            if link.now() >= until {
                let seconds = wait.ticks() / 1_000_000;
                return Err(Silence::Next(first.name.clone(), seconds).into());
            }
            link.wait_for(PAUSE, |_| None::<()>)?;
            continue;
        };
        let mut done = plan.sensors.iter();
        let done = done.find(|item| {
            let row = state.row(&item.name);
            row.is_some_and(|row| row.done && row.serial == Some(serial))
        });
        let item = chosen(waiting, state, Some(serial));
        let own = done.or(item).and_then(Item::target);
        let Some((node, target)) = own.and_then(|own| Some((own.node_id()?, own))) else {
            let sensor = format!("vendor {vendor:X}h, product code {code:X}h, serial {serial}");
            return Err(SensorError::NotInPlan(sensor).into());
        };
        if target.is_used(link)? {
            return Err(SensorError::AddressInUse(target.named()).into());
        }
        if let (None, Some(item)) = (done, item) {
            state.keep(Row::begun(item, Some(serial), target))?;
        }
        lss::address(link, node)?;
        let found = started(link, target)?;
        if let (None, Some(item)) = (done, item) {
            return Ok((item, found));
        }
    }
}

/// The node when it has started.
fn started(link: &mut Link, target: Target) -> Result<Found, Error> {
    let until = after(link.now(), START);
    loop {
        if let Some(found) = identify::ask(link, target, identify::PATIENT)? {
            return Ok(found);
        }
        if link.now() >= until {
            return Err(Silence::Moved(target.named()).into());
        }
    }
}
