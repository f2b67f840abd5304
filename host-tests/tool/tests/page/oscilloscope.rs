//! The chart: what it draws while it runs, while it is paused, and after `Clear`.

use crate::browser::Browser;
use crate::server::Running;

/// The edges of the picture, and the time of the newest sample in it.
const PICTURE: &str = "[plot.scales.x.min, plot.scales.x.max, plot.data[0].at(-1)]";

/// Waits until the page has got so many samples more.
#[track_caller]
fn gets(browser: &Browser, samples: u32) {
    let got = browser.value("plumbline.got");
    browser.wait(&format!("plumbline.got >= {got} + {samples}"));
}

/// A page with 100 samples a second, whose next chart is `plot`.
fn running(server: &Running) -> Option<Browser> {
    let browser = Browser::open(&server.url)?;
    browser.wait("document.getElementById('state').textContent === 'connected'");
    browser.choose("#samples", "100");
    browser.script(
        "const { uPlot } = window;
        window.uPlot = function (...parts) { return window.plot = new uPlot(...parts); };",
    );
    // Other colours need another chart.
    browser.choose("#theme", "dark");
    browser.wait("window.plot");
    Some(browser)
}

/// The edges of the picture and its newest sample, in s.
#[track_caller]
fn picture(browser: &Browser) -> [f64; 3] {
    serde_json::from_value(browser.value(PICTURE)).expect("three numbers")
}

#[test]
fn paused_chart_stays_and_goes_on_afterwards() {
    let server = Running::new("demo:is2");
    let Some(browser) = running(&server) else {
        return;
    };
    gets(&browser, 100);
    browser.click("#pause");
    // The last picture is drawn.
    browser.script(
        "return new Promise((resolve) => setTimeout(() => requestAnimationFrame(() => resolve(0)), 200));",
    );
    let still = picture(&browser);
    gets(&browser, 100);
    assert_eq!(picture(&browser), still);
    browser.click("#pause");
    let [_, right, newest] = still;
    browser.wait(&format!(
        "{PICTURE}[1] > {right} + 1 && {PICTURE}[2] > {newest} + 1"
    ));
}

#[test]
fn window_is_the_width_of_the_chart() {
    let server = Running::new("demo:is2");
    let Some(browser) = running(&server) else {
        return;
    };
    for seconds in [5, 30] {
        browser.choose("#window", &seconds.to_string());
        browser.wait(&format!(
            "Math.abs(plot.scales.x.max - plot.scales.x.min - {seconds}) < 1e-6"
        ));
    }
    // Samples that are older than the window are not drawn.
    browser.choose("#window", "5");
    gets(&browser, 600);
    browser.wait(&format!(
        "{PICTURE}[0] > 0 && plot.data[0][0] >= {PICTURE}[0]"
    ));
}

#[test]
fn clear_removes_the_samples_from_the_csv_file() {
    let server = Running::new("demo:is2");
    let Some(browser) = running(&server) else {
        return;
    };
    gets(&browser, 400);
    browser.click("#csv");
    let times = |name: &str| -> Vec<f64> {
        let table = browser.saved(name);
        let mut lines = table.lines();
        assert_eq!(lines.next(), Some("time_s,angle-x_deg,angle-y_deg"));
        let time = |line: &str| line.split(',').next()?.parse().ok();
        lines.map(|line| time(line).expect("a time")).collect()
    };
    let before = times("angles.csv");
    browser.click("#clear");
    gets(&browser, 20);
    browser.click("#csv");
    let after = times("angles (1).csv");
    assert!(before.len() >= 400, "{before:?}");
    assert!(after.first() > before.last(), "{before:?} {after:?}");
}
