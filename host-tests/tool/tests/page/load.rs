//! Samples at a high rate: none is lost on the way to the page, and they need no more memory with time. The time of the processor is
//! printed, and never tested: it depends on the machine.

use crate::browser::Browser;
use serde_json::json;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// The longest time for the samples of a minute, on a busy machine.
const PATIENCE: Duration = Duration::from_secs(600);

/// The readings of the memory of the page.
const READINGS: usize = 5;

/// How many minutes are measured. The readings of one minute can differ by more than the permitted growth, but a leak increases the memory
/// in every minute.
const MINUTES: usize = 3;

/// The growth of a memory at which the test fails, in percent.
const GROWTH: f64 = 5.0;

/// The program as a process, so that its time and memory can be measured.
struct Program {
    child: Child,
    url: String,
    /// The names of sensors.
    _config: TempDir,
}

impl Program {
    fn start(options: &[&str]) -> Self {
        let config = tempfile::tempdir().expect("a folder");
        let mut child = Command::new(env!("CARGO_BIN_EXE_plumbline"))
            .arg("--config")
            .arg(config.path())
            .args(["serve", "--demo", "--listen", "127.0.0.1:0"])
            .args(options)
            .env_remove("PLUMBLINE_PORT")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program starts");
        let mut url = String::new();
        let mut output = BufReader::new(child.stdout.take().expect("its output"));
        output.read_line(&mut url).expect("its address");
        Self {
            child,
            url: url.trim().to_owned(),
            _config: config,
        }
    }

    /// The memory in KiB (VmRSS); 0 on systems without /proc, with which the test fails.
    fn memory(&self) -> f64 {
        let path = format!("/proc/{}/status", self.child.id());
        let text = std::fs::read_to_string(path).unwrap_or_default();
        let mut lines = text.lines();
        let line = lines.find_map(|line| line.strip_prefix("VmRSS:"));
        let number = line.and_then(|line| line.trim().split(' ').next()?.parse().ok());
        number.unwrap_or(0.0)
    }

    /// User plus system time in s; a tick is 10 ms.
    fn time(&self) -> f64 {
        let path = format!("/proc/{}/stat", self.child.id());
        let text = std::fs::read_to_string(path).unwrap_or_default();
        let fields: Vec<&str> = text
            .rsplit(')')
            .next()
            .unwrap_or_default()
            .split_whitespace()
            .collect();
        let ticks = |place: usize| {
            fields
                .get(place)
                .and_then(|field| field.parse::<f64>().ok())
                .unwrap_or(0.0)
        };
        (ticks(11) + ticks(12)) / 100.0
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The memory of the page in bytes, without garbage: scripts, their buffers and the document. The median of some readings, which differ by
/// some percent: the page makes new garbage, and the browser drops code that it does not use.
fn used(browser: &Browser) -> f64 {
    let mut readings: Vec<f64> = (0..READINGS).map(|_| reading(browser)).collect();
    readings.sort_by(f64::total_cmp);
    readings[READINGS / 2]
}

fn reading(browser: &Browser) -> f64 {
    // Objects that the first run of the collector frees can hold other objects.
    for _ in 0..3 {
        browser.devtools("HeapProfiler.collectGarbage", json!({}));
    }
    let usage = browser.devtools("Runtime.getHeapUsage", json!({}));
    let parts = ["usedSize", "backingStorageSize", "embedderHeapUsedSize"];
    parts.iter().filter_map(|part| usage[*part].as_f64()).sum()
}

fn number(browser: &Browser, expression: &str) -> f64 {
    browser.value(expression).as_f64().expect("a number")
}

/// The samples that the page has got, and those that are lost.
fn counted(browser: &Browser) -> (f64, f64) {
    let lost = "Number(document.getElementById('lost').textContent)";
    (number(browser, "plumbline.got"), number(browser, lost))
}

/// What a minute of samples costs.
struct Minute {
    /// The samples that the page has got.
    got: f64,
    /// The memory of the program in KiB, after 10 s and after 60 s of samples.
    program: [f64; 2],
    /// The memory of the page in bytes, at the same times.
    page: [f64; 2],
}

impl Minute {
    /// Counts the samples of a minute and prints what they cost. The minute is measured with the time of the sensor: if the computer is
    /// slow, the minute takes longer, and no sample is skipped.
    fn measured(browser: &Browser, program: &Program, per_second: f64) -> Self {
        let total = "plumbline.got + plumbline.count";
        let passed = |from: f64, seconds: f64| {
            let wanted = format!("{total} >= {}", from + seconds * per_second);
            browser.wait_within(&wanted, PATIENCE);
        };
        passed(0.0, 2.0);
        let (start, (got, lost)) = (number(browser, total), counted(browser));
        passed(start, 10.0);
        let first = (program.memory(), used(browser));
        let (time, since) = (program.time(), Instant::now());
        passed(start, 60.0);
        let time = (program.time() - time) * 60.0 / since.elapsed().as_secs_f64();
        let last = (program.memory(), used(browser));
        let all = counted(browser);
        let minute = Self {
            got: all.0 - got,
            program: [first.0, last.0],
            page: [first.1, last.1],
        };
        println!(
            "{} samples, {} lost; user plus system time {time:.2} s a minute; memory at 60 s and at 10 s: program {} and {} KiB ({:+.1} %), page {:.0} and {:.0} KiB ({:+.1} %)",
            minute.got,
            all.1 - lost,
            last.0,
            first.0,
            growth(minute.program),
            last.1 / 1024.0,
            first.1 / 1024.0,
            growth(minute.page),
        );
        minute
    }
}

/// The growth of a memory, in percent.
fn growth([first, last]: [f64; 2]) -> f64 {
    assert!(first > 0.0, "the memory is not known");
    (last / first - 1.0) * 100.0
}

/// The page has all samples, or says how many it has not.
fn is_complete(browser: &Browser, minute: &Minute) {
    // The server ends the stream of a tab that has not read for 12 s. Only then samples are missing, and the page counts them.
    let (missing, streams) = (
        number(browser, "plumbline.count"),
        number(browser, "plumbline.streams"),
    );
    assert!(missing == 0.0 || streams > 1.0, "{missing} {streams}");
    assert!(minute.got + missing >= 12_000.0, "{}", minute.got);
    // The sensor has answered each poll.
    browser.wait("document.getElementById('lost').textContent === String(plumbline.count)");
}

#[test]
fn minute_at_200_samples_per_second_is_complete_and_needs_no_more_memory() {
    let program = Program::start(&[]);
    let Some(browser) = Browser::open(&program.url) else {
        return;
    };
    browser.wait("document.getElementById('state').textContent === 'connected'");
    browser.choose("#samples", "200");
    // The memory of the program, and of the page.
    let (mut memories, mut is_constant) = (Vec::new(), [false; 2]);
    for _ in 0..MINUTES {
        let minute = Minute::measured(&browser, &program, 200.0);
        is_complete(&browser, &minute);
        let memory = [minute.program, minute.page];
        memories.push(memory);
        for (constant, memory) in is_constant.iter_mut().zip(memory) {
            *constant |= growth(memory) < GROWTH;
        }
        if is_constant == [true; 2] {
            break;
        }
    }
    assert_eq!(is_constant, [true; 2], "{memories:?}");
    let streams = number(&browser, "plumbline.streams");
    // The browser reports a stream that has ended.
    let console = browser.console();
    assert!(console.is_empty() || streams > 1.0, "{console:?}");
}

#[test]
#[ignore = "takes a minute, and prints the figures of README.md"]
fn cost_of_a_minute_at_1000_samples_per_second_is_printed() {
    let program = Program::start(&["--rate", "1000"]);
    let Some(browser) = Browser::open(&program.url) else {
        return;
    };
    browser.wait("document.getElementById('state').textContent === 'connected'");
    browser.choose("#samples", "1000");
    Minute::measured(&browser, &program, 1000.0);
}

#[test]
#[ignore = "writes the picture of README.md"]
fn screenshot_for_the_readme() {
    let program = Program::start(&[]);
    let Some(browser) = Browser::open(&program.url) else {
        return;
    };
    browser.wait("document.getElementById('state').textContent === 'connected'");
    browser.choose("#samples", "50");
    browser.choose("#theme", "light");
    // A window of the chart is full.
    browser.wait("plumbline.got > 550");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/page.png");
    std::fs::write(path, browser.picture()).expect("a picture");
}
