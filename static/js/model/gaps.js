// @ts-check
/** Free space between marks on a line. Pure. */
import { partitionPoint } from './binary_search.js';

/**
 * The first place where something of a given width fits without touching a mark.
 *
 * @param {number} from
 * @param {number} to
 * @param {number} width
 * @param {number} count                       number of marks
 * @param {(i: number) => number} markAt       their places, ascending
 * @param {number} markRadius                       extent of a mark to each side
 * @returns {number|null} its start; null: nowhere
 */
export function firstGap(from, to, width, count, markAt, markRadius) {
  let at = from;
  for (let i = partitionPoint(0, count, (k) => markAt(k) + markRadius <= from); i < count && at + width <= to; i += 1) {
    const mark = markAt(i);
    if (mark - markRadius >= at + width) break;
    at = Math.max(at, mark + markRadius);
  }
  return at + width <= to ? at : null;
}
