//! The messages of the scenario for a product with J1939 only, made from its tables: requests for its groups and for the messages that each
//! node has. A write is a command of the maker, which the tables do not have.

use super::{Filter, Message, Protocol, leak};
use bench::BusRate;
use plumbline::j1939::identifier::{
    ACTIVE_CODES, ADDRESS_CLAIMED, ECU_IDENTIFICATION, Pgn, SOFTWARE_IDENTIFICATION,
};
use plumbline::model::catalog::Product;
use plumbline::model::listing::j1939::Tables;
use plumbline::time::millis;

/// The groups that each node has: its claim, trouble codes, software and ECU identification.
const COMMON: [Pgn; 4] = [
    ADDRESS_CLAIMED,
    ACTIVE_CODES,
    SOFTWARE_IDENTIFICATION,
    ECU_IDENTIFICATION,
];

/// The messages for a product.
pub(super) fn messages(product: &Product, tables: &Tables) -> &'static Protocol {
    let tables = &tables.j1939;
    let address = product.parameters[usize::from(tables.address.0)].factory;
    let request = |pgn: Pgn| {
        let [low, middle, high, _] = pgn.to_le_bytes();
        let id = 0x18EA_0021 | (address & 0xFF) << 8;
        Message(id, vec![low, middle, high].leak())
    };
    let groups = || tables.groups.iter().map(|group| group.pgn);
    let first = groups().next().unwrap_or(ADDRESS_CLAIMED);
    // A message of more than eight bytes begins with one frame, and has no other without a CTS.
    let others = groups().chain(COMMON).map(request).collect::<Vec<_>>();
    let filter = Filter {
        settings: &[],
        load: "load_off",
    };
    leak(Protocol {
        modules: &["plumbline::j1939::"],
        bus: BusRate::Follow,
        preparation: &[],
        boot_up: 1,
        begin: &[],
        // Until the address is its own.
        online: millis(300),
        connection: &[],
        emergency: None,
        read: request(first),
        write: request(first),
        read_code: 0,
        sync: request(first),
        sync_code: 0,
        filters: vec![filter].leak(),
        slowest_filter: None,
        others: others.leak(),
        services: &[],
        j1939: None,
        cyclic: &[],
        not_cyclic: &[],
        set_up: &[],
        saves: &[],
        saves_later: millis(0),
        load: &[],
        restart: &[],
    })
}
