// The samples of one sensor in the chart.

import { Ring } from "./ring.js";

/** The samples that are kept: 10 minutes at 200 a second. */
const KEPT = 120_000;

/** Samples that this tab has not got and has got, and how often its stream has begun. */
export const missed = { count: 0, got: 0, streams: 0 };

/** @typedef {import("./state.js").Device} Device */

/** A sensor in the chart. */
export class Trace {
  /** @param {Device} device @param {boolean} isOther */
  constructor(device, isOther) {
    this.device = device;
    this.isOther = isOther;
    this.ring = new Ring(1 + device.angles.length, KEPT);
    /** Which angles are drawn. */
    this.drawn = device.angles.map(() => true);
    /** The times around each gap. @type {[number, number][]} */
    this.gaps = [];
    /** The newest row was a gap. */
    this.hole = false;
    /** The number of the next sample; null: not known. @type {number | null} */
    this.next = null;
  }

  /** What tells it apart from another sensor in the chart. */
  get name() {
    const { label, product, address } = this.device;
    return label ?? `${product} ${address}`;
  }

  /** @param {{first: number, rows: number[][]}} samples */
  take({ first, rows }) {
    if (this.next !== null && first > this.next) missed.count += first - this.next;
    // A new connection counts from 0.
    if (this.next !== null && first < this.next) this.clear();
    this.next = first + rows.length;
    missed.got += rows.length;
    for (const row of rows) {
      if (row.length < 2) { this.hole = true; continue; }
      if (this.hole && this.ring.length > 0) this.gaps = [...this.gaps.slice(-50), [this.ring.newest(), row[0]]];
      this.hole = false;
      this.ring.push(row);
    }
  }

  clear() {
    this.ring.clear();
    this.gaps = [];
  }

  /** The gaps between two times. @param {number} from @param {number} to */
  between(from, to) {
    return this.gaps.filter(([start, end]) => end > from && start < to);
  }
}
