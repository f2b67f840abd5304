//! Contrast of all texts in both colour schemes (WCAG 2.2, 1.4.3: 4.5:1), and of the lines of the chart (1.4.11: 3:1).

use crate::browser::chromium::{Browser, CONNECTED, OPEN};
use crate::serve::client::Running;
use serde_json::json;

/// Functions for the contrast of two colours, and of a text with what is behind it. Disabled controls are left out, as in WCAG.
const CONTRAST: &str = "
    const context = Object.assign(document.createElement('canvas'), { width: 1, height: 1 }).getContext('2d', { willReadFrequently: true });
    const numbers = (colour) => {
        context.clearRect(0, 0, 1, 1);
        context.fillStyle = colour;
        context.fillRect(0, 0, 1, 1);
        return [...context.getImageData(0, 0, 1, 1).data];
    };
    const over = ([r, g, b, a], below) => [r, g, b].map((part, place) => (part * a + below[place] * (255 - a)) / 255);
    const ground = (element) => {
        if (!element) return [255, 255, 255];
        const own = numbers(getComputedStyle(element).backgroundColor);
        return own[3] === 255 ? own.slice(0, 3) : over(own, ground(element.parentElement));
    };
    const light = (parts) => {
        const [r, g, b] = parts.map((part) => part / 255).map((part) => (part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4));
        return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const ratio = (one, other) => {
        const [low, high] = [light(one), light(other)].sort((a, b) => a - b);
        return (high + 0.05) / (low + 0.05);
    };
    const contrast = (element, colour) => {
        const below = ground(element);
        return ratio(over(numbers(colour), below), below);
    };
    const texts = () => [...document.querySelectorAll('body *')].flatMap((element) => {
        const isField = element.matches('input, select, button, progress');
        const hasText = [...element.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
        if ((!isField && !hasText) || element.closest(':disabled, option, canvas') || !element.checkVisibility()) return [];
        const style = getComputedStyle(element);
        const colours = [style instanceof CSSStyleDeclaration && element instanceof SVGElement ? style.fill : style.color];
        if (element.placeholder && !element.value) colours.push(getComputedStyle(element, '::placeholder').color);
        return colours.map((colour) => ({ element, ratio: contrast(element, colour) }));
    });
    const named = ({ element, ratio }) => `${element.tagName}#${element.id}.${element.className?.baseVal ?? element.className} ${element.textContent.trim().slice(0, 30)} ${ratio.toFixed(2)}`;
";

/// The texts whose contrast is too low; at least this number of texts is there.
#[track_caller]
fn check(browser: &Browser, state: &str, most: usize) {
    for theme in ["light", "dark"] {
        browser.script(&format!(
            "document.documentElement.dataset.theme = '{theme}'"
        ));
        let found = browser.script(&format!(
            "{CONTRAST} const all = texts(); return [all.length, all.filter(({{ ratio }}) => ratio < 4.5).map(named)]"
        ));
        assert_eq!(found[1], json!([]), "{state} {theme}");
        let count = found[0].as_u64().unwrap_or(0);
        assert!(count >= most as u64, "{state} {theme}: {count} texts");
        let lines = browser.script(&format!(
            "{CONTRAST} const style = getComputedStyle(document.documentElement);
            const chart = document.getElementById('chart');
            return ['--quiet', ...Array.from({{ length: 8 }}, (_, line) => `--line-${{line}}`)].map((name) => {{
                const probe = Object.assign(document.createElement('span'), {{ style: `color: ${{style.getPropertyValue(name)}}` }});
                chart.append(probe);
                const own = contrast(chart, getComputedStyle(probe).color);
                probe.remove();
                return own;
            }}).filter((own) => own < 3)"
        ));
        assert_eq!(lines, json!([]), "{state} {theme}");
    }
}

/// The colours of all texts, in the states of the page that have other colours.
pub fn texts_of_both_colour_schemes_have_a_contrast_of_4_5_to_1(browser: &Browser) {
    let server = Running::demonstration();
    browser.open(&server.url());
    // A transition would show a colour of the other scheme.
    let reduced = json!({"features": [{"name": "prefers-reduced-motion", "value": "reduce"}]});
    browser.devtools("Emulation.setEmulatedMedia", reduced);
    let schemes = browser.script(
        "return ['light', 'dark'].map((theme) => { document.documentElement.dataset.theme = theme; return getComputedStyle(document.body).backgroundColor; })",
    );
    assert_ne!(schemes[0], schemes[1], "two schemes");
    browser.wait(CONNECTED);
    browser.wait("document.querySelectorAll('#rows tr').length > 10");
    check(browser, "connected", 150);
    // Values that differ, a value that is refused, and an action that failed.
    browser.click("#backup");
    browser.wait("document.getElementById('file-state').textContent.includes('is2-1.toml')");
    browser.wait("!document.getElementById('file-filter-type').disabled");
    browser.choose("#file-filter-type", "Butterworth");
    browser.wait("document.querySelector('tr.differs')");
    browser.write("#file-cyclic-time", "0\u{E007}");
    browser.wait("document.getElementById('wrong-cyclic-time').textContent !== ''");
    browser.wait("document.querySelector('#log-rows .failed')");
    check(browser, "changed", 150);
    // A calibration: a position that is taken, one that is asked for, those that are missing; and its end.
    browser.click("#expert summary");
    browser.click("#calibrate-start");
    browser.wait("!document.getElementById('calibrate-take').disabled");
    browser.click("#calibrate-take");
    browser.wait("document.querySelector('#calibrate-positions .taken')");
    check(browser, "calibration", 150);
    browser.click("#calibrate-stop");
    browser.wait("document.querySelector('#calibrate-step.bad')");
    check(browser, "stopped calibration", 150);
    // A failure, and a question.
    browser.write("#port", "demo:is3");
    browser.click("#connect");
    browser.wait("document.getElementById('message').textContent.includes('the products are')");
    browser.click("#find");
    browser.wait(OPEN);
    check(browser, "question", 150);
    browser.click("#question-no");
    browser.devtools("Emulation.setEmulatedMedia", json!({"features": []}));
}
