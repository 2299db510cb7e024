// @ts-check
/** Packs bars into rows by first fit: each bar goes to the first row that is free at its first frame. Pure. */

/**
 * @param {ArrayLike<number>} first   first frame of each bar
 * @param {ArrayLike<number>} last    last frame, inclusive
 * @param {number} gap                empty frames between two bars of a row
 * @returns {{row: Int32Array, rows: number}} row of each bar, and the number of rows
 */
export function packIntervals(first, last, gap) {
  const count = first.length;
  const row = new Int32Array(count);
  const order = Int32Array.from({ length: count }, (_, i) => i).sort((a, b) => first[a] - first[b] || last[b] - last[a]);
  const ends = new Float64Array(count);
  let rows = 0;
  for (const i of order) {
    let r = 0;
    while (r < rows && ends[r] + gap >= first[i]) r += 1;
    if (r === rows) rows += 1;
    ends[r] = last[i];
    row[i] = r;
  }
  return { row, rows };
}
