// @ts-check
/**
 * Runs that can lie over another one. Pure.
 *
 * @typedef {import('../types.js').Run} Run
 */

/**
 * The other runs of the video that have results.
 * @param {readonly Run[]} runs   of the video
 * @param {string|null} open      the run that is on the screen
 * @returns {Run[]}
 */
export const layable = (runs, open) => runs.filter((run) => run.id !== open && (run.state === 'complete' || run.frames_done > 0));
