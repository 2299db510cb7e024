// @ts-check
/** Routes of files: exports, recordings, bundles, imports. */

import { encode, queryText } from './http.js';
import { expectList, expectObject } from './shapes.js';
import { upload } from './upload.js';

/** @typedef {import('../types.js').Video} Video */
/** @typedef {import('../types.js').Run} Run */
/** @typedef {{signal?: AbortSignal, timeout?: number}} Call */
/** @typedef {{onProgress?: (sent: number, total: number) => void, signal?: AbortSignal}} Sending */
/** @typedef {{note: string, video_name: string, first: number, stop: number, offset: number, frame: number, track: string|null, expected: {id: string, expected: string, met: boolean, got: string}[], corrections: number, other_pictures: number, skipped: string[], engine_version: string}} BundleReport */

const OUTPUT = /** @type {const} */ ({
  id: 'string',
  kind: 'string',
  name: 'string',
  state: 'string',
  options: 'object',
  summary: 'object',
});

/** @param {import('./http.js').Routes} setup */
export function outputRoutes({ base, json }) {
  return {
    /** @param {{kind?: string, run?: string}} [query] @param {Call} [call] @returns {Promise<import('../types.js').Output[]>} */
    outputs: async (query = {}, call) => {
      const answer = expectObject('GET /outputs', await json('/outputs', { ...call, query }), { outputs: 'array' });
      return expectList('GET /outputs', answer.outputs, OUTPUT);
    },
    /** @param {string} id @param {Call} [call] @returns {Promise<import('../types.js').Output>} */
    output: async (id, call) => expectObject('GET /outputs/…', await json(`/outputs/${encode(id)}`, call), OUTPUT),
    /** @param {string} id @param {Call} [call] @returns {Promise<void>} */
    removeOutput: (id, call) => json(`/outputs/${encode(id)}`, { ...call, method: 'DELETE' }),
    /** @param {string} id @param {Call} [call] @returns {Promise<import('../types.js').Output>} */
    cancelOutput: async (id, call) =>
      expectObject('POST /outputs/…/cancel', await json(`/outputs/${encode(id)}/cancel`, { ...call, method: 'POST' }), OUTPUT),
    /** @param {string} id @returns {string} address of the file */
    downloadUrl: (id) => `${base}/outputs/${encode(id)}/download`,
    /** @param {Call} [call] @returns {Promise<import('../types.js').Format[]>} */
    formats: async (call) =>
      expectList('GET /formats', expectObject('GET /formats', await json('/formats', call), { formats: 'array' }).formats, {
        name: 'string',
        title: 'string',
        summary: 'string',
        export_switches: 'array',
        import_switches: 'array',
      }),
    /** @param {import('../types.js').ExportRequest} request @param {Call} [call] @returns {Promise<import('../types.js').Output>} */
    startExport: async (request, call) =>
      expectObject('POST /exports', await json('/exports', { ...call, method: 'POST', body: request }), OUTPUT),
    /** @param {string} run @param {{first: number, stop: number, frame?: number|null, track?: string|null, name?: string}} request @param {Call} [call] @returns {Promise<import('../types.js').Output>} */
    record: async (run, request, call) =>
      expectObject(
        'POST /runs/…/recordings',
        await json(`/runs/${encode(run)}/recordings`, { ...call, method: 'POST', body: request }),
        OUTPUT,
      ),
    /** @param {string} run @param {{first: number, stop: number, note: string, tracks?: string[]}} request @param {Call} [call] @returns {Promise<import('../types.js').Output>} */
    makeBundle: async (run, request, call) =>
      expectObject('POST /runs/…/bundles', await json(`/runs/${encode(run)}/bundles`, { ...call, method: 'POST', body: request }), OUTPUT),
    /**
     * @param {File} file
     * @param {string|null} author
     * @param {Sending} [options]
     * @returns {Promise<{video: Video, run: Run, report: BundleReport}>}
     */
    importBundle: async (file, author, options = {}) =>
      expectObject(
        'POST /bundles',
        await upload(`${base}/bundles${queryText({ author, name: file.name })}`, file, { ...options, method: 'POST' }),
        { video: 'object', run: 'object', report: 'object' },
      ),
    /**
     * Import a file onto a video.
     *
     * @param {string} video
     * @param {File} file
     * @param {{as: 'annotation'|'truth'|'run', format?: string|null, run?: string|null, name?: string, switches?: string, label_map?: string, unknown?: 'refuse'|'add'|'skip', add?: string, author?: string|null, progress?: string}} query
     * @param {Sending} [options]
     * @returns {Promise<import('../types.js').ImportResult>}
     */
    importFile: async (video, file, query, options = {}) =>
      expectObject(
        'POST /videos/…/imports',
        await upload(`${base}/videos/${encode(video)}/imports${queryText({ file: file.name.slice(-255), ...query })}`, file, {
          ...options,
          method: 'POST',
        }),
        { kind: 'string', id: 'string', tracks: 'number', boxes: 'number', repaired: 'array', skipped: 'array' },
      ),
    /** The progress of an import, by the name that the import was given as `progress`. @param {string} name @param {Call} [call] @returns {Promise<import('../types.js').ImportProgress>} */
    importProgress: async (name, call) =>
      expectObject('GET /imports/…', await json(`/imports/${encode(name)}`, call), { step: 'string', boxes: 'number', seconds: 'number' }),
    /** @param {string} name @param {Call} [call] */
    cancelImport: async (name, call) => void (await json(`/imports/${encode(name)}/cancel`, { ...call, method: 'POST' })),
  };
}
