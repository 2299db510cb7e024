// @ts-check
/** Routes of runs and their stored results. */

import { encode, queryText } from './http.js';

/** @typedef {import('../types.js').Run} Run */
/** @typedef {import('./http.js').Call} Call */
/** @typedef {{preset: string, parameters: Record<string, unknown>, first?: number, stop?: number|null, name?: string}} RunRequest */
/**
 * @typedef {object} Explanation
 * @property {{axis: [number, number, number, number]|null, matches: [number, number, number, number, number][], magnitude: number, size: [number, number]}|null} symmetry
 * @property {{crop: string, mean: string, distance: number}|null} hash
 * @property {number|null} l_positive
 * @property {number} tau
 */

export const RUN = /** @type {const} */ ({
  id: 'string',
  video_id: 'string',
  state: 'string',
  preset: 'string',
  first: 'number',
  frames_done: 'number',
  summary: 'object',
});

const TRACK_COLUMNS = ['id', 'first', 'last', 'frames', 'detected', 'class_id', 'uncertainty', 'rank', 'reasons'];
const FLIPS = /** @type {const} */ ({ verdicts: 'number', to_confident: 'number', to_rejected: 'number', tracks: 'array' });

/** @param {import('./http.js').Routes} routes */
export const runRoutes = ({ base, json, list, object, columns }) => ({
  /** @param {string} video @param {Call} [call] @returns {Promise<Run[]>} */
  runs: (video, call) => list('GET /videos/…/runs', [video], RUN, call, 'runs'),
  /** @param {string} video @param {RunRequest} request @param {Call} [call] @returns {Promise<Run>} */
  startRun: (video, request, call) => object('POST /videos/…/runs', [video], RUN, { ...call, body: request }),
  /** Engine runs that are running or waiting, in queue order. @param {Call} [call] @returns {Promise<Run[]>} */
  runQueue: (call) => list('GET /run-queue', [], RUN, call, 'runs'),
  /** @param {string} id @param {string|null} before   the run to move it in front of; null: to the end of the queue @param {Call} [call] @returns {Promise<Run>} */
  moveRun: (id, before, call) => object('POST /runs/…/turn', [id], RUN, { ...call, body: { before } }),
  /** @param {string} id @param {Call} [call] @returns {Promise<Run>} */
  run: (id, call) => object('GET /runs/…', [id], RUN, call),
  /** @param {string} id @param {Call} [call] @returns {Promise<void>} */
  removeRun: (id, call) => json('DELETE /runs/…', [id], call),
  /** @param {string} id @param {string} name @param {Call} [call] @returns {Promise<Run>} */
  renameRun: (id, name, call) => object('PATCH /runs/…', [id], RUN, { ...call, body: { name } }),
  /** @param {string} id @param {Call} [call] @returns {Promise<string[]>} ids of the removed what-ifs */
  removeWhatIfs: async (id, call) => (await object('DELETE /runs/…/whatifs', [id], { removed: 'array' }, call)).removed,
  /** @param {string} id @param {Call} [call] @returns {Promise<Run>} */
  cancelRun: (id, call) => object('POST /runs/…/cancel', [id], RUN, call),
  /** @param {string} id @param {Call} [call] @returns {Promise<Run>} */
  resumeRun: (id, call) => object('POST /runs/…/resume', [id], RUN, call),
  /** @param {string} id @param {{parameters: Record<string, unknown>, name?: string}} request @param {Call} [call] @returns {Promise<Run>} */
  whatIf: (id, request, call) => object('POST /runs/…/whatif', [id], RUN, { ...call, body: request }),
  /** @param {string} run @param {Call} [call] @returns {Promise<import('../types.js').TrackColumns>} */
  tracks: (run, call) => columns('GET /runs/…/tracks', [run], TRACK_COLUMNS, { timeout: 60_000, ...call }),
  /** @param {string} run @param {Call} [call] @returns {Promise<import('../types.js').LaneColumns>} */
  lanes: (run, call) => columns('GET /runs/…/lanes', [run], ['track', 'first', 'last', 'source'], { timeout: 60_000, ...call }),
  /** @param {string} run @param {number} first @param {number} last   inclusive; <= 256 frames @param {Call} [call] @returns {Promise<import('../types.js').Overlay[]>} */
  overlays: (run, first, last, call) =>
    list(
      'GET /runs/…/overlays',
      [run],
      { frame: 'number', detections: 'array', tracks: 'array' },
      { ...call, query: { first, last } },
      'overlays',
    ),
  /** @param {string} run @param {number} track @param {Call} [call] @returns {Promise<import('../types.js').TrackLane>} */
  track: (run, track, call) => columns('GET /runs/…/tracks/…', [run, track], ['frame', 'source', 'box', 'score', 'l_positive'], call),
  /** @param {string} run @param {number} track @param {number} frame @param {number} [size]   longest side, px @returns {string} */
  cropUrl: (run, track, frame, size) => `${base}/runs/${encode(run)}/tracks/${track}/crops/${frame}${queryText({ size })}`,
  /** @param {string} run @param {number} tau @param {Call} [call] @returns {Promise<import('../types.js').Flips>} */
  flips: (run, tau, call) => object('GET /runs/…/flips', [run], FLIPS, { ...call, query: { tau } }),
  /** @param {string} run @param {number} track @param {number} frame @param {Call} [call] @returns {Promise<Explanation>} */
  explain: (run, track, frame, call) =>
    object('GET /runs/…/tracks/…/explain/…', [run, track, frame], { symmetry: 'nullable', hash: 'nullable', tau: 'number' }, call),
});
