// @ts-check
/** Routes of runs and their stored results. */

import { encode, queryText } from './http.js';
import { expectColumns, expectList, expectObject } from './shapes.js';

/** @typedef {import('../types.js').Run} Run */
/** @typedef {{signal?: AbortSignal, timeout?: number}} Call */
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

/** @param {import('./http.js').Routes} setup */
export function runRoutes({ base, json }) {
  return {
    /** @param {string} video @param {Call} [call] @returns {Promise<Run[]>} */
    runs: async (video, call) => {
      const answer = expectObject('GET /videos/…/runs', await json(`/videos/${encode(video)}/runs`, call), { runs: 'array' });
      return expectList('GET /videos/…/runs', answer.runs, RUN);
    },
    /** @param {string} video @param {RunRequest} request @param {Call} [call] @returns {Promise<Run>} */
    startRun: async (video, request, call) =>
      expectObject('POST /videos/…/runs', await json(`/videos/${encode(video)}/runs`, { ...call, method: 'POST', body: request }), RUN),
    /** Engine runs that are running or waiting, in queue order. @param {Call} [call] @returns {Promise<Run[]>} */
    runQueue: async (call) => {
      const answer = expectObject('GET /run-queue', await json('/run-queue', call), { runs: 'array' });
      return expectList('GET /run-queue', answer.runs, RUN);
    },
    /** @param {string} id @param {string|null} before   the run to move it in front of; null: to the end of the queue @param {Call} [call] @returns {Promise<Run>} */
    moveRun: async (id, before, call) =>
      expectObject('POST /runs/…/turn', await json(`/runs/${encode(id)}/turn`, { ...call, method: 'POST', body: { before } }), RUN),
    /** @param {string} id @param {Call} [call] @returns {Promise<Run>} */
    run: async (id, call) => expectObject('GET /runs/…', await json(`/runs/${encode(id)}`, call), RUN),
    /** @param {string} id @param {Call} [call] @returns {Promise<void>} */
    removeRun: (id, call) => json(`/runs/${encode(id)}`, { ...call, method: 'DELETE' }),
    /** @param {string} id @param {string} name @param {Call} [call] @returns {Promise<Run>} */
    renameRun: async (id, name, call) =>
      expectObject('PATCH /runs/…', await json(`/runs/${encode(id)}`, { ...call, method: 'PATCH', body: { name } }), RUN),
    /** @param {string} id @param {Call} [call] @returns {Promise<string[]>} ids of the removed what-ifs */
    removeWhatIfs: async (id, call) =>
      expectObject('DELETE /runs/…/whatifs', await json(`/runs/${encode(id)}/whatifs`, { ...call, method: 'DELETE' }), { removed: 'array' })
        .removed,
    /** @param {string} id @param {Call} [call] @returns {Promise<Run>} */
    cancelRun: async (id, call) =>
      expectObject('POST /runs/…/cancel', await json(`/runs/${encode(id)}/cancel`, { ...call, method: 'POST' }), RUN),
    /** @param {string} id @param {Call} [call] @returns {Promise<Run>} */
    resumeRun: async (id, call) =>
      expectObject('POST /runs/…/resume', await json(`/runs/${encode(id)}/resume`, { ...call, method: 'POST' }), RUN),
    /** @param {string} id @param {{parameters: Record<string, unknown>, name?: string}} request @param {Call} [call] @returns {Promise<Run>} */
    whatIf: async (id, request, call) =>
      expectObject('POST /runs/…/whatif', await json(`/runs/${encode(id)}/whatif`, { ...call, method: 'POST', body: request }), RUN),
    /** @param {string} run @param {Call} [call] @returns {Promise<import('../types.js').TrackColumns>} */
    tracks: async (run, call) =>
      expectColumns('GET /runs/…/tracks', await json(`/runs/${encode(run)}/tracks`, { timeout: 60_000, ...call }), [
        'id',
        'first',
        'last',
        'frames',
        'detected',
        'class_id',
        'uncertainty',
        'rank',
        'reasons',
      ]),
    /** @param {string} run @param {Call} [call] @returns {Promise<import('../types.js').LaneColumns>} */
    lanes: async (run, call) =>
      expectColumns('GET /runs/…/lanes', await json(`/runs/${encode(run)}/lanes`, { timeout: 60_000, ...call }), [
        'track',
        'first',
        'last',
        'source',
      ]),
    /** @param {string} run @param {number} first @param {number} last   inclusive; <= 256 frames @param {Call} [call] @returns {Promise<import('../types.js').Overlay[]>} */
    overlays: async (run, first, last, call) => {
      const answer = expectObject(
        'GET /runs/…/overlays',
        await json(`/runs/${encode(run)}/overlays`, { ...call, query: { first, last } }),
        {
          overlays: 'array',
        },
      );
      return expectList('GET /runs/…/overlays', answer.overlays, { frame: 'number', detections: 'array', tracks: 'array' });
    },
    /** @param {string} run @param {number} track @param {Call} [call] @returns {Promise<import('../types.js').TrackLane>} */
    track: async (run, track, call) =>
      expectColumns('GET /runs/…/tracks/…', await json(`/runs/${encode(run)}/tracks/${track}`, call), [
        'frame',
        'source',
        'box',
        'score',
        'l_positive',
      ]),
    /** @param {string} run @param {number} track @param {number} frame @param {number} [size]   longest side, px @returns {string} */
    cropUrl: (run, track, frame, size) => `${base}/runs/${encode(run)}/tracks/${track}/crops/${frame}${queryText({ size })}`,
    /** @param {string} run @param {number} tau @param {Call} [call] @returns {Promise<import('../types.js').Flips>} */
    flips: async (run, tau, call) =>
      expectObject('GET /runs/…/flips', await json(`/runs/${encode(run)}/flips`, { ...call, query: { tau } }), {
        verdicts: 'number',
        to_confident: 'number',
        to_rejected: 'number',
        tracks: 'array',
      }),
    /** @param {string} run @param {number} track @param {number} frame @param {Call} [call] @returns {Promise<Explanation>} */
    explain: async (run, track, frame, call) =>
      expectObject('GET /runs/…/explain', await json(`/runs/${encode(run)}/tracks/${track}/explain/${frame}`, call), {
        symmetry: 'nullable',
        hash: 'nullable',
        tau: 'number',
      }),
  };
}
