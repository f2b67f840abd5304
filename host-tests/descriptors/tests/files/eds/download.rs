//! Configuration tools: they download the settings of the data sheet in the order of the indices, the TPDOs as CiA 301 wants it (7.5.2.37):
//! off, number 0, the rest, the number, on.

use super::sdo::{Client, IMS360, IMS360_ONE_AXIS, JN2101, Subject};
use super::sheet::{Address, Sheet, Variable, number};
use super::{SHEETS, flagged, sheet_of};
use std::collections::BTreeMap;

/// A configuration: the values of the objects that are downloaded.
type State = BTreeMap<Address, i64>;

/// Bit 31 of a COB-ID: off.
const OFF: i64 = 1 << 31;
/// Bit 30 of the COB-ID of a TPDO: no remote frames.
const NO_RTR: i64 = 1 << 30;

/// A generator of pseudorandom numbers (xorshift64).
struct Random(u64);

impl Random {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % limit
    }

    fn in_range(&mut self, low: i64, high: i64) -> i64 {
        // The limits are as probable as all between them.
        match self.below(4) {
            0 => low,
            1 => high,
            _ => low + self.below((high - low + 1) as u64) as i64,
        }
    }

    fn one<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len() as u64) as usize]
    }
}

/// A data sheet, and the settings that a tool downloads.
struct Tool {
    subject: Subject,
    settings: Vec<Variable>,
    /// The comment with the permitted values of a section.
    permitted: BTreeMap<String, String>,
    mappable: Vec<i64>,
}

impl Tool {
    fn new((name, subject): (&str, Subject)) -> Self {
        let text = sheet_of(name, subject);
        let sheet = Sheet::parse(&text);
        let excluded = flagged(&text);
        let variables = sheet.variables();
        let mappable = variables.iter().filter(|one| one.mappable).map(|one| {
            let (index, sub) = one.address;
            i64::from(index) << 16 | i64::from(sub) << 8 | i64::from(one.data_type.bits())
        });
        let lines: Vec<_> = text.lines().collect();
        let permitted = lines.windows(2).filter_map(|pair| {
            let values = pair[0].strip_prefix("; values: ")?;
            let section = pair[1].strip_prefix('[')?.strip_suffix(']')?;
            Some((section.to_owned(), values.to_owned()))
        });
        Self {
            subject,
            permitted: permitted.collect(),
            mappable: mappable.collect(),
            settings: variables
                .into_iter()
                .filter(|one| one.access == "rw" && !excluded.contains(&one.address))
                .collect(),
        }
    }

    fn variable(&self, address: Address) -> &Variable {
        let mut settings = self.settings.iter();
        settings
            .find(|one| one.address == address)
            .expect("a setting")
    }

    /// A random permitted configuration.
    ///
    /// The COB-IDs of the JN2101 follow the node-ID. An identifier of the present node-ID can be that of the SYNC if the one after the
    /// reset, `coming`, is another.
    fn random(&self, random: &mut Random, [present, coming]: [u8; 2]) -> State {
        let left = [0x080, 0x180, 0x280].map(|base| base + i64::from(present));
        let mut state = State::new();
        for one in &self.settings {
            let value = match one.address.0 {
                0x1A00..0x1C00 => continue,
                0x1005 if present != coming && random.below(2) == 0 => random.one(&left),
                0x1005 => random.one(&[0x80, 0xFF, 0x1FF, 0x45A, 0x580, 0x6DF]),
                0x1014 => random.one(&[0xB2, 0x8000_00B2, 0x0C5, 0x2000_0001, 0x3FFF_FFFF]),
                0x1800..0x1A00 if one.address.1 == 1 => self.random_cob_id(random, one, present),
                _ => self.random_value(random, one),
            };
            state.insert(one.address, value);
        }
        for number in 0..4 {
            if self
                .settings
                .iter()
                .any(|one| one.address == (0x1A00 + number, 0))
            {
                self.map(random, 0x1A00 + number, &mut state);
            }
        }
        // What the manual does not permit together (7.2.38 of the IMS360).
        if state.get(&(0x3110, 1)) == Some(&2) {
            let cut_off = state.get_mut(&(0x3111, 0)).expect("the frequency");
            *cut_off = (*cut_off).min(8_000);
        }
        state
    }

    fn random_cob_id(&self, random: &mut Random, one: &Variable, present: u8) -> i64 {
        let own = one.default_at(present.into()).expect("a default") & 0x7FF;
        let flags = random.one(&[0, 0, OFF, NO_RTR, OFF | NO_RTR]);
        if self.subject.product == "jn2101" {
            return flags | own;
        }
        flags | random.one(&[own, 0x181, 0x1B2, 0x2B2, 0x580, 0x6DF])
    }

    /// A value within the limits and the comment of the data sheet.
    fn random_value(&self, random: &mut Random, one: &Variable) -> i64 {
        let [lowest, highest] = one.data_type.limits();
        let (mut low, mut high) = (one.low.unwrap_or(lowest), one.high.unwrap_or(highest));
        if let Some(text) = self.permitted.get(&one.section) {
            let parts: Vec<_> = text.split([',', ';']).map(str::trim).collect();
            let part = random.one(&parts);
            let part = part.split('=').next().unwrap_or(part).trim();
            if let Some((first, last)) = part.split_once("..") {
                (low, high) = (number(first).expect(text), number(last).expect(text));
            } else {
                return number(part).expect(text);
            }
        }
        random.in_range(low, high)
    }

    /// A random mapping: entries that fit into a frame, then entries of any kind that are not counted.
    fn map(&self, random: &mut Random, index: u16, state: &mut State) {
        let (mut bits, mut count) = (0, 0);
        let most = random.below(9) as i64;
        for sub in 1..=8 {
            let entry = random.one(&self.mappable);
            let is_counted =
                count == i64::from(sub) - 1 && count < most && bits + (entry & 0xFF) <= 64;
            if is_counted {
                bits += entry & 0xFF;
                count += 1;
            }
            let entry = if is_counted || random.below(2) == 0 {
                entry
            } else {
                0
            };
            state.insert((index, sub), entry);
        }
        state.insert((index, 0), count);
    }

    /// The writes of a tool. `off` is the COB-ID with which it switches a TPDO off that has this one.
    fn download(&self, target: &State, off: impl Fn(i64) -> i64) -> Vec<(Address, i64)> {
        let is_pdo = |index: u16| (0x1800..0x1C00).contains(&index);
        let others = |behind: bool| {
            let settings = target
                .iter()
                .filter(move |((index, _), _)| !is_pdo(*index) && (*index > 0x1BFF) == behind);
            settings.map(|(address, value)| (*address, *value))
        };
        let mut writes: Vec<_> = others(false).collect();
        for number in 0..4 {
            let (communication, mapping) = (0x1800 + number, 0x1A00 + number);
            let Some(&cob_id) = target.get(&(communication, 1)) else {
                continue;
            };
            writes.push(((communication, 1), off(cob_id)));
            let rest = |index: u16, first: u8| {
                target
                    .range((index, first)..=(index, 255))
                    .map(|(address, value)| (*address, *value))
            };
            writes.extend(rest(communication, 2));
            if let Some(&count) = target.get(&(mapping, 0)) {
                writes.push(((mapping, 0), 0));
                writes.extend(rest(mapping, 1));
                writes.push(((mapping, 0), count));
            }
            writes.push(((communication, 1), cob_id));
        }
        writes.extend(others(true));
        writes
    }

    fn write(&self, client: &mut Client, writes: &[(Address, i64)]) {
        for &(address, value) in writes {
            let data = self.variable(address).data_type.bytes(value);
            assert_eq!(
                client.write(address, &data),
                Ok(()),
                "{address:X?} = {value:X}h"
            );
        }
    }

    fn assert_reads(&self, client: &mut Client, state: &State) {
        for (address, value) in state {
            let data = self.variable(*address).data_type.bytes(*value);
            assert_eq!(client.read(*address), Ok(data), "{address:X?} = {value:X}h");
        }
    }
}

/// "save", reset node, after which it has this node-ID.
fn store_and_restart(client: &mut Client, coming: u8) {
    assert_eq!(client.write((0x1010, 1), b"save"), Ok(()));
    client.send(0x000, &[0x81, client.node_id]);
    client.node_id = coming;
    client.wait(200);
}

#[test]
fn any_configuration_follows_any_other_in_the_order_of_configuration_tools() {
    let steps = host_tests::effort::choose(12, 300);
    for sheet in SHEETS {
        let tool = Tool::new(sheet);
        let mut random = Random(0x9E37_79B9_7F4A_7C15);
        let mut client = Client::new(tool.subject);
        let is_fixed = tool.subject.product == "jn2101";
        for step in 0..steps {
            // A tool gives the sensor its node-ID first; it acts after the reset.
            let coming = random.one(&[client.node_id, 1, 10, 50, 126]);
            let node_id = if is_fixed { 0x2000 } else { 0x2002 };
            assert_eq!(client.write((node_id, 0), &[coming]), Ok(()));
            let target = tool.random(&mut random, [client.node_id, coming]);
            // The identifier of the target, or none: CODESYS, python-canopen, and masters that write 8000_0000h.
            let without = !is_fixed && step % 3 == 0;
            let off = |cob_id: i64| if without { OFF } else { cob_id | OFF };
            tool.write(&mut client, &tool.download(&target, off));
            tool.assert_reads(&mut client, &target);
            store_and_restart(&mut client, coming);
        }
    }
}

/// `tool.save()` twice, or a tool that downloads at each start: the second download changes nothing.
#[test]
fn configuration_that_is_downloaded_again_is_accepted_in_operational() {
    for sheet in SHEETS {
        let tool = Tool::new(sheet);
        let mut client = Client::new(tool.subject);
        let target = tool.random(&mut Random(7), [client.node_id; 2]);
        let writes = tool.download(&target, |cob_id| cob_id | OFF);
        tool.write(&mut client, &writes);
        client.send(0x000, &[0x01, 0]);
        tool.write(&mut client, &writes);
        tool.assert_reads(&mut client, &target);
    }
}

/// Writes each default value of the data sheet in the order of the indices, flagged or not.
#[test]
fn default_values_leave_node_id_and_bit_rate() {
    for (name, subject, moved) in [
        (
            "jn2101.eds",
            JN2101,
            [((0x2000, 0), &[20][..]), ((0x2001, 0), &[250, 0])],
        ),
        (
            "ims360.eds",
            IMS360,
            [((0x2002, 0), &[20]), ((0x2001, 0), &[0x90, 0xD0, 3, 0])],
        ),
        (
            "ims360_1axis.eds",
            IMS360_ONE_AXIS,
            [((0x2002, 0), &[20]), ((0x2001, 0), &[0x90, 0xD0, 3, 0])],
        ),
    ] {
        let tool = Tool::new((name, subject));
        let mut client = Client::new(subject);
        for (address, data) in moved {
            assert_eq!(client.write(address, data), Ok(()));
        }
        let defaults = tool
            .settings
            .iter()
            .filter_map(|one| Some((one.address, one.default_at(subject.node_id.into())?)));
        let target: State = defaults.collect();
        let sheet = Sheet::parse(&sheet_of(name, subject));
        for one in sheet.variables() {
            let has_default = one.access == "rw" && one.default.is_some();
            assert_eq!(
                has_default,
                target.contains_key(&one.address),
                "{}",
                one.section
            );
        }
        tool.write(&mut client, &tool.download(&target, |cob_id| cob_id | OFF));
        for (address, data) in moved {
            assert_eq!(client.read(address).as_deref(), Ok(data), "{name}");
        }
    }
}
