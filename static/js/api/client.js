// @ts-check
/** Every route of the server as a typed function. Shapes: `../types.js`. All functions reject with `ApiError`. */

import { editRoutes } from './edits.js';
import { groundTruthRoutes } from './ground_truths.js';
import { createSend, readJson } from './http.js';
import { labelRoutes } from './labels.js';
import { modelRoutes } from './models.js';
import { outputRoutes } from './outputs.js';
import { peopleRoutes } from './people.js';
import { runRoutes } from './runs.js';
import { searchRoutes } from './search.js';
import { expectList, expectObject } from './shapes.js';
import { videoRoutes } from './videos.js';

/** @typedef {{signal?: AbortSignal, timeout?: number}} Call */

/** @typedef {ReturnType<typeof createApi>} Api */

/**
 * @param {{base?: string, fetch?: typeof fetch, signal?: AbortSignal}} [setup]
 *   base: prefix of every path; signal: cancels all requests
 */
export function createApi(setup = {}) {
  const base = setup.base ?? '/api';
  const send = createSend({ base, fetch: setup.fetch ?? globalThis.fetch.bind(globalThis), signal: setup.signal });
  /**
   * @param {string} path
   * @param {import('./http.js').RequestOptions} [options]
   */
  const json = async (path, options) => readJson(await send(path, options));
  const routes = { base, send, json };

  return {
    base,
    /** @param {Call} [call] @returns {Promise<import('../types.js').Session>} */
    session: async (call) =>
      expectObject('GET /session', await json('/session', call), { version: 'string', author: 'string', roots: 'array', presets: 'array' }),
    /** @param {Call} [call] @returns {Promise<import('../types.js').Parameter[]>} */
    parameters: async (call) =>
      expectList('GET /parameters', await json('/parameters', call), { section: 'string', name: 'string', type: 'string' }),
    ...videoRoutes(routes),
    ...runRoutes(routes),
    ...groundTruthRoutes(routes),
    ...outputRoutes(routes),
    ...modelRoutes(routes),
    ...editRoutes(routes),
    ...labelRoutes(base, json),
    ...peopleRoutes(json),
    ...searchRoutes(base, json),
  };
}
