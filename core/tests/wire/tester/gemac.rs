//! The GEMAC products as their manuals describe them, and a sensor under test with the state that it must have.
//!
//! Section and table numbers refer to the English manual of 2021, G1 to G30 to the decisions in `core/src/model/gemac/README.md`.

use super::Tester;
use super::fsc::*;
use plumbline::can::{CanId, Frame, standard};
use plumbline::fsc::{Article, FscNode, Product};
use plumbline::measure::ONE_G;
use plumbline::model::gemac::{is1, is1d, is1dm, is1tk, is2, is2d, is2dm, is2tk};
use plumbline::node::Action;

/// Bit 31 of a stored identifier: 29-bit format (table 23).
pub const EXTENDED: u32 = 1 << 31;

/// A device parameter: its codes, size, factory value (tables 17 to 19), and values at its limits and beyond them (9.10).
pub struct Parameter {
    /// The code that reads it. The code that writes it is higher by 10h.
    pub read: u8,
    size: usize,
    pub factory: u32,
    pub accepted: &'static [u32],
    pub refused: &'static [u32],
}

impl Parameter {
    /// A value as it is sent: low byte first.
    pub fn bytes(&self, value: u32) -> Vec<u8> {
        value.to_le_bytes()[..self.size].to_vec()
    }

    /// The request that writes a value.
    pub fn write(&self, value: u32) -> Vec<u8> {
        request(self.read + 0x10, &self.bytes(value))
    }
}

/// The places of the parameters in [`Sheet::parameters`].
pub const IDENTIFIERS: [usize; 3] = [0, 1, 2];
pub const BAUD_RATE: usize = 3;
pub const BUS_OFF_RECOVERY: usize = 4;
pub const CYCLIC_TIME: usize = 5;
pub const CYCLIC_MODE: usize = 6;
pub const ZERO_X: usize = 8;

/// The cut-off frequency in mHz and the filter type: 0 off, 1 Butterworth, 2 critically damped (9.10.5).
pub const fn filter(cut_off: u32, filter_type: u32) -> u32 {
    cut_off | filter_type << 16
}

const fn signed(value: i16) -> u32 {
    value as u16 as u32
}

const fn identifier(read: u8, factory: u32) -> Parameter {
    Parameter {
        read,
        size: 4,
        factory,
        // Table 23 and its example.
        accepted: &[0, 0x7FF, 0x361, EXTENDED | 0x361, EXTENDED, 0x9FFF_FFFF],
        // The bits between the identifier and bit 31 must be 0 (G15).
        refused: &[
            0x800,
            0xFFFF,
            0x1_0361,
            0x1000_0361,
            0x2000_0361,
            0x4000_0361,
            0x7FFF_FFFF,
            0xA000_0361,
            0xC000_0361,
            0xFFFF_FFFF,
        ],
    }
}

/// The highest cut-off frequencies: 25 Hz, and 8 Hz of the critically damped filter (table 11), also while the filter is off (G16).
const FILTERS: (&[u32], &[u32]) = (
    &[
        filter(100, 0),
        filter(25_000, 0),
        filter(100, 1),
        filter(101, 1),
        filter(24_999, 1),
        filter(25_000, 1),
        filter(100, 2),
        filter(7999, 2),
        filter(8000, 2),
        filter(2001, 2),
        filter(2000, 1),
        filter(2000, 0),
    ],
    &[
        filter(0, 0),
        filter(99, 0),
        filter(25_001, 0),
        filter(65_535, 0),
        filter(0, 1),
        filter(99, 1),
        filter(25_001, 1),
        filter(65_535, 1),
        filter(0, 2),
        filter(99, 2),
        filter(8001, 2),
        filter(25_000, 2),
        filter(65_535, 2),
        filter(2000, 3),
        filter(2000, 255),
    ],
);

const fn row(
    read: u8,
    size: usize,
    factory: u32,
    accepted: &'static [u32],
    refused: &'static [u32],
) -> Parameter {
    Parameter {
        read,
        size,
        factory,
        accepted,
        refused,
    }
}

/// The parameters of every product. The baud rates have the codes 0 to 10 (9.10.3), Automatic Bus-Off Recovery has 0 and 1 (G2).
const COMMON: [Parameter; 8] = [
    identifier(0x10, 0x300),
    identifier(0x11, 0x301),
    identifier(0x12, 0x100),
    row(
        0x13,
        1,
        0,
        &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10],
        &[11, 12, 128, 255],
    ),
    row(0x14, 1, 0, &[1], &[2, 128, 255]),
    row(0x15, 2, 250, &[1, 2, 255, 256, 65_534, 65_535], &[0]),
    row(0x16, 1, 0, &[1], &[2, 128, 255]),
    row(0x17, 3, filter(2000, 2), FILTERS.0, FILTERS.1),
];

const fn signed_offset(read: u8) -> Parameter {
    let accepted = const {
        &[
            signed(-9000),
            signed(-8999),
            signed(-1),
            1,
            0x00FF,
            8999,
            9000,
        ]
    };
    let refused = const { &[signed(-32_768), signed(-9001), 9001, 32_767] };
    row(read, 2, 0, accepted, refused)
}

static ONE_AXIS: [Parameter; 9] = {
    let [a, b, c, d, e, f, g, h] = COMMON;
    let offset = row(
        0x18,
        2,
        0,
        &[1, 18_000, 35_998, 35_999],
        &[36_000, 36_001, 65_535],
    );
    [a, b, c, d, e, f, g, h, offset]
};

static TWO_AXES: [Parameter; 10] = {
    let [a, b, c, d, e, f, g, h] = COMMON;
    let (x, y) = (signed_offset(0x18), signed_offset(0x19));
    [a, b, c, d, e, f, g, h, x, y]
};

/// A product in its manual.
pub struct Sheet {
    pub article: &'static Article,
    /// The digits of the order number (G20).
    pub product_number: u32,
    /// Hexadecimal digits on the types of 2021, a number on the older types (G5).
    pub version: [u8; 2],
    /// With AccuracyWarning, which is set for some time after power-up (9.3, G6).
    pub heated: bool,
    pub parameters: &'static [Parameter],
}

const V3_44: [u8; 2] = [0x44, 0x03];
const V1_03: [u8; 2] = [103, 0];

const fn sheet(
    article: &'static Article,
    product_number: u32,
    version: [u8; 2],
    heated: bool,
    parameters: &'static [Parameter],
) -> Sheet {
    Sheet {
        article,
        product_number,
        version,
        heated,
        parameters,
    }
}

pub static IS1: Sheet = sheet(&is1::BP_CL, 2_305_030, V3_44, false, &ONE_AXIS);
pub static IS2: Sheet = sheet(&is2::BP_CL, 2_305_430, V3_44, false, &TWO_AXES);
pub static IS1D: Sheet = sheet(&is1d::PLASTIC, 2_305_030, V1_03, false, &ONE_AXIS);
pub static IS2D: Sheet = sheet(&is2d::PLASTIC, 2_305_430, V1_03, false, &TWO_AXES);
pub static IS1DM: Sheet = sheet(&is1dm::METAL, 2_302_030, V1_03, true, &ONE_AXIS);
pub static IS2DM: Sheet = sheet(&is2dm::METAL, 2_302_430, V1_03, true, &TWO_AXES);
pub static IS1TK: Sheet = sheet(&is1tk::METAL, 2_302_030, V3_44, true, &ONE_AXIS);
pub static IS2TK: Sheet = sheet(&is2tk::METAL, 2_302_430, V3_44, true, &TWO_AXES);

/// Calls `check` with the sheet of each product.
macro_rules! each_product {
    ($check:ident) => {{
        use plumbline::model::gemac::is1::OneAxis;
        use plumbline::model::gemac::is1tk::OneAxisHeated;
        use plumbline::model::gemac::is2::TwoAxes;
        use plumbline::model::gemac::is2tk::TwoAxesHeated;
        use $crate::tester::gemac;
        $check::<OneAxis>(&gemac::IS1);
        $check::<TwoAxes>(&gemac::IS2);
        $check::<OneAxis>(&gemac::IS1D);
        $check::<TwoAxes>(&gemac::IS2D);
        $check::<OneAxisHeated>(&gemac::IS1DM);
        $check::<TwoAxesHeated>(&gemac::IS2DM);
        $check::<OneAxisHeated>(&gemac::IS1TK);
        $check::<TwoAxesHeated>(&gemac::IS2TK);
    }};
}
pub(crate) use each_product;

impl Sheet {
    pub fn axes(&self) -> usize {
        self.parameters.len() - ZERO_X
    }

    /// The specific force at which all angles are 0.
    fn level(&self) -> [i32; 3] {
        match self.axes() {
            1 => [0, ONE_G, 0],
            _ => [0, 0, ONE_G],
        }
    }

    /// Whether the product has this function select code (tables 17 and 18, G1).
    pub fn has(&self, code: u8) -> bool {
        let parameter =
            |parameter: &Parameter| [0, 0x10].contains(&code.wrapping_sub(parameter.read));
        [0x00, 0x02, 0x03, 0x04, 0x40, 0x50, 0xFF].contains(&code)
            || self.parameters.iter().any(parameter)
    }

    /// A level sensor on a silent bus.
    pub fn power_up<P: Product>(&'static self) -> Unit<P> {
        let mut tester = power_up(self.article);
        tester.force = self.level();
        tester.power_cycle();
        let values: Vec<u32> = self.parameters.iter().map(|row| row.factory).collect();
        let mut unit = Unit {
            tester,
            sheet: self,
            values,
            errors: 0,
            in_force: [0; 3],
        };
        unit.restarted();
        unit
    }

    /// A level sensor that has detected the bit rate.
    pub fn online<P: Product>(&'static self) -> Unit<P> {
        let mut unit = self.power_up();
        unit.wake();
        unit
    }
}

/// A sensor under test and the state that it must have.
pub struct Unit<P: Product> {
    pub tester: Tester<FscNode<P>>,
    pub sheet: &'static Sheet,
    /// The values of the parameters.
    pub values: Vec<u32>,
    /// The sticky bits of the status byte.
    pub errors: u8,
    /// The identifiers in force since the last restart (9.10.2).
    in_force: [u32; 3],
}

impl<P: Product> Unit<P> {
    /// The status byte (9.5.2).
    pub fn status(&self) -> u8 {
        let factory = self.sheet.parameters.iter().map(|row| row.factory);
        let default_param = u8::from(self.values.iter().copied().eq(factory));
        let autobaud = u8::from(self.values[BAUD_RATE] == 0) << 1;
        let warning = u8::from(self.sheet.heated) << 6;
        self.errors | default_param | autobaud | warning
    }

    /// The alive message, with the Set-Parameter-ID in force (table 16, G22).
    pub fn alive(&self) -> Vec<u8> {
        let set_id = self.in_force[0].to_le_bytes();
        [&[0xFF, self.status()], &set_id[..], &self.sheet.version].concat()
    }

    /// The reply that reads a parameter.
    pub fn reading(&self, place: usize) -> Vec<u8> {
        let row = &self.sheet.parameters[place];
        [vec![row.read, self.status()], row.bytes(self.values[place])].concat()
    }

    /// The inclination of the level sensor without offset, with the counter in cyclic mode.
    pub fn inclination(&self, counter: Option<u16>) -> Vec<u8> {
        let mut reply = vec![0x00, self.status()];
        reply.resize(2 + 2 * self.sheet.axes(), 0);
        reply.extend(counter.iter().flat_map(|counter| counter.to_le_bytes()));
        reply
    }

    /// A frame on the identifier in force: 0 Set-Parameter-ID, 1 Reply-Parameter-ID, 2 Sync-ID.
    pub fn frame(&self, identifier: usize, data: &[u8]) -> Frame {
        Frame::data(CanId::from_bits(self.in_force[identifier]).into(), data).unwrap()
    }

    /// The written identifiers are in force after a restart.
    fn restarted(&mut self) {
        self.in_force.copy_from_slice(&self.values[..3]);
        self.errors = 0;
    }

    /// Sends a frame that the sensor does not use. The sensor detects the bit rate and sends two boot-up messages (9.6).
    pub fn wake(&mut self) {
        assert_eq!(self.tester.sent(), []);
        self.tester
            .receive(Frame::data(standard(0x7FE), &[]).unwrap());
        self.boots();
    }

    /// The sensor sends two boot-up messages and nothing else.
    #[track_caller]
    pub fn boots(&mut self) {
        let boot_up = self.frame(1, &self.alive());
        assert_eq!(self.tester.sent(), [boot_up; 2]);
    }

    /// Switches the power off and on. `values` are those of the memory.
    pub fn power_cycle(&mut self, values: &[u32]) {
        self.values = values.to_vec();
        self.tester.power_cycle();
        self.restarted();
    }

    /// The sensor answers the request with this reply and nothing else.
    #[track_caller]
    pub fn ask(&mut self, request: &[u8], reply: &[u8]) {
        self.tester.receive(self.frame(0, request));
        let reply = self.frame(1, reply);
        assert_eq!(self.tester.sent(), [reply], "{request:02X?}");
    }

    /// The sensor acknowledges the request with code and status.
    #[track_caller]
    pub fn acknowledges(&mut self, request: &[u8]) {
        self.ask(request, &[request[0], self.status()]);
    }

    /// 02h shows the sticky errors and clears them (G17).
    #[track_caller]
    pub fn clears_errors(&mut self) {
        self.acknowledges(&[0x02]);
        self.errors = 0;
        self.acknowledges(&[0x02]);
    }

    /// The sensor accepts the value, and reads follow at once.
    #[track_caller]
    pub fn accepts(&mut self, place: usize, value: u32) {
        self.values[place] = value;
        self.acknowledges(&self.sheet.parameters[place].write(value));
        let reading = self.reading(place);
        self.ask(&reading[..1], &reading);
    }

    /// All parameters have their values.
    #[track_caller]
    pub fn keeps_values(&mut self) {
        for place in 0..self.values.len() {
            let reading = self.reading(place);
            self.ask(&reading[..1], &reading);
        }
    }

    /// The sensor refuses the request (G9): code and status with CmdParamError. Nothing changes.
    #[track_caller]
    pub fn refuses(&mut self, request: &[u8]) {
        self.tester.actions.clear();
        self.errors |= CMD_PARAM_ERROR;
        self.acknowledges(request);
        self.keeps_values();
        self.clears_errors();
        let acts = |action: &Action| matches!(action, Action::Save | Action::Restart);
        assert!(!self.tester.actions.iter().any(acts), "{request:02X?}");
    }

    /// The sensor ignores the frame: no reply and no error.
    #[track_caller]
    pub fn ignores(&mut self, frame: Frame) {
        self.tester.receive(frame);
        assert_eq!(self.tester.sent(), [], "{frame:?}");
        self.acknowledges(&[0x02]);
    }

    /// SAVE, answered when the memory holds the parameters.
    #[track_caller]
    pub fn saves(&mut self) {
        self.acknowledges(b"\x50SAVE");
    }

    /// LOAD: the factory values.
    #[track_caller]
    pub fn loads(&mut self) {
        self.values = self
            .sheet
            .parameters
            .iter()
            .map(|row| row.factory)
            .collect();
        self.acknowledges(b"\x40LOAD");
    }
}
