//! The parts of the page that several tests use: the question and the log.

use crate::browser::Browser;

/// The question is shown.
pub const OPEN: &str = "document.getElementById('question').open";

impl Browser {
    /// Waits until the newest action of the log is this one, and is done.
    #[track_caller]
    pub fn done(&self, command: &str) {
        let newest = "document.querySelector('#log-rows li')?.textContent ?? ''";
        self.wait(&format!(
            "({newest}).includes({command:?}) && ({newest}).includes('done')"
        ));
        self.wait("document.getElementById('state').textContent === 'connected'");
    }
}
