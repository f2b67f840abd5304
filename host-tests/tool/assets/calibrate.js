// The calibration of a unit: six positions, one after the other. Only the button takes a position.

import { post } from "./api.js";
import { faces, look, paint, svg, turn } from "./attitude.js";
import { element, make, mayAct, on, press, state as server } from "./state.js";
import { inLanguage, onLanguage, t } from "./texts.js";

/** The order of the positions. */
const SIDES = ["+z", "-z", "+x", "-x", "+y", "-y"];
const AXES = ["x", "y", "z"];
/** How to start the page for a unit. */
const SERVE = "plumbline --product is2 serve --calibrate positions.csv --store is2.bin -- cargo bluepill is2";

/**
 * @typedef {{state: string, up: string | null, acceleration: number[], spread: number, temperature: number}} Measured
 * @typedef {{state: string, line?: string, demo?: boolean, place?: number, side?: string, taken?: string[], serial?: number,
 *   question?: number | null, measured?: Measured | null, result?: {offset_mg: number[]}, next?: import("./texts.js").Texts, error?: import("./texts.js").Texts}} Calibration
 */

/** @type {Calibration} */
let calibration = { state: "off" };
/** @type {SVGPolygonElement[]} */
let polygons = [];
/** @type {{line: SVGElement, name: SVGElement}[]} */
let axes = [];

/** A point of the sensor with a side up. @param {number[]} point @param {string} side */
function turned(point, side) {
  const quarter = (side.startsWith("-") ? -1 : 1) * (Math.PI / 2);
  if (side.endsWith("x")) return turn(point, 0, 2, quarter);
  if (side.endsWith("y")) return turn(point, 1, 2, quarter);
  return side === "-z" ? turn(point, 1, 2, Math.PI) : point;
}

/** @param {string} side */
function draw(side) {
  paint(polygons, (corner) => look(turned(corner, side)));
  axes.forEach(({ line, name }, place) => {
    const end = [0, 0, 0];
    end[place] = 1.3;
    const [x, y] = look(turned(end, side)).map((part) => part.toFixed(3));
    line.setAttribute("x2", x);
    line.setAttribute("y2", y);
    name.setAttribute("x", (Number(x) * 1.12 - 0.07).toFixed(3));
    name.setAttribute("y", (Number(y) * 1.12).toFixed(3));
    line.classList.toggle("up", side.endsWith(AXES[place]));
  });
  const text = t("calibrate-picture", side);
  element("calibrate-picture").setAttribute("aria-label", text);
  element("calibrate-picture-title").textContent = text;
}

/** What to do now, in one or two sentences. */
function step() {
  const { state, place, side, measured, error } = calibration;
  if (state === "off") return t("calibrate-off");
  if (state === "idle") return t(calibration.demo ? "calibrate-demo" : "calibrate-idle");
  if (state === "waiting") return t("calibrate-waiting");
  if (state === "failed") return error ? inLanguage(error) : "";
  if (state === "done") return t("calibrate-done");
  if (!side || !place) return t("calibrate-waiting");
  const found = measured ? t(`calibrate-${measured.state}`, measured.up ?? "", side) : t("calibrate-measuring");
  return `${t("calibrate-place", place, side)} ${found}`;
}

/** @param {string} side @param {number} number */
function position(side, number) {
  const { state, taken, place } = calibration;
  const isTaken = state === "done" || (taken ?? []).includes(side) || number + 1 < (place ?? 0);
  const isNow = !isTaken && calibration.side === side;
  const word = isTaken ? "calibrate-taken" : isNow ? "calibrate-now" : "calibrate-missing";
  const item = make("li", `${side}: ${t(word)}`, isTaken ? "taken" : isNow ? "now" : "");
  if (isNow) item.setAttribute("aria-current", "step");
  return item;
}

function numbers() {
  const { measured, result } = calibration;
  if (result) return AXES.map((axis, place) => `${t("calibrate-offset", axis)} ${result.offset_mg[place].toFixed(2)} mg`).join(", ");
  if (!measured) return "-";
  const parts = AXES.map((axis, place) => `${axis} ${measured.acceleration[place].toFixed(1)} mg`);
  return [...parts, `${t("calibrate-spread")} ${measured.spread.toFixed(2)} mg`, `${measured.temperature.toFixed(1)} °C`].join(", ");
}

/** @param {string} id @param {string} text */
function set(id, text) {
  const place = element(id);
  if (place.textContent !== text) place.textContent = text;
}

function show() {
  const { state } = calibration;
  const isGone = server.gone !== null;
  const isRunning = !isGone && !["off", "idle", "done", "failed"].includes(state);
  set("calibrate-step", step());
  set("calibrate-numbers", numbers());
  set("calibrate-line", state === "off" ? SERVE : calibration.line ?? "");
  set("calibrate-next", state === "done" && calibration.next ? inLanguage(calibration.next) : "");
  element("calibrate-step").classList.toggle("bad", state === "failed");
  element("calibrate-positions").replaceChildren(...SIDES.map(position));
  element("calibrate-start").disabled = !mayAct() || state === "off" || isRunning;
  element("calibrate-take").disabled = !mayAct() || state !== "asking";
  element("calibrate-take").dataset.question = String(calibration.question ?? "");
  element("calibrate-again").disabled = !mayAct() || state !== "asking";
  element("calibrate-stop").disabled = !isRunning || !mayAct();
  draw(calibration.side ?? SIDES[0]);
}

/** Starts the section. */
export function start() {
  const box = element("calibrate-picture");
  polygons = faces();
  axes = AXES.map((axis) => {
    const [line, name] = [svg("line"), svg("text")];
    for (const end of ["x1", "y1"]) line.setAttribute(end, "0");
    name.textContent = axis;
    return { line, name };
  });
  box.append(...polygons, ...axes.flatMap(({ line, name }) => [line, name]));
  const answer = (/** @type {string} */ kind) => press(`calibrate-${kind}`, () => post("api/calibrate", { [kind]: calibration.question ?? 0 }));
  press("calibrate-start", () => post("api/calibrate", "start"));
  answer("take");
  answer("again");
  press("calibrate-stop", () => post("api/calibrate", "stop"));
  on("calibration", (/** @type {Calibration} */ next) => { calibration = next; show(); });
  for (const kind of ["gone", "restarted", "owner"]) on(kind, show);
  onLanguage(show);
}
