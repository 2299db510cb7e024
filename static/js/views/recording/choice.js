// @ts-check
/** Which recording to show, and which frames a new one should have. Pure. */

/** @typedef {import('./api.js').Recording} Recording */
/** @typedef {{first: number, stop: number}} Range */

/** Frames of a recording that is made around the cursor. */
export const AROUND = 300;

/** @param {Range} range @param {number} frame */
export const covers = ({ first, stop }, frame) => first <= frame && frame < stop;

/**
 * The recording that shows a frame best: the newest finished one that has it.
 *
 * @param {readonly Recording[]} recordings   the newest first
 * @param {number} frame
 * @returns {Recording|null}
 */
export const recordingFor = (recordings, frame) =>
  recordings.find((recording) => recording.state === 'complete' && covers(recording.options, frame)) ?? null;

/**
 * Frames around the cursor, within those that the run has.
 *
 * @param {number} frame
 * @param {Range} run
 * @returns {Range|null}   null: the run has none
 */
export function rangeAround(frame, run) {
  if (run.stop <= run.first) return null;
  const first = Math.max(run.first, Math.min(frame - AROUND / 2, run.stop - AROUND));
  return { first, stop: Math.min(run.stop, first + AROUND) };
}

/** The frames that a run has stored. @param {import('../../types.js').Run} run @returns {Range} */
export const framesOf = (run) => ({ first: run.first, stop: run.first + run.frames_done });
