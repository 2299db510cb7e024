// @ts-check
/** Requests of the recording view. */

import { createSend, readJson } from '../../api/http.js';
import { expectList, expectObject } from '../../api/shapes.js';

/**
 * A recording as the server lists it.
 *
 * @typedef {object} Recording
 * @property {string} id
 * @property {string} name
 * @property {'queued'|'running'|'complete'|'failed'|'cancelled'} state
 * @property {string|null} error
 * @property {{first: number, stop: number}} options
 * @property {number|null} size     bytes
 * @property {{edits?: number}} [summary]   edits: number of the last edit in the recording
 */
/** @typedef {{ready: boolean, version: string, message: string}} ViewerState */
/** @typedef {{first: number, stop: number, frame: number|null, track: string|null}} RecordingRequest */
/** @typedef {ReturnType<typeof createRecordingApi>} RecordingApi */

const RECORDING = /** @type {const} */ ({ id: 'string', name: 'string', state: 'string', options: 'object' });
/** Time limit of the first request for the viewer, which unpacks it from the SDK, ms. */
const VIEWER_TIMEOUT_MS = 120_000;

/** @param {{base: string, signal?: AbortSignal, fetch?: typeof fetch}} setup   base: of the API */
export function createRecordingApi({ base, signal, fetch = globalThis.fetch.bind(globalThis) }) {
  const send = createSend({ base, fetch, signal });
  const sendOutsideApi = createSend({ base: '', fetch, signal });
  const e = encodeURIComponent;
  return {
    /** Recordings of a run, newest first. @param {string} run @returns {Promise<Recording[]>} */
    list: async (run) => {
      const answer = expectObject('GET /outputs', await readJson(await send('/outputs', { query: { kind: 'recording', run } })), {
        outputs: 'array',
      });
      return expectList('GET /outputs', answer.outputs, RECORDING);
    },
    /** @param {string} id @returns {Promise<Recording>} */
    get: async (id) => expectObject('GET /outputs/…', await readJson(await send(`/outputs/${e(id)}`)), RECORDING),
    /** @param {string} run @param {RecordingRequest} request @returns {Promise<Recording>} */
    make: async (run, request) =>
      expectObject(
        'POST /runs/…/recordings',
        await readJson(await send(`/runs/${e(run)}/recordings`, { method: 'POST', body: request })),
        RECORDING,
      ),
    /** @param {string} id @returns {string} address of the file, for people */
    downloadUrl: (id) => `${base}/outputs/${e(id)}/download`,
    /** @param {string} id @returns {string} address of the file, for the viewer */
    viewerUrl: (id) => `/rerun/recordings/${e(id)}.rrd`,
    /** @returns {Promise<ViewerState>} */
    viewer: async () =>
      expectObject('GET /rerun/state', await readJson(await sendOutsideApi('/rerun/state', { timeout: VIEWER_TIMEOUT_MS })), {
        ready: 'boolean',
        version: 'string',
        message: 'string',
      }),
  };
}
