//! The traffic of the bus in the format of `candump -L`.
//!
//! ```text
//! (1700000000.012345) can0 300#02
//! (1700000000.012700) can0 301#0201000000000000
//! ```

use bench::Logged;
use can_wire::text::log_line;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// The name of the interface in the log.
const INTERFACE: &str = "can0";

/// A file with the frames on the bus, in the format of candump.
#[derive(Debug)]
pub struct Log {
    file: BufWriter<File>,
    /// The time of day at bus time zero, since 1970.
    start: Duration,
}

impl Log {
    /// Creates the file, or empties it. Bus time starts now, until `begin` corrects it.
    pub fn create(path: &Path) -> io::Result<Self> {
        Ok(Self {
            file: BufWriter::new(File::create(path)?),
            start: time_of_day(),
        })
    }

    /// Sets the current bus time: the start of the sensor took simulated time, but almost no real time.
    pub(super) fn begin(&mut self, bus: Duration) {
        self.start = time_of_day().saturating_sub(bus);
    }

    /// Appends lines and flushes them, so that other programs see them at once.
    pub(super) fn write(&mut self, entries: &[Logged]) -> io::Result<()> {
        for entry in entries {
            writeln!(self.file, "{}", line(self.start, entry))?;
        }
        self.file.flush()
    }
}

/// The time since 1970. A clock set before 1970 is invalid; then the log counts from zero.
fn time_of_day() -> Duration {
    SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default()
}

/// One line without its line end.
fn line(start: Duration, entry: &Logged) -> String {
    let at = start + Duration::from_micros(entry.at.ticks());
    log_line(at, INTERFACE, &entry.frame)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bench::{Bus, BusRate, Source};
    use plumbline::can::{Frame, extended, standard};
    use plumbline::time::Instant;

    fn sent_by_a_client(at_us: u64, frame: Option<Frame>) -> String {
        let entry = Logged {
            start: 0,
            at: Instant::from_ticks(at_us),
            frame: frame.unwrap(),
            source: Source::Adapter(Bus::new(BusRate::Follow).adapter()),
        };
        line(Duration::new(1_700_000_000, 999_999_000), &entry)
    }

    #[test]
    fn lines_have_candump_format() {
        assert_eq!(
            sent_by_a_client(2, Frame::data(standard(0x300), &[0xFF, 1])),
            "(1700000001.000001) can0 300#FF01"
        );
        assert_eq!(
            sent_by_a_client(1_000_000, Frame::remote(extended(0x123), 4)),
            "(1700000001.999999) can0 00000123#R4"
        );
        assert_eq!(
            sent_by_a_client(0, Frame::data(standard(0x100), &[])),
            "(1700000000.999999) can0 100#"
        );
    }
}
