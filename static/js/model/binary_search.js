// @ts-check
/** Binary search. Pure. */

/**
 * The first index at which a condition does not hold.
 *
 * @param {number} from
 * @param {number} to                      exclusive
 * @param {(i: number) => boolean} holds   true up to some index, false from there on
 * @returns {number} from..to
 */
export function partitionPoint(from, to, holds) {
  let [low, high] = [from, to];
  while (low < high) {
    const middle = (low + high) >>> 1;
    if (holds(middle)) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Number of values that are at most `value`. @param {ArrayLike<number>} values   ascending @param {number} value */
export const upperBound = (values, value) => partitionPoint(0, values.length, (i) => values[i] <= value);
