// @ts-check
/** Routes of files: exports, recordings, bundles, imports. */

import { encode, queryText } from './http.js';
import { expectObject } from './shapes.js';
import { upload } from './upload.js';

/** @typedef {import('../types.js').Video} Video */
/** @typedef {import('../types.js').Run} Run */
/** @typedef {import('../types.js').Output} Output */
/** @typedef {import('./http.js').Call} Call */
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

const FORMAT = /** @type {const} */ ({
  name: 'string',
  title: 'string',
  summary: 'string',
  export_switches: 'array',
  import_switches: 'array',
});
const IMPORTED = /** @type {const} */ ({
  kind: 'string',
  id: 'string',
  tracks: 'number',
  boxes: 'number',
  repaired: 'array',
  skipped: 'array',
});

/** @param {import('./http.js').Routes} routes */
export const outputRoutes = ({ base, json, list, object }) => ({
  /** @param {{kind?: string, run?: string}} [query] @param {Call} [call] @returns {Promise<Output[]>} */
  outputs: (query = {}, call) => list('GET /outputs', [], OUTPUT, { ...call, query }, 'outputs'),
  /** @param {string} id @param {Call} [call] @returns {Promise<Output>} */
  output: (id, call) => object('GET /outputs/…', [id], OUTPUT, call),
  /** @param {string} id @param {Call} [call] @returns {Promise<void>} */
  removeOutput: (id, call) => json('DELETE /outputs/…', [id], call),
  /** @param {string} id @param {Call} [call] @returns {Promise<Output>} */
  cancelOutput: (id, call) => object('POST /outputs/…/cancel', [id], OUTPUT, call),
  /** @param {string} id @returns {string} address of the file */
  downloadUrl: (id) => `${base}/outputs/${encode(id)}/download`,
  /** @param {Call} [call] @returns {Promise<import('../types.js').Format[]>} */
  formats: (call) => list('GET /formats', [], FORMAT, call, 'formats'),
  /** @param {import('../types.js').ExportRequest} request @param {Call} [call] @returns {Promise<Output>} */
  startExport: (request, call) => object('POST /exports', [], OUTPUT, { ...call, body: request }),
  /** @param {string} run @param {{first: number, stop: number, frame?: number|null, track?: string|null, name?: string}} request @param {Call} [call] @returns {Promise<Output>} */
  record: (run, request, call) => object('POST /runs/…/recordings', [run], OUTPUT, { ...call, body: request }),
  /** @param {string} run @param {{first: number, stop: number, note: string, tracks?: string[]}} request @param {Call} [call] @returns {Promise<Output>} */
  makeBundle: (run, request, call) => object('POST /runs/…/bundles', [run], OUTPUT, { ...call, body: request }),
  /**
   * @param {File} file
   * @param {string|null} author
   * @param {Sending} [options]
   * @returns {Promise<{video: Video, run: Run, report: BundleReport}>}
   */
  importBundle: async (file, author, options) =>
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
  async importFile(video, file, query, options) {
    const url = `${base}/videos/${encode(video)}/imports${queryText({ file: file.name.slice(-255), ...query })}`;
    return expectObject('POST /videos/…/imports', await upload(url, file, { ...options, method: 'POST' }), IMPORTED);
  },
  /** The progress of an import, by the name that the import was given as `progress`. @param {string} name @param {Call} [call] @returns {Promise<import('../types.js').ImportProgress>} */
  importProgress: (name, call) => object('GET /imports/…', [name], { step: 'string', boxes: 'number', seconds: 'number' }, call),
  /** @param {string} name @param {Call} [call] @returns {Promise<void>} */
  cancelImport: (name, call) => json('POST /imports/…/cancel', [name], call),
});
