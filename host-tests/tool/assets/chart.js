// The oscilloscope: uPlot over the samples of one or more sensors.

import { post } from "./api.js";
import { attempt, element, make, mayAct, on, sensor, state } from "./state.js";
import { currentLanguage, decimal, onLanguage, t } from "./texts.js";
import { missed, Trace } from "./trace.js";

/** The pause between two pictures in ms. */
const PAUSE = 50;
/** The colours of the lines and their dashes: each line differs also for people who do not see all colours. */
const LINES = 8;
/** @type {(number[] | undefined)[]} */
const DASHES = [undefined, [8, 3], [2, 3], [12, 3, 2, 3]];

/** @type {any} */
let plot = null;
/** The sensors in the chart, the connected one first. Their samples stay after the end of the connection. @type {Trace[]} */
let traces = [];
/** The connection has a sensor. */
let isConnected = false;
let isPaused = false;
let isDirty = false;
/** The time of the right edge while the chart is paused. */
let edge = 0;

const seconds = () => Number(element("window").value);
const newest = () => Math.max(0, ...traces.map(({ ring }) => ring.newest()));
const right = () => (isPaused ? edge : newest());

/** A colour of the style sheet in the theme that is in force. @param {string} name */
function resolved(name) {
  const probe = document.createElement("span");
  probe.style.color = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  document.body.append(probe);
  const value = getComputedStyle(probe).color;
  probe.remove();
  return value;
}

/** The angles of all sensors, in the order of the lines. */
function angles() {
  return traces.flatMap((trace) => trace.device.angles.map((angle, place) => ({ trace, angle, place })));
}

/** @param {Trace} trace @param {import("./state.js").Angle} angle */
function label(trace, angle) {
  const name = `${angle.name} / ${angle.unit}`;
  return traces.length > 1 ? `${trace.name}: ${name}` : name;
}

function build() {
  plot?.destroy();
  plot = null;
  const all = angles();
  element("chart").hidden = all.length === 0;
  if (all.length === 0) return;
  const [text, line] = [resolved("--quiet"), resolved("--line")];
  const axis = { stroke: text, grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1 } };
  const place = element("chart");
  plot = new /** @type {any} */ (window).uPlot({
    width: Math.max(place.clientWidth, 250),
    height: 300,
    pxAlign: false,
    scales: { x: { time: false, range: () => [-seconds(), 0] } },
    axes: [{ ...axis, label: `${t("time")} / s`, labelSize: 20 }, { ...axis, size: 60 }].map((own) => ({ ...own, values: written })),
    legend: { live: true },
    cursor: { drag: { x: false, y: false }, dataIdx: nearest },
    series: [
      { label: `${t("time")} / s`, value: valued(3) },
      ...all.map(({ trace, angle, place: own }, number) => ({
        label: label(trace, angle),
        show: trace.drawn[own],
        stroke: resolved(`--line-${number % LINES}`),
        width: 1.5,
        dash: DASHES[number % DASHES.length],
        points: { show: false },
        gaps: (/** @type {any} */ plot, /** @type {number} */ _, /** @type {number} */ first, /** @type {number} */ last, /** @type {any[]} */ known) => (
          holes(trace, plot, first, last, known)),
        value: valued(2),
      })),
    ],
  }, view(), place);
  const canvas = place.querySelector("canvas");
  canvas?.setAttribute("role", "img");
  canvas?.setAttribute("aria-label", t("chart-label"));
}

/** The text of a value in the table under the chart. @param {number} digits */
const valued = (digits) => (/** @type {any} */ _, /** @type {number | null | undefined} */ value) => (
  value === null || value === undefined ? "-" : decimal(value, digits));

/** The place of the sample of a line that is nearest to the cursor: the samples of several sensors have different times. @param {any} plot @param {number} line @param {number} place */
function nearest(plot, line, place) {
  const values = plot.data[line];
  for (let away = 0; away < 20; away += 1) {
    for (const own of [place - away, place + away]) if (values[own] !== undefined && values[own] !== null) return own;
  }
  return place;
}

/** The numbers at an axis. @param {any} _ @param {number[]} numbers */
function written(_, numbers) {
  return numbers.map((number) => number.toLocaleString(currentLanguage(), { maximumFractionDigits: 3 }));
}

/** @param {Trace} trace @param {any} plot @param {number} first @param {number} last @param {any[]} known */
function holes(trace, plot, first, last, known) {
  const [from, to] = [plot.data[0][first], plot.data[0][last]].map((time) => time + right());
  return [...known, ...trace.between(from, to).map((gap) => gap.map((at) => Math.round(plot.valToPos(at - right(), "x", true))))];
}

/** The samples since a time, on one axis of time. @param {number} from @returns {ArrayLike<number>[]} */
function table(from) {
  const own = traces.map(({ ring }) => ring.since(from));
  if (own.length === 0) return [[], []];
  return own.length === 1 ? own[0] : /** @type {any} */ (window).uPlot.join(own);
}

/** The samples of the window; their times count back from the right edge. */
function view() {
  const [times, ...values] = table(right() - seconds());
  return [Array.from(times, (time) => time - right()), ...values];
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
  const isEmpty = traces.every(({ ring }) => ring.length === 0);
  element("chart-empty").hidden = !isEmpty;
  element("chart").hidden = plot === null;
  element("csv").disabled = isEmpty;
}

/** The sensors in the chart, with their angles to choose from. */
function showTraces() {
  element("traces").hidden = traces.length === 0;
  element("traces").replaceChildren(...traces.map((trace) => {
    const line = make("div", undefined, "buttons");
    line.append(make("span", trace.name));
    line.setAttribute("role", "group");
    line.setAttribute("aria-label", trace.name);
    trace.device.angles.forEach((angle, place) => line.append(choice(trace, angle, place)));
    if (trace.isOther) line.append(remover(trace));
    return line;
  }));
}

/** @param {Trace} trace @param {import("./state.js").Angle} angle @param {number} place */
function choice(trace, angle, place) {
  const [field, box] = [make("label", undefined, "check"), document.createElement("input")];
  box.type = "checkbox";
  box.id = `drawn-${traces.indexOf(trace)}-${place}`;
  box.checked = trace.drawn[place];
  box.addEventListener("change", () => {
    trace.drawn[place] = box.checked;
    build();
  });
  field.append(box, angle.name);
  return field;
}

/** @param {Trace} trace */
function remover(trace) {
  const button = /** @type {HTMLButtonElement} */ (make("button", t("remove")));
  button.type = "button";
  button.setAttribute("aria-label", t("remove-of", trace.name));
  button.addEventListener("click", () => attempt(() => post("api/chart", { remove: trace.device.connection }, sensor()), button));
  return button;
}

function pause() {
  isPaused = !isPaused;
  edge = newest();
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
  const names = angles().map(({ trace, angle }) => `${traces.length > 1 ? `${trace.name} ` : ""}${angle.name}_${angle.unit}`);
  const [times, ...values] = table(-Infinity);
  const lines = Array.from(times, (time, place) => [time.toFixed(3), ...values.map((own) => own[place] ?? "")].join(","));
  download("angles.csv", "text/csv", `${[["time_s", ...names].join(","), ...lines].join("\n")}\n`);
}

/** Hands a text to the user as a file. @param {string} name @param {string} type @param {string} text */
export function download(name, type, text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** Whether the sensor sends its angles by itself. */
function showSends() {
  const every = state.status?.sendsEvery ?? null;
  const place = element("sends");
  place.hidden = every === null;
  const text = every === null ? "" : t("sends", every.toLocaleString(currentLanguage(), { maximumFractionDigits: 1 }));
  if (place.textContent !== text) place.textContent = text;
}

/** What a trace shows; another sensor has another one. @param {import("./state.js").Device} device */
const shape = ({ angles: own, serial, address, label: name }) => JSON.stringify([own, serial, address, name]);

/** Other sensors are in the chart. @param {Trace[]} next */
function put(next) {
  traces = next;
  build();
  showTraces();
}

/** The connected sensor. @param {import("./state.js").Device | null} device */
function takeDevice(device) {
  const isNew = !isConnected;
  isConnected = device !== null;
  if (!device) return;
  const own = traces.find(({ isOther }) => !isOther);
  const main = own && shape(own.device) === shape(device) ? own : new Trace(device, false);
  // The other sensors are those of one connection.
  const others = isNew ? [] : traces.filter(({ isOther }) => isOther);
  if (main !== own || others.length + 1 < traces.length) put([main, ...others]);
}

/** The other sensors. After the end of the connection they stay as they are. @param {import("./state.js").Device[]} devices */
function takeOthers(devices) {
  if (devices.length === 0 && state.status?.state !== "active") return;
  const kept = traces.filter(({ isOther, device }) => !isOther || devices.some((own) => own.connection === device.connection));
  const added = devices.filter((own) => !kept.some(({ isOther, device }) => isOther && own.connection === device.connection));
  if (added.length > 0 || kept.length < traces.length) put([...kept, ...added.map((device) => new Trace(device, true))]);
}

/** @param {Trace | undefined} trace @param {{first: number, rows: number[][]}} samples */
function take(trace, samples) {
  trace?.take(samples);
  isDirty ||= !isPaused;
}

/** Starts the chart. */
export function start() {
  on("device", takeDevice);
  on("others", takeOthers);
  on("status", showSends);
  on("samples", (samples) => take(traces.find(({ isOther }) => !isOther), samples));
  on("other-samples", (samples) => take(traces.find(({ isOther, device }) => isOther && device.connection === samples.sensor), samples));
  on("restarted", () => { missed.streams += 1; });
  on("status", (status) => {
    const field = element("samples");
    if (status && document.activeElement !== field) field.value = String(status.samples);
    field.disabled = !mayAct();
  });
  element("pause").addEventListener("click", pause);
  element("window").addEventListener("change", () => { isDirty = true; });
  element("samples").addEventListener("change", () => attempt(() => post("api/samples", { perSecond: Number(element("samples").value) })));
  element("clear").addEventListener("click", () => {
    for (const trace of traces) trace.clear();
    isDirty = true;
  });
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
    if (spoken !== currentLanguage()) put(traces);
    spoken = currentLanguage();
  });
  setInterval(draw, PAUSE);
}
