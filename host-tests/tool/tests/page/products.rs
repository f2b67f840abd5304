//! A sensor that can be two products: the page asks about each.

use crate::browser::Browser;
use crate::server::Running;
use plumbline::can::{BitRate, Frame};
use plumbline::time::Instant;
use plumbline_tool::adapter::{Adapter, Capabilities, Mode, demo};
use plumbline_tool::failure::Failure;

/// A virtual sensor that does not tell its software version (04h).
struct Hiding(Box<dyn Adapter>);

impl Adapter for Hiding {
    fn capabilities(&self) -> Capabilities {
        self.0.capabilities()
    }

    fn open(&mut self, rate: Option<BitRate>, mode: Mode) -> Result<(), Failure> {
        self.0.open(rate, mode)
    }

    fn close(&mut self) {
        self.0.close();
    }

    fn send(&mut self, frame: &Frame) -> Result<(), Failure> {
        self.0.send(frame)
    }

    fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, Failure> {
        loop {
            let received = self.0.receive(until)?;
            if !matches!(&received, Some((_, frame)) if frame.bytes().first() == Some(&4)) {
                return Ok(received);
            }
        }
    }

    fn now(&self) -> Instant {
        self.0.now()
    }

    fn errors(&mut self) -> Option<u64> {
        self.0.errors()
    }
}

#[test]
fn no_to_the_first_product_leads_to_the_question_about_the_second_one() {
    let opener = Box::new(|_: &str| -> Result<Box<dyn Adapter>, Failure> {
        Ok(Box::new(Hiding(Box::new(demo::adapter("is2")?))))
    });
    let server = Running::with("", opener);
    let Some(browser) = Browser::open(&server.url) else {
        return;
    };
    browser.write("#port", "demo:is2");
    browser.click("#connect");
    let asks = |product: &str| {
        format!(
            "document.getElementById('question').open && document.getElementById('question-text').textContent.endsWith('Is it {product}?')"
        )
    };
    browser.wait(&asks("is2"));
    browser.click("#question-no");
    browser.wait(&asks("is2d"));
    browser.click("#question-yes");
    browser.wait("document.getElementById('found-empty').textContent.includes('is2d')");
}
