// @ts-check
/** The recording to show, and the frames of a new one. Pure. */

/** @typedef {import('./api.js').Recording} Recording */
/** @typedef {{first: number, stop: number}} Range */

/** Number of frames of a recording around the cursor. */
export const RECORDING_LENGTH = 300;

/** @param {Range} range @param {number} frame */
export const covers = ({ first, stop }, frame) => first <= frame && frame < stop;

/**
 * The recording for a frame: the newest finished one that contains it.
 *
 * @param {readonly Recording[]} recordings   newest first
 * @param {number} frame
 * @returns {Recording|null}
 */
export const recordingFor = (recordings, frame) =>
  recordings.find((recording) => recording.state === 'complete' && covers(recording.options, frame)) ?? null;

/**
 * Frames around the cursor, within those of the run.
 *
 * @param {number} frame
 * @param {Range} run
 * @returns {Range|null}   null: the run has no frames
 */
export function rangeAround(frame, run) {
  if (run.stop <= run.first) return null;
  const first = Math.max(run.first, Math.min(frame - RECORDING_LENGTH / 2, run.stop - RECORDING_LENGTH));
  return { first, stop: Math.min(run.stop, first + RECORDING_LENGTH) };
}

/** The frames that a run has stored. @param {import('../../types.js').Run} run @returns {Range} */
export const storedFrames = (run) => ({ first: run.first, stop: run.first + run.frames_done });
