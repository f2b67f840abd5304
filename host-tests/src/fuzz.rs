//! Feeds a sensor with random input: frames, samples, times, bus events, broken memory, power cuts, flipped bits.
//!
//! A stream of bytes selects the steps, so random numbers and the input of a fuzzer drive the same steps. Every step checks what
//! must always hold: see [`Sensor::step`].

mod canopen;
mod devicenet;
mod ending;
mod fsc;
mod j1939;
mod kind;

pub use kind::KINDS;

use bench::{Flash, NodeType, STORE_BUFFER};
use plumbline::can::BitRate;
use plumbline::heater;
use plumbline::measure::self_test::Working;
use plumbline::measure::{I32x3, Reading};
use plumbline::model::catalog::{Product, Protocol};
use plumbline::node::{Action, BitTime, BusEvent, BusState, Node};
use plumbline::param::{Parameter, Permitted};
use plumbline::store::Store;
use plumbline::time::Instant;

/// The serial number of the sensor.
const SERIAL: u32 = 1;

/// Maximum number of actions that one input causes.
const ACTIONS_MAX: usize = 64;

/// A stream of bytes; zeros after its end.
pub trait Source {
    /// The next byte of the stream.
    fn byte(&mut self) -> u8;

    /// A number of `N` bytes.
    fn number(&mut self) -> u32 {
        u32::from_le_bytes(std::array::from_fn(|_| self.byte()))
    }
}

impl<I: Iterator<Item = u8>> Source for I {
    fn byte(&mut self) -> u8 {
        self.next().unwrap_or(0)
    }
}

fn bytes(source: &mut impl Source) -> Vec<u8> {
    let length = source.byte() % 9;
    (0..length).map(|_| source.byte()).collect()
}

/// A value for this parameter; most of them are permitted.
pub fn value(parameter: &Parameter, source: &mut impl Source) -> u32 {
    let raw = source.number();
    if source.byte() < 32 {
        return raw;
    }
    match parameter.permitted {
        Permitted::Any => raw % 300,
        Permitted::Range(low, high) => (low + i64::from(raw) % (high - low + 1)) as u32,
        Permitted::Named => parameter.meanings[raw as usize % parameter.meanings.len()].0,
        Permitted::OneOf(list) => list[raw as usize % list.len()],
        Permitted::Ranges(ranges) => {
            let (low, high) = ranges.ranges[raw as usize % ranges.ranges.len()];
            let number = low + (raw >> 8) % (high - low + 1);
            // With random values of the ignored bits.
            let ignored = u32::from(ranges.ignored_bits);
            let flags = raw.checked_shr(32 - ignored).unwrap_or(0);
            number | flags.checked_shl(32 - ignored).unwrap_or(0)
        }
    }
}

/// A sensor that receives random input.
pub struct Sensor {
    product: &'static Product,
    node_type: NodeType,
    node: Box<dyn Node>,
    store: Option<Store<Flash, [u8; STORE_BUFFER]>>,
    now: Instant,
    /// The node-ID in the last boot-up message.
    node_id: u8,
    /// In J1939, what the sensor has shown of itself.
    j1939: Option<j1939::Known>,
    /// The parameters of every save that was started. No other parameters may be loaded.
    written: Vec<Vec<u8>>,
    /// The permitted contents of the memory: the parameters of the last confirmed save and of the saves after it. Unknown after a
    /// flipped bit.
    known: Option<Vec<Option<Vec<u8>>>>,
    /// The number of restarts so far.
    pub restarts: u64,
    /// The number of power cuts so far.
    pub power_cuts: u64,
    /// The number of saves so far that the sensor has confirmed.
    pub saves: u64,
    /// The number of frames that the sensor has sent so far.
    pub sent: u64,
    /// Claims sent so far in J1939.
    pub claims: u64,
    /// Frames of connections to one node sent so far in J1939.
    pub packets: u64,
}

impl Sensor {
    /// A sensor with factory values.
    pub fn new(product: &'static Product) -> Self {
        let now = Instant::from_ticks(0);
        let node_type = NodeType::from(product);
        let mut store = Store::open(Flash::default(), node_type.owner(SERIAL));
        Self {
            product,
            node_type,
            node: node_type.start(now, &store.boot()),
            store: Some(store),
            now,
            node_id: devicenet::factory_mac_id(product)
                .unwrap_or_else(|| canopen::factory_node_id(product)),
            j1939: None,
            written: Vec::new(),
            known: Some(vec![None]),
            restarts: 0,
            power_cuts: 0,
            saves: 0,
            sent: 0,
            claims: 0,
            packets: 0,
        }
    }

    /// One step, chosen by `source`.
    ///
    /// # Panics
    /// If the sensor panics, always has another action, sends a frame that its protocol does not permit, or loads parameters
    /// other than those saved last.
    pub fn step(&mut self, source: &mut impl Source) {
        match source.byte() {
            0..=119 => {
                if self.node.ready() {
                    let frame = match &self.product.protocol {
                        Protocol::Canopen(tables) if self.j1939.is_some() => {
                            let known = self.j1939.clone().unwrap_or_default();
                            known.frame(source, tables, self.product)
                        }
                        Protocol::Fsc(tables) => fsc::frame(source, tables, self.product),
                        Protocol::Canopen(tables) => {
                            canopen::frame(source, tables, self.product, self.node_id)
                        }
                        Protocol::Devicenet(tables) => {
                            devicenet::frame(source, tables, self.product, self.node_id)
                        }
                        Protocol::J1939(_) => panic!("J1939 comes with CANopen"),
                    };
                    if let Some(known) = &mut self.j1939 {
                        known.receive(&frame);
                    }
                    self.node.receive(self.now, &frame);
                }
            }
            120..=159 => self.node.sample(self.now, &reading(source)),
            160..=189 => self.pass_time(source),
            190..=201 => {
                let event = match source.byte() % 16 {
                    0 => BusEvent::State(BusState::BusOff),
                    1 => BusEvent::State(BusState::Passive),
                    2 => BusEvent::State(BusState::Warning),
                    3 => BusEvent::Overrun,
                    4..=7 => BusEvent::Error,
                    8..=9 => BusEvent::BitTime(BitTime(source.byte().into())),
                    10 => BusEvent::BitTime(BitTime::of(BitRate::K10)),
                    _ => BusEvent::State(BusState::Active),
                };
                if let (Some(known), BusEvent::State(BusState::BusOff)) = (&mut self.j1939, event) {
                    known.restart();
                }
                self.node.bus(self.now, event);
            }
            202..=239 => {
                for _ in 0..source.byte() % 8 {
                    self.transmit();
                }
            }
            240..=247 => {
                for _ in 0..source.byte() % 64 {
                    self.step_store();
                    self.settle();
                }
            }
            // A report, also if the node has not requested anything.
            248 if source.byte() < 128 => self.node.stored(self.now, Ok(())),
            248 if source.byte() < 64 => self.node.supply(self.now, source.number() as u16),
            248 => {
                let [x, y, z] = [0, 1, 2].map(|bit| source.byte() >> bit & 1 != 0);
                self.node.tested(self.now, Working { x, y, z });
            }
            249 => self.flash(|flash| flash.fail_writes(true)),
            250 => self.flash(|flash| {
                flash.fail_writes(false);
                flash.fail_erases(false);
            }),
            251 => self.flash(|flash| flash.fail_erases(true)),
            252 => {
                let after = u64::from(source.number() % 200);
                self.flash(|flash| flash.cut_in_byte_after(after));
            }
            253 => {
                let seed = u64::from(source.number());
                self.flash(|flash| flash.cut_in_erase_after(0, seed));
            }
            254 => {
                let bit = source.number() as usize % (2048 * 8);
                if source.byte() < 64 {
                    self.flash(|flash| flash.flip_bit(bit).expect("a memory without a file"));
                    self.known = None;
                }
            }
            255 => {
                if source.byte() < 64 {
                    self.power_cut();
                }
            }
        }
        self.settle();
    }

    fn flash(&mut self, change: impl FnOnce(&mut Flash)) {
        if let Some(store) = &mut self.store {
            change(store.memory());
        }
    }

    /// Advances the time by at most an hour, mostly less, often exactly to the deadline.
    fn pass_time(&mut self, source: &mut impl Source) {
        let step = u64::from(source.number() >> (source.byte() % 32));
        let to = match self.node.deadline() {
            Some(deadline) if source.byte() < 128 => deadline.max(self.now),
            _ => Instant::from_ticks(self.now.ticks() + step),
        };
        self.now = to;
    }

    fn transmit(&mut self) {
        let Some(frame) = self.node.transmit(self.now) else {
            return;
        };
        self.node.sent(self.now);
        self.sent += 1;
        if let Some(known) = &mut self.j1939 {
            match known.check(self.now, &frame) {
                j1939::Kind::Claim => self.claims += 1,
                j1939::Kind::Connection => self.packets += 1,
                j1939::Kind::Other => {}
            }
            return;
        }
        match &self.product.protocol {
            Protocol::Fsc(tables) => fsc::check(&frame, tables, self.product.heater.is_some()),
            Protocol::Canopen(tables) => {
                let started = canopen::check(&frame, tables, self.product);
                self.node_id = started.unwrap_or(self.node_id);
            }
            Protocol::Devicenet(tables) => {
                let started = devicenet::check(&frame, tables, self.node_id);
                self.node_id = started.unwrap_or(self.node_id);
            }
            Protocol::J1939(_) => {}
        }
    }

    fn step_store(&mut self) {
        let Some(store) = &mut self.store else { return };
        if let Some(result) = store.step() {
            if result.is_ok() {
                self.saves += 1;
                let newest = self.written.last().cloned();
                self.known = self.known.is_some().then(|| vec![newest]);
            }
            self.node.stored(self.now, result);
        }
        if self
            .store
            .as_mut()
            .is_some_and(|store| store.memory().is_cut())
        {
            self.power_cut();
        }
    }

    /// Switches the power off and on again at any time.
    fn power_cut(&mut self) {
        self.power_cuts += 1;
        self.boot();
    }

    fn boot(&mut self) {
        let Some(store) = self.store.take() else {
            return;
        };
        let mut flash = store.into_memory();
        flash.power_on();
        let mut store = Store::open(flash, self.node_type.owner(SERIAL));
        let boot = store.boot();
        let loaded = boot.parameters.map(<[u8]>::to_vec);
        if let Some(known) = &self.known {
            assert!(known.contains(&loaded), "{loaded:?} instead of {known:?}");
            self.known = Some(vec![loaded.clone()]);
        }
        if let Some(loaded) = &loaded {
            assert!(self.written.contains(loaded), "never saved: {loaded:?}");
        }
        self.node = self.node_type.start(self.now, &boot);
        self.j1939 = None;
        store.prepare();
        self.store = Some(store);
    }

    fn settle(&mut self) {
        for _ in 0..ACTIONS_MAX {
            match self.node.poll(self.now) {
                None => {
                    let deadline = self.node.deadline();
                    assert!(
                        deadline.is_none_or(|at| at > self.now),
                        "{deadline:?} has passed"
                    );
                    let readout = self.node.readout();
                    let possible = match &self.product.protocol {
                        Protocol::Fsc(_) => fsc::is_possible(readout),
                        Protocol::Canopen(tables) => canopen::is_possible(readout, tables),
                        Protocol::Devicenet(_) => devicenet::is_possible(readout),
                        Protocol::J1939(_) => true,
                    };
                    assert!(possible, "{readout:?}");
                    self.find_protocol();
                    return;
                }
                Some(Action::Save) => {
                    let mut image = vec![0; STORE_BUFFER];
                    let length = self
                        .node
                        .image(&mut image)
                        .expect("the buffer is large enough");
                    image.truncate(length);
                    if let Some(store) = &mut self.store {
                        store.save(|buffer| self.node.image(buffer));
                    }
                    if let Some(known) = &mut self.known {
                        known.push(Some(image.clone()));
                    }
                    self.written.push(image);
                }
                Some(Action::Restart) => {
                    self.restarts += 1;
                    self.boot();
                }
                Some(Action::Heater(duty)) => {
                    assert!(self.product.heater.is_some() && duty <= heater::FULL);
                }
                Some(_) => {}
            }
        }
        panic!("the sensor always has another action");
    }
}

fn reading(source: &mut impl Source) -> Reading {
    let mut component = || match source.byte() {
        0..=15 => i32::MIN,
        16..=31 => i32::MAX,
        32..=47 => 0,
        _ => source.number() as i32 >> 2,
    };
    let acceleration = I32x3 {
        x: component(),
        y: component(),
        z: component(),
    };
    let angular_rate = I32x3 {
        x: component(),
        y: component(),
        z: component(),
    };
    let temperature = source.number() as i16;
    Reading {
        acceleration,
        angular_rate,
        temperature,
        clipped: source.byte() < 16,
    }
}
