// @ts-check
/**
 * Why a list of tracks is empty. Pure.
 *
 * @typedef {import('../state-types.js').ReviewState} ReviewState
 */

/** What to do where a video has no run. */
export const NO_RUN = 'No run yet: start one with “Runs”';

/**
 * @param {ReviewState} review
 * @param {number} total  tracks, those that people have drawn among them
 * @returns {string} a sentence; empty: there are tracks
 */
export function whyNoTracks(review, total) {
  if (total > 0) return '';
  if (review.tracks !== null) return 'No track yet.';
  if (review.run?.state === 'queued') return 'The run is waiting for its turn.';
  if (review.run !== null || review.timebase === null) return 'Loading the tracks…';
  return `${NO_RUN}.`;
}
