// The attitude as a box: 8 corners are turned, the faces are drawn from the back to the front.

import { element, state } from "./state.js";
import { decimal, onLanguage, t } from "./texts.js";

const SVG = "http://www.w3.org/2000/svg";
const [LONG, WIDE, HIGH] = [1, 0.65, 0.22];
const CORNERS = [-1, 1].flatMap((x) => [-1, 1].flatMap((y) => [-1, 1].map((z) => [x * LONG, y * WIDE, z * HIGH])));
/** The corners of the faces, and their class. @type {[number[], string][]} */
const FACES = [
  [[1, 3, 7, 5], "top"], [[0, 2, 6, 4], "side"], [[4, 5, 7, 6], "front"],
  [[0, 1, 3, 2], "side"], [[0, 1, 5, 4], "side"], [[2, 3, 7, 6], "side"],
];
/** The direction of view: from the front right, from above. */
const [TURN, TILT] = [(-35 * Math.PI) / 180, (20 * Math.PI) / 180];

/** The axes of a sensor with two angles, on the top of the box: name, end of the line, place of the name. @type {[string, number[], number[]][]} */
const AXES = [["X", [1.25, 0, HIGH], [1.42, 0, HIGH]], ["Y", [0, 1.05, HIGH], [0, 1.3, HIGH]]];

/** @type {SVGPolygonElement[]} */
let polygons = [];
/** The lines and the names of the axes. @type {any[][]} */
let axes = [];
let drawn = "";

/** Turns a point in the plane of two axes. @param {number[]} point @param {number} one @param {number} other @param {number} angle */
export function turn(point, one, other, angle) {
  const turned = [...point];
  const [sine, cosine] = [Math.sin(angle), Math.cos(angle)];
  turned[one] = cosine * point[one] - sine * point[other];
  turned[other] = sine * point[one] + cosine * point[other];
  return turned;
}

/**
 * A corner of the box on the screen; the third number is the depth. One angle turns the box about the line of sight of its front:
 * a right-hand rotation is positive. Two angles tilt it about its Y axis, where a positive X lowers the X axis, and about its X axis,
 * where a positive Y raises the Y axis.
 * @param {number[]} corner
 * @param {number[]} angles in degrees
 */
export function project(corner, angles) {
  const [first, second] = angles.map((angle) => (angle * Math.PI) / 180);
  if (angles.length === 1) return look(turn(corner, 0, 2, first));
  return look(turn(turn(corner, 0, 2, -first), 1, 2, second));
}

/** A point on the screen; the third number is the depth. @param {number[]} point */
export function look(point) {
  const [x, y, z] = turn(turn(point, 0, 1, TURN), 1, 2, TILT);
  return [x, -z, y];
}

/** @param {string} tag @returns {any} */
export function svg(tag) {
  return document.createElementNS(SVG, tag);
}

/** The faces of a box, to be painted. @returns {SVGPolygonElement[]} */
export function faces() {
  return FACES.map(() => svg("polygon"));
}

/** Paints the faces from the back to the front. @param {SVGPolygonElement[]} polygons @param {(corner: number[]) => number[]} place */
export function paint(polygons, place) {
  const corners = CORNERS.map(place);
  const depth = (/** @type {number[]} */ face) => face.reduce((sum, corner) => sum + corners[corner][2], 0);
  const sorted = [...FACES].sort(([one], [other]) => depth(other) - depth(one));
  sorted.forEach(([face, name], number) => {
    const points = face.map((corner) => corners[corner].slice(0, 2).map((part) => part.toFixed(3)).join(",")).join(" ");
    polygons[number].setAttribute("points", points);
    polygons[number].setAttribute("class", name);
  });
}

function draw() {
  element("box").classList.toggle("old", state.angles === null);
  const angles = (state.angles ?? [0, 0]).map((angle) => (Number.isFinite(angle) ? angle : 0));
  const key = [...angles.map((angle) => angle.toFixed(1)), state.device?.angles.length].join();
  if (key === drawn || document.hidden) return;
  drawn = key;
  paint(polygons, (corner) => project(corner, angles));
  paintAxes(angles);
}

/** @param {number[]} angles */
function paintAxes(angles) {
  const isHidden = state.device !== null && state.device.angles.length !== 2;
  AXES.forEach(([, end, place], number) => {
    const [line, name] = axes[number];
    const points = [[0, 0, HIGH], end, place].map((point) => project(point, angles.length === 2 ? angles : [0, 0]));
    const [from, to, at] = points.map((point) => point.slice(0, 2).map((part) => part.toFixed(3)));
    for (const [key, value] of [["x1", from[0]], ["y1", from[1]], ["x2", to[0]], ["y2", to[1]]]) line.setAttribute(key, value);
    name.setAttribute("x", at[0]);
    name.setAttribute("y", at[1]);
    for (const part of [line, name]) part.setAttribute("visibility", isHidden ? "hidden" : "visible");
  });
}

function label() {
  const names = state.device?.angles ?? [];
  const value = (/** @type {number} */ place) => (Number.isFinite(state.angles?.[place]) ? decimal(state.angles?.[place] ?? 0, 1) : "-");
  const parts = names.map((angle, place) => `${angle.name} ${value(place)} ${angle.unit}`);
  const text = t("attitude-label", parts.join(", ") || "-");
  element("box").setAttribute("aria-label", text);
  element("box-title").textContent = text;
}

/** Starts the picture: at most 20 times a second, its text once a second. */
export function start() {
  const box = element("box");
  const horizon = svg("line");
  for (const [name, value] of [["x1", "-1.6"], ["x2", "1.6"], ["y1", "0"], ["y2", "0"]]) horizon.setAttribute(name, value);
  polygons = faces();
  axes = AXES.map(([name], number) => {
    const [line, text] = [svg("line"), svg("text")];
    line.setAttribute("class", number === 0 ? "x" : "y");
    text.textContent = name;
    return [line, text];
  });
  box.append(horizon, ...polygons, ...axes.flat());
  draw();
  onLanguage(label);
  setInterval(draw, 50);
  setInterval(label, 1000);
}
