// The oscilloscope: uPlot over a ring of samples.

import { post } from "./api.js";
import { Ring } from "./ring.js";
import { attempt, element, on, state } from "./state.js";
import { currentLanguage, decimal, onLanguage, t } from "./texts.js";

/** The samples that are kept: 10 minutes at 200 a second. */
const KEPT = 120_000;
/** The pause between two pictures in ms. */
const PAUSE = 50;
const COLOURS = ["--x", "--y", "--third"];

/** @type {any} */
let plot = null;
/** The angles of the samples: they stay after the end of the connection. @type {import("./state.js").Angle[]} */
let angles = [];
/** @type {Ring | null} */
let ring = null;
/** The times around each gap. @type {[number, number][]} */
let gaps = [];
let isPaused = false;
let isDirty = false;
/** The time of the right edge while the chart is paused. */
let edge = 0;
/** The newest row was a gap. */
let hole = false;
/** The number of the next sample; null: not known. @type {number | null} */
let next = null;
/** Samples that this tab has not got and has got, and how often its stream has begun. */
export const missed = { count: 0, got: 0, streams: 0 };

const seconds = () => Number(element("window").value);
const colour = (/** @type {string} */ name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** A colour of the style sheet in the theme that is in force. @param {string} name */
function resolved(name) {
  const probe = document.createElement("span");
  probe.style.color = colour(name);
  document.body.append(probe);
  const value = getComputedStyle(probe).color;
  probe.remove();
  return value;
}

function right() {
  return isPaused ? edge : ring?.newest() ?? 0;
}

function build() {
  plot?.destroy();
  plot = null;
  element("chart").hidden = angles.length === 0;
  if (angles.length === 0) return;
  const [text, line] = [resolved("--quiet"), resolved("--line")];
  const axis = { stroke: text, grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1 } };
  const place = element("chart");
  plot = new /** @type {any} */ (window).uPlot({
    width: Math.max(place.clientWidth, 300),
    height: 300,
    pxAlign: false,
    scales: { x: { time: false, range: () => [-seconds(), 0] } },
    axes: [{ ...axis, label: `${t("time")} / s`, labelSize: 20 }, { ...axis, size: 60 }].map((own) => ({ ...own, values: written })),
    legend: { live: true },
    cursor: { drag: { x: false, y: false } },
    series: [
      { label: `${t("time")} / s`, value: (/** @type {any} */ _, /** @type {number} */ value) => (value === null || value === undefined ? "-" : decimal(value, 3)) },
      ...angles.map((angle, number) => ({
        label: `${angle.name} / ${angle.unit}`,
        stroke: resolved(COLOURS[number % COLOURS.length]),
        width: 1.5,
        dash: number === 1 ? [8, 3] : undefined,
        points: { show: false },
        gaps: holes,
        value: (/** @type {any} */ _, /** @type {number} */ value) => (value === null || value === undefined ? "-" : decimal(value, 2)),
      })),
    ],
  }, view(), place);
  const canvas = place.querySelector("canvas");
  canvas?.setAttribute("role", "img");
  canvas?.setAttribute("aria-label", t("chart-label"));
}

/** The numbers at an axis. @param {any} _ @param {number[]} numbers */
function written(_, numbers) {
  return numbers.map((number) => number.toLocaleString(currentLanguage(), { maximumFractionDigits: 3 }));
}

/** @param {any} plot @param {number} _series @param {number} first @param {number} last @param {any[]} known */
function holes(plot, _series, first, last, known) {
  const [from, to] = [plot.data[0][first], plot.data[0][last]];
  const inside = gaps.map((gap) => gap.map((at) => at - right())).filter(([start, end]) => end > from && start < to);
  return [...known, ...inside.map((gap) => gap.map((at) => Math.round(plot.valToPos(at, "x", true))))];
}

/** The samples of the window; their times count back from the right edge. */
function view() {
  if (!ring) return [[], []];
  const [edge, [times, ...values]] = [right(), ring.since(right() - seconds())];
  return [times.map((time) => time - edge), ...values];
}

function draw() {
  showEmpty();
  if (!plot || !isDirty || document.hidden) return;
  isDirty = false;
  plot.setData(view(), true);
  // The window moves under the cursor.
  const { left, top } = plot.cursor;
  if (left >= 0) plot.setCursor({ left, top });
}

function showEmpty() {
  const isEmpty = (ring?.length ?? 0) === 0;
  element("chart-empty").hidden = !isEmpty;
  element("chart").hidden = plot === null;
  element("csv").disabled = isEmpty;
}

/** Whether the sensor sends its angles by itself. */
function showSends() {
  const every = state.status?.sendsEvery ?? null;
  const place = element("sends");
  place.hidden = every === null;
  const text = every === null ? "" : t("sends", shortest(every));
  if (place.textContent !== text) place.textContent = text;
}

/** @param {number} number with at most one decimal */
function shortest(number) {
  return number.toLocaleString(currentLanguage(), { maximumFractionDigits: 1 });
}

/** @param {{first: number, rows: number[][]}} samples */
function take({ first, rows }) {
  if (next !== null && first > next) missed.count += first - next;
  if (next !== null && first < next) {
    // A new connection counts from 0.
    ring?.clear();
    gaps = [];
  }
  next = first + rows.length;
  missed.got += rows.length;
  for (const row of rows) {
    if (row.length < 2) { hole = true; continue; }
    if (hole && ring && ring.length > 0) gaps = [...gaps.slice(-50), [ring.newest(), row[0]]];
    hole = false;
    ring?.push(row);
  }
  isDirty ||= !isPaused;
}

function pause() {
  isPaused = !isPaused;
  edge = ring?.newest() ?? 0;
  const button = element("pause");
  button.setAttribute("aria-pressed", String(isPaused));
  button.textContent = t(isPaused ? "go-on" : "pause");
  isDirty = true;
}

/** @param {number} step */
function moveCursor(step) {
  if (!plot) return;
  const width = plot.bbox.width / devicePixelRatio;
  const left = Math.min(Math.max((plot.cursor.left ?? -1) < 0 ? width / 2 : plot.cursor.left + step, 0), width);
  plot.setCursor({ left, top: plot.bbox.height / devicePixelRatio / 2 });
}

function save() {
  if (!ring) return;
  const heading = ["time_s", ...angles.map((angle) => `${angle.name}_${angle.unit}`)].join(",");
  const columns = ring.since(-Infinity);
  const lines = [heading];
  for (let place = 0; place < columns[0].length; place += 1) {
    lines.push(columns.map((column, number) => (number === 0 ? column[place].toFixed(3) : String(column[place]))).join(","));
  }
  download("angles.csv", "text/csv", `${lines.join("\n")}\n`);
}

/** Hands a text to the user as a file. @param {string} name @param {string} type @param {string} text */
export function download(name, type, text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** Starts the chart. */
export function start() {
  let shape = "";
  on("device", (device) => {
    const now = JSON.stringify([device?.angles ?? [], device?.serial, device?.address]);
    if (!device || now === shape) return;
    shape = now;
    angles = device.angles;
    ring = new Ring(1 + angles.length, KEPT);
    gaps = [];
    next = null;
    build();
  });
  on("status", showSends);
  on("samples", take);
  on("restarted", () => { missed.streams += 1; });
  on("status", (status) => {
    const field = element("samples");
    if (status && document.activeElement !== field) field.value = String(status.samples);
    field.disabled = state.gone !== null;
  });
  element("pause").addEventListener("click", pause);
  element("window").addEventListener("change", () => { isDirty = true; });
  element("samples").addEventListener("change", () => attempt(() => post("api/samples", { perSecond: Number(element("samples").value) })));
  element("clear").addEventListener("click", () => { ring?.clear(); gaps = []; isDirty = true; });
  element("csv").addEventListener("click", save);
  element("chart").addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
    const steps = /** @type {Record<string, number>} */ ({ ArrowLeft: -4, ArrowRight: 4 });
    if (event.key === " ") pause();
    else if (event.key in steps) moveCursor(steps[event.key]);
    else return;
    event.preventDefault();
  });
  new ResizeObserver(() => {
    const width = element("chart").clientWidth;
    if (plot && width > 0 && width !== plot.width) plot.setSize({ width, height: 300 });
  }).observe(element("chart"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", build);
  on("theme", build);
  let spoken = currentLanguage();
  onLanguage(() => {
    element("pause").textContent = t(isPaused ? "go-on" : "pause");
    showSends();
    if (spoken !== currentLanguage()) build();
    spoken = currentLanguage();
  });
  setInterval(draw, PAUSE);
}
