// @ts-check
/**
 * How far a run is, and whether it can go on. Pure.
 *
 * @typedef {import('../types.js').Run} Run
 */

/** @param {Run} run @returns {number} 0..1 */
export function runPart(run) {
  return done(run, 1);
}

/** @param {Run} run @returns {string} `42 %`, rounded down: `100 %` only where nothing is missing */
export function runPercent(run) {
  return `${Math.floor(done(run, 100))} %`;
}

/** Whether it has stopped early and can go on from there. @param {Run} run */
export function resumable({ kind, state }) {
  return kind === 'engine' && ['cancelled', 'interrupted', 'failed'].includes(state);
}

/**
 * What is done of a whole. Multiplied before it is divided: 29 of 100 frames are 29 %, but 100 * 0.29 is a little less.
 *
 * @param {Run} run
 * @param {number} whole
 * @returns {number} 0..whole; 0 where nobody knows yet how long the run is
 */
function done({ state, frames_done, frames_total }, whole) {
  if (state === 'complete') return whole;
  return frames_total ? Math.min(whole, (whole * frames_done) / frames_total) : 0;
}
