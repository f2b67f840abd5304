//! The progress bar of the terminal.

use crate::output::{Bar, Progress};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, stderr};

/// Its form: `[=====>    ]  7/20 listened at 100 kbit/s for 120 ms: 0 frames`.
const FORM: &str = "[{bar:20}] {pos:>2}/{len} {wide_msg}";

/// A progress bar on standard error.
#[derive(Debug, Default)]
pub struct TerminalBar(Option<ProgressBar>);

impl TerminalBar {
    /// The bar of a command; None: standard error is no terminal, or the command prints a document.
    pub fn wanted(json: bool) -> Option<Box<dyn Bar>> {
        let is_wanted = !json && stderr().is_terminal();
        is_wanted.then(|| Box::new(Self::default()) as Box<dyn Bar>)
    }
}

impl Bar for TerminalBar {
    fn show(&mut self, progress: Progress) {
        let bar = self.0.get_or_insert_with(|| {
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
            match ProgressStyle::with_template(FORM) {
                Ok(style) => bar.with_style(style.progress_chars("=> ")),
                Err(_) => bar,
            }
        });
        bar.update(|state| {
            state.set_len(progress.total as u64);
            state.set_pos(progress.done as u64);
        });
        bar.set_message(progress.step.to_string());
    }

    fn hide(&mut self) {
        if let Some(bar) = self.0.take() {
            bar.finish_and_clear();
        }
    }
}
