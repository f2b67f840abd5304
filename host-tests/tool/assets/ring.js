// The newest samples, in memory of a fixed size. A part of them is one array without a copy.

/** Rows of numbers; the oldest are overwritten. */
export class Ring {
  /** @param {number} columns @param {number} capacity rows */
  constructor(columns, capacity) {
    this.capacity = capacity;
    this.columns = Array.from({ length: columns }, () => new Float64Array(2 * capacity));
    this.end = 0;
    this.length = 0;
  }

  /** @param {number[]} row */
  push(row) {
    if (this.end === 2 * this.capacity) {
      for (const column of this.columns) column.copyWithin(0, this.capacity);
      this.end = this.capacity;
    }
    this.columns.forEach((column, place) => { column[this.end] = row[place] ?? NaN; });
    this.end += 1;
    this.length = Math.min(this.length + 1, this.capacity);
  }

  clear() {
    this.end = 0;
    this.length = 0;
  }

  /** The rows whose first number is at least `from`, as columns. @param {number} from @returns {Float64Array[]} */
  since(from) {
    const first = this.columns[0];
    let [low, high] = [this.end - this.length, this.end];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (first[middle] < from) low = middle + 1; else high = middle;
    }
    return this.columns.map((column) => column.subarray(low, this.end));
  }

  /** The first number of the newest row. @returns {number} */
  newest() {
    return this.length > 0 ? this.columns[0][this.end - 1] : 0;
  }
}
