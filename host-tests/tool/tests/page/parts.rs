//! The parts of the page that several tests use: the question and the log.

use crate::browser::Browser;

/// The question is shown.
pub const OPEN: &str = "document.getElementById('question').open";

/// The text of the newest action of the log.
const NEWEST: &str = "(document.querySelector('#log-rows li')?.textContent ?? '')";

impl Browser {
    /// Waits until the newest action of the log is this one, and is done.
    #[track_caller]
    pub fn done(&self, command: &str) {
        self.wait(&format!(
            "{NEWEST}.includes({command:?}) && {NEWEST}.includes('done')"
        ));
        self.wait("document.getElementById('state').textContent === 'connected'");
    }

    /// Connects to a sensor in real time, which answers too late if the machine is busy: up to three times.
    #[track_caller]
    pub fn connect(&self) {
        const ACTIONS: &str = "document.querySelectorAll('#log-rows li').length";
        for _ in 0..3 {
            let earlier = self.value(ACTIONS);
            self.click("#connect");
            self.wait(&format!(
                "{ACTIONS} > {earlier} && !{NEWEST}.includes('running')"
            ));
            if self.value(&format!("{NEWEST}.includes('done')")) == true {
                break;
            }
        }
        self.done("watch");
    }
}
