// @ts-check
/** Verdicts of the gate along one track: which would flip at another tau, and the log axis that shows them. Pure. */

/** @typedef {import('../types.js').TrackLane} TrackLane */

/** Values outside are drawn at the edge of the axis. */
const MIN_AXIS_VALUE = 0.01;
const MAX_AXIS_VALUE = 1e5;

/**
 * Whether the verdict at an index of the lane would flip at `tau`.
 *
 * @param {TrackLane} lane
 * @param {number} i     index in the columns
 * @param {number} tau
 * @returns {boolean}
 */
export function flips(lane, i, tau) {
  const value = lane.l_positive[i];
  return value !== null && lane.confident[i] !== null && value < tau !== lane.confident[i];
}

/**
 * @param {TrackLane} lane
 * @param {number} tau
 * @returns {{verdicts: number, toConfident: number, toRejected: number, total: number}} `total`: both directions
 */
export function countFlips(lane, tau) {
  const count = { verdicts: 0, toConfident: 0, toRejected: 0, total: 0 };
  for (let i = 0; i < lane.frame.length; i += 1) {
    if (lane.l_positive[i] === null || lane.confident[i] === null) continue;
    count.verdicts += 1;
    if (!flips(lane, i, tau)) continue;
    if (lane.confident[i]) count.toRejected += 1;
    else count.toConfident += 1;
  }
  count.total = count.toConfident + count.toRejected;
  return count;
}

/**
 * Whole decades around every verdict and tau.
 *
 * @param {TrackLane} lane
 * @param {number} tau
 * @returns {{low: number, high: number}} powers of ten
 */
export function logDomain(lane, tau) {
  let low = tau / 5;
  let high = tau * 5;
  for (const value of lane.l_positive) {
    if (value === null || value <= 0) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  low = Math.max(low, MIN_AXIS_VALUE);
  high = Math.min(high, MAX_AXIS_VALUE);
  return { low: 10 ** Math.floor(Math.log10(low)), high: 10 ** Math.ceil(Math.log10(high)) };
}

/**
 * Place of a value on a log axis.
 *
 * @param {number} value
 * @param {{low: number, high: number}} domain
 * @returns {number} 0 at the bottom, 1 at the top; values outside are at the edge, and so is zero
 */
export function logPosition(value, domain) {
  if (!(value > domain.low)) return 0;
  if (value >= domain.high) return 1;
  return Math.log(value / domain.low) / Math.log(domain.high / domain.low);
}

/**
 * The inverse of `logPosition`, rounded to three digits, as tau is shown and typed.
 *
 * @param {number} position
 * @param {{low: number, high: number}} domain
 * @returns {number}
 */
export function valueAtLogPosition(position, domain) {
  const inside = Math.min(1, Math.max(0, position));
  return Number((domain.low * (domain.high / domain.low) ** inside).toPrecision(3));
}
