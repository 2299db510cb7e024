// @ts-check
/** Loads the runs of videos into the store. */

import { setRuns } from '../store/actions/page.js';

/** @typedef {Pick<import('../page-types.js').App, 'api'|'load'|'store'>} App */

/** @param {Pick<App, 'api'|'load'>} app @param {string} video @param {{signal?: AbortSignal}} [options] */
export const loadRuns = (app, video, options) =>
  app.load(
    () => app.api.runs(video, options),
    (state, runs) => setRuns(state, video, runs),
  );

/** Load the runs of a video unless the store has them. @param {App} app @param {string} video @param {{signal: AbortSignal}} options */
export async function loadMissingRuns(app, video, options) {
  if (!app.store.get().runs[video]) await loadRuns(app, video, options);
}
