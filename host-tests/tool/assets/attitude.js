// The attitude as a box: 8 corners are turned, the faces are drawn from the back to the front.

import { element, state } from "./state.js";
import { t } from "./texts.js";

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

/** @type {SVGPolygonElement[]} */
let polygons = [];
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
  const key = angles.map((angle) => angle.toFixed(1)).join();
  if (key === drawn || document.hidden) return;
  drawn = key;
  paint(polygons, (corner) => project(corner, angles));
}

function label() {
  const names = state.device?.angles ?? [];
  const parts = names.map((angle, place) => `${angle.name} ${state.angles?.[place]?.toFixed(1) ?? "-"} ${angle.unit}`);
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
  box.append(horizon, ...polygons);
  draw();
  label();
  setInterval(draw, 50);
  setInterval(label, 1000);
}
