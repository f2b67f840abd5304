//! Which product answers.

use super::{is_stopped, tables};
use crate::error::Error;
use crate::identify::{Found, PATIENT, TRIES, exchange, text_of};
use crate::link::Link;
use crate::master::canopen::sdo::{Answer, Server};
use crate::master::{Node, Target};
use plumbline::can::CanId;
use plumbline::canopen::cob_id::SDO_REPLY;
use plumbline::canopen::dictionary::Target as ObjectTarget;
use plumbline::model::catalog::{PRODUCTS, Product};
use plumbline::model::listing::canopen::Tables;
use plumbline::param::number;
use plumbline::time::Duration;

/// What a bootloader without a running program has as its firmware.
const BOOTLOADER: &str = "bootloader";

/// The identity object.
const IDENTITY: u16 = 0x1018;

/// The node by its identity object.
pub(super) fn ask(link: &mut Link, node: u8, time: Duration) -> Result<Option<Found>, Error> {
    const VERSION: u16 = 0x100A;
    let question = Server {
        time,
        ..Server::of(node)
    };
    let device_type = question.read(link, 0x1000, 0)?;
    if device_type == Answer::Silent {
        return Ok(None);
    }
    let mut read = |index, sub| {
        let mut answer = Answer::Silent;
        for _ in 0..TRIES {
            answer = Server::of(node).read(link, index, sub)?;
            if answer != Answer::Silent {
                break;
            }
        }
        Ok::<_, Error>(answer)
    };
    let mut identity = [None; 5];
    for sub in [1, 2, 4] {
        if let Answer::Done(bytes) = read(IDENTITY, sub)?
            && bytes.len() == 4
        {
            identity[usize::from(sub)] = Some(number(&bytes));
        }
    }
    let firmware = match read(VERSION, 0)? {
        Answer::Done(text) => text_of(&text),
        // A bootloader has no profile, and the program is stopped.
        _ if device_type == Answer::Done(vec![0; 4]) && is_stopped(link, Server::of(node))? => {
            Some(BOOTLOADER.to_owned())
        }
        _ => None,
    };
    let constant = |tables: &Tables, sub: u8| {
        let mut objects = tables.objects.iter();
        let object = objects.find(|object| (object.index, object.sub) == (IDENTITY, sub))?;
        match object.target {
            ObjectTarget::Constant(number) => Some(number),
            _ => None,
        }
    };
    let products: Vec<&Product> = PRODUCTS
        .iter()
        .filter(|product| {
            tables(product).is_some_and(|tables| {
                [1, 2].into_iter().all(|sub| {
                    let own = constant(tables, sub);
                    own.is_some() && own == identity[usize::from(sub)]
                })
            })
        })
        .collect();
    let mut articles = products
        .first()
        .into_iter()
        .flat_map(|product| product.articles());
    Ok(Some(Found {
        article: articles
            .next()
            .map(|article| article.number.to_owned())
            .or_else(|| {
                let (vendor, code) = (identity[1]?, identity[2]?);
                Some(format!("vendor {vendor:X}h, product code {code:X}h"))
            }),
        products,
        serial: identity[4],
        firmware,
        ..Found::at(Target::Canopen(Node(node)))
    }))
}

/// The serial numbers of other nodes with the same node-ID. Their replies come directly behind, or destroy each other for some time.
pub(crate) fn others(link: &mut Link, node: u8, own: Option<u32>) -> Result<Vec<u32>, Error> {
    let header = [0x43, 0x18, 0x10, 0x04];
    let mut all: Vec<u32> = own.into_iter().collect();
    for _ in 0..TRIES {
        let first = Server::of(node).read(link, IDENTITY, 4)?;
        let mut take = |serial: u32| {
            if !all.contains(&serial) {
                all.push(serial);
            }
        };
        if let Answer::Done(bytes) = first
            && bytes.len() == 4
        {
            take(number(&bytes));
        }
        link.wait_for(exchange(link, PATIENT), |frame| {
            if let [a, b, c, d, serial @ ..] = frame.bytes()
                && frame.can_id() == CanId::standard(SDO_REPLY + u16::from(node))
                && [*a, *b, *c, *d] == header
            {
                take(number(serial));
            }
            None::<()>
        })?;
    }
    all.retain(|serial| Some(*serial) != own);
    Ok(all)
}
