// @ts-check
/** Room between marks on a line. Pure. */

/**
 * Where something of a width fits first without touching a mark.
 *
 * @param {number} from
 * @param {number} to
 * @param {number} width
 * @param {number} count                       of the marks
 * @param {(i: number) => number} markAt       their places, ascending
 * @param {number} reach                       of a mark to both sides
 * @returns {number|null} its beginning; null: nowhere
 */
export function firstGap(from, to, width, count, markAt, reach) {
  let low = 0;
  for (let high = count; low < high;) {
    const middle = (low + high) >> 1;
    if (markAt(middle) + reach <= from) low = middle + 1;
    else high = middle;
  }
  let at = from;
  for (let i = low; i < count && at + width <= to; i += 1) {
    const mark = markAt(i);
    if (mark - reach >= at + width) break;
    at = Math.max(at, mark + reach);
  }
  return at + width <= to ? at : null;
}
