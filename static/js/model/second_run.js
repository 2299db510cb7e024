// @ts-check
/**
 * Runs that can be shown on top of another one. Pure.
 *
 * @typedef {import('../types.js').Run} Run
 */

/**
 * The other runs of the video that have results.
 * @param {readonly Run[]} runs   of the video
 * @param {string|null} open      the run on the screen
 * @returns {Run[]}
 */
export const overlayableRuns = (runs, open) => runs.filter((run) => run.id !== open && (run.state === 'complete' || run.frames_done > 0));
