// @ts-check
/**
 * Why a list of tracks is empty. Pure.
 *
 * @typedef {import('../state-types.js').ReviewState} ReviewState
 */

import { plural } from './format.js';
import { isResumable, runPercent } from './run_progress.js';

/** The hint for a video without a run. */
export const NO_RUN = 'No run yet: start one with “Runs”';

/**
 * @param {ReviewState} review
 * @param {number} total  number of tracks, including those that people drew
 * @returns {string} a sentence or two; empty if there are tracks
 */
export function whyNoTracks(review, total) {
  if (total > 0) return '';
  const { run, tracks } = review;
  if (run === null) return review.timebase === null ? 'Loading the tracks…' : `${NO_RUN}.`;
  if (run.state === 'queued') return run.note ? `The run is waiting: ${run.note}.` : 'The run is waiting for its turn.';
  if (run.state === 'failed') return `The run failed: ${run.error ?? 'the terminal of the server says why.'}`;
  if (tracks === null) return 'Loading the tracks…';
  if (tracks.id.length > 0) return 'Every track is deleted.';
  if (run.state === 'running' && run.note) return `The run has found no sign yet: it is ${run.note}.`;
  if (run.state === 'running') return `The run has found no sign yet; ${runPercent(run)} of its frames are done.`;
  if (run.kind === 'imported') return 'The run has no track yet. N draws one.';
  if (run.state === 'complete') return 'The run has found no sign. N draws a track by hand.';
  return `The run was ${run.state} after ${plural(run.frames_done, 'frame')}, and has found no sign in them.`;
}

/**
 * Whether there are no tracks because the run stopped early, so that it can be resumed.
 * @param {ReviewState} review
 * @param {number} total
 */
export function canResume({ run }, total) {
  return total === 0 && run !== null && isResumable(run);
}
