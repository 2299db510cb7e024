// @ts-check
/** Every route of the server as a typed function. Shapes: `../types.js`. All functions reject with `ApiError`. */

import { editRoutes } from './edits.js';
import { groundTruthRoutes } from './ground_truths.js';
import { createRoutes, createSend } from './http.js';
import { labelRoutes } from './labels.js';
import { modelRoutes } from './models.js';
import { outputRoutes } from './outputs.js';
import { peopleRoutes } from './people.js';
import { runRoutes } from './runs.js';
import { searchRoutes } from './search.js';
import { videoRoutes } from './videos.js';

/** @typedef {import('./http.js').Call} Call */

/** @typedef {ReturnType<typeof createApi>} Api */

/**
 * @param {{base?: string, fetch?: typeof fetch, signal?: AbortSignal}} [setup]
 *   base: prefix of every path; signal: cancels all requests
 */
export function createApi({ base = '/api', fetch = globalThis.fetch.bind(globalThis), signal } = {}) {
  const routes = createRoutes(base, createSend({ base, fetch, signal }));
  return {
    base,
    /** @param {Call} [call] @returns {Promise<import('../types.js').Session>} */
    session: (call) => routes.object('GET /session', [], { version: 'string', author: 'string', roots: 'array', presets: 'array' }, call),
    /** @param {Call} [call] @returns {Promise<import('../types.js').Parameter[]>} */
    parameters: (call) => routes.list('GET /parameters', [], { section: 'string', name: 'string', type: 'string' }, call),
    ...videoRoutes(routes),
    ...runRoutes(routes),
    ...groundTruthRoutes(routes),
    ...outputRoutes(routes),
    ...modelRoutes(routes),
    ...editRoutes(routes),
    ...labelRoutes(routes),
    ...peopleRoutes(routes),
    ...searchRoutes(routes),
  };
}
