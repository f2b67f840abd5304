//! Helpers for tests of FSC nodes.

use super::Tester;
use plumbline::application::Application;
use plumbline::can::{Frame, standard};
use plumbline::fsc::{Article, FscNode, Product};
use plumbline::measure::ONE_G;
use plumbline::model::gemac::is1::{self, OneAxis};
use plumbline::model::gemac::is2::{self, TwoAxes};
use plumbline::node::{Boot, Node};
use plumbline::time::millis;

/// The status byte with factory values: DefaultParam and AutobaudDetection.
pub const DELIVERED: u8 = 0x03;
pub const AUTOBAUD: u8 = 0x02;
pub const CMD_PARAM_ERROR: u8 = 0x08;
pub const EEPROM_ERROR: u8 = 0x04;

/// A node of an FSC product under test.
pub type FscTester<P> = Tester<FscNode<P>>;

/// A 2-axis sensor that has detected the bit rate.
pub fn is2() -> FscTester<TwoAxes> {
    online(&is2::BP_CL)
}

/// A 1-axis sensor at 0 deg that has detected the bit rate.
pub fn is1() -> FscTester<OneAxis> {
    let mut tester = online(&is1::BP_CL);
    tester.rest(0, ONE_G, 0);
    tester
}

/// Powers up a sensor with blank memory. It has not detected the bit rate yet.
pub fn power_up<P: Product<Application: Application>>(article: &'static Article) -> FscTester<P> {
    with_memory(article, Boot::default())
}

/// Powers up a sensor with these contents of the memory.
pub fn with_memory<P: Product>(article: &'static Article, loaded: Boot) -> FscTester<P> {
    let boot = move |now, boot: &Boot| FscNode::<P>::new(article, now, boot);
    let mut tester = Tester::power_up(loaded, boot);
    tester.sample_period = millis(50);
    tester
}

/// A sensor that has detected the bit rate and sent its boot-up messages.
pub fn online<P: Product>(article: &'static Article) -> FscTester<P> {
    let mut tester = power_up(article);
    tester.rest(0, 0, ONE_G);
    tester.receive(Frame::data(standard(0x7FF), &[]).unwrap());
    assert_eq!(tester.sent().len(), 2, "two boot-up messages");
    tester
}

impl<N: Node> Tester<N> {
    /// Hands in samples of this specific force until the filter has settled.
    pub fn rest(&mut self, x: i32, y: i32, z: i32) {
        self.hold([x, y, z], 2000);
    }

    /// Hands in one sample.
    pub fn reading(&mut self, x: i32, y: i32, z: i32, clipped: bool) {
        self.force = [x, y, z];
        self.clipped = clipped;
        self.sample();
        self.clipped = false;
    }

    /// Sends a request on 300h and returns the data of the single reply on 301h.
    pub fn ask(&mut self, request: &[u8]) -> Vec<u8> {
        self.receive(Frame::data(standard(0x300), request).unwrap());
        let sent = self.sent();
        assert_eq!(sent.len(), 1, "{request:02X?} -> {sent:?}");
        assert_eq!(sent[0].id(), standard(0x301));
        sent[0].bytes().to_vec()
    }

    /// Sends a request on 300h that must not be answered.
    pub fn silent(&mut self, request: &[u8]) {
        self.receive(Frame::data(standard(0x300), request).unwrap());
        assert_eq!(self.sent(), []);
    }
}

/// The data bytes of a request.
pub fn request(code: u8, data: &[u8]) -> Vec<u8> {
    [&[code], data].concat()
}
