// @ts-check
/**
 * The progress of a run, and whether it can be resumed. Pure.
 *
 * @typedef {import('../types.js').Run} Run
 */

/** @param {Run} run @returns {number} 0..1 */
export const runShare = (run) => done(run, 1);

/** @param {Run} run @returns {string} `42 %`, rounded down: `100 %` only if nothing is missing */
export const runPercent = (run) => `${Math.floor(done(run, 100))} %`;

/** Whether its results cover a frame. @param {Run|null} run @param {number} frame */
export const covers = (run, frame) => run !== null && run.first <= frame && frame < run.first + run.frames_done;

/** Whether it stopped early and can be resumed. @param {Run} run */
export const isResumable = ({ kind, state }) => kind === 'engine' && ['cancelled', 'interrupted', 'failed'].includes(state);

/**
 * The finished part of `whole`. Multiplies before it divides: 29 of 100 frames are 29 %, but 100 * 0.29 is slightly less.
 *
 * @param {Run} run
 * @param {number} whole
 * @returns {number} 0..whole; 0 as long as the length of the run is not known
 */
function done({ state, frames_done, frames_total }, whole) {
  if (state === 'complete') return whole;
  return frames_total ? Math.min(whole, (whole * frames_done) / frames_total) : 0;
}
