// @ts-check
/**
 * One track's lane in typed arrays with the range of every value (NaN: the step did not take place). The value lanes
 * draw from these without further allocation. Pure.
 *
 * @typedef {import('../types.js').TrackLane} TrackLane
 *
 * @typedef {object} DetailColumns
 * @property {number} count
 * @property {Int32Array} frame
 * @property {Record<SeriesName, Float32Array>} series
 * @property {Record<SeriesName, [number, number]>} range   smallest and largest value, never equal
 * @property {Int8Array} confident        1, 0; -1: no verdict
 * @property {number[]} classes
 * @property {Float32Array} votes         count x classes, cumulative over the classes of a frame; NaN: no votes yet
 * @property {{low: number, high: number}} domain   range of the axis of L_positive
 */
import { upperBound } from './binary_search.js';
import { logDomain } from './gate_lane.js';

const SERIES = /** @type {const} */ ([
  'l_positive',
  'symmetry',
  'hash_distance',
  'position_distance',
  'score',
  'raw_score',
  'decision',
  'probability',
  'weight',
]);
/** @typedef {typeof SERIES[number]} SeriesName */

/** @param {TrackLane} lane @returns {DetailColumns} */
export function detailColumns(lane) {
  const count = lane.frame.length;
  const series = /** @type {Record<SeriesName, Float32Array>} */ ({});
  const range = /** @type {Record<SeriesName, [number, number]>} */ ({});
  for (const name of SERIES) {
    series[name] = Float32Array.from(lane[name], (value) => value ?? Number.NaN);
    range[name] = rangeOf(series[name]);
  }
  const both = /** @type {[number, number]} */ ([
    Math.min(range.score[0], range.raw_score[0]),
    Math.max(range.score[1], range.raw_score[1]),
  ]);
  range.score = range.raw_score = both;
  for (const name of /** @type {SeriesName[]} */ (['symmetry', 'hash_distance', 'position_distance', 'weight'])) {
    range[name] = [0, Math.max(range[name][1], 1e-6)];
  }
  range.probability = [0, 1];
  range.decision = [Math.min(-1, range.decision[0]), Math.max(1, range.decision[1])];
  return {
    count,
    frame: Int32Array.from(lane.frame),
    series,
    range,
    confident: Int8Array.from(lane.confident, (value) => (value === null ? -1 : value ? 1 : 0)),
    classes: lane.classes,
    votes: cumulative(lane),
    domain: logDomain(lane, lane.tau),
  };
}

/**
 * Index of the last entry at or before a frame.
 *
 * @param {Int32Array} frames   sorted
 * @param {number} frame
 * @returns {number} -1: none
 */
export const lastIndexAt = (frames, frame) => upperBound(frames, frame) - 1;

/** The range of finite values. Values that mean "could not be judged" do not stretch the axis. @param {Float32Array} values @returns {[number, number]} */
function rangeOf(values) {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (!(Math.abs(value) < 1e6)) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  if (low > high) return [0, 1];
  return low === high ? [low - 0.5, high + 0.5] : [low, high];
}

/** @param {TrackLane} lane */
function cumulative(lane) {
  const width = lane.classes.length;
  const votes = new Float32Array(lane.frame.length * width).fill(Number.NaN);
  lane.votes.forEach((shares, i) => {
    let sum = 0;
    for (let c = 0; shares !== null && c < width; c += 1) {
      sum += shares[c];
      votes[i * width + c] = Math.min(1, sum);
    }
  });
  return votes;
}
