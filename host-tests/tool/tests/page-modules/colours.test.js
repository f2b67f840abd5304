// The colours of the lines of the chart, as people with a colour vision deficiency see them (Machado, Oliveira and Fernandes, 2009: the
// matrices for complete deficiency).

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";

const STYLE = readFileSync(new URL("../../assets/style.css", import.meta.url), "utf8");
const SEEN = {
  all: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  protanopia: [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
  deuteranopia: [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
  tritanopia: [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]],
};
/** The least distance in CIE L*a*b*: 2.3 is just noticeable. */
const LEAST = 20;

/** The colours of a theme: light is 0, dark 1. */
function lines(theme) {
  const value = (name) => STYLE.match(new RegExp(`${name}: (.+);`))[1];
  return Array.from({ length: 8 }, (_, line) => {
    const own = value(`--line-${line}`);
    return (own.startsWith("var(") ? value(own.slice(4, -1)) : own).match(/#\w{6}/g)[theme];
  });
}

/** A colour in CIE L*a*b*, as it is seen. */
function seen(colour, matrix) {
  const parts = [1, 3, 5].map((place) => parseInt(colour.slice(place, place + 2), 16) / 255);
  const linear = parts.map((part) => (part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4));
  const [r, g, b] = matrix.map((row) => Math.min(1, Math.max(0, row.reduce((sum, factor, place) => sum + factor * linear[place], 0))));
  const curve = (part) => (part > 0.008856 ? Math.cbrt(part) : 7.787 * part + 16 / 116);
  const [x, y, z] = [
    curve((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.95047), curve(0.2126 * r + 0.7152 * g + 0.0722 * b),
    curve((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.08883),
  ];
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

test("lines_of_the_chart_differ_also_for_people_who_do_not_see_all_colours", () => {
  for (const theme of [0, 1]) {
    const colours = lines(theme);
    for (const [name, matrix] of Object.entries(SEEN)) {
      const points = colours.map((colour) => seen(colour, matrix));
      points.forEach((point, number) => points.slice(0, number).forEach((other, place) => {
        const distance = Math.hypot(...point.map((part, axis) => part - other[axis]));
        assert.ok(distance >= LEAST, `${name}: ${colours[place]} and ${colours[number]}, ${distance}`);
      }));
    }
  }
});
