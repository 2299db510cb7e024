// @ts-check
/** Routes of model versions. */

import { encode } from './http.js';
import { expectList, expectObject } from './shapes.js';

/** @typedef {{signal?: AbortSignal, timeout?: number}} Call */

const MODEL = /** @type {const} */ ({
  id: 'string',
  name: 'string',
  state: 'string',
  figures: 'object',
  lineage: 'object',
  active: 'boolean',
});

/** @param {import('./http.js').Routes} setup */
export function modelRoutes({ json }) {
  return {
    /** @param {Call} [call] @returns {Promise<import('../types.js').ModelVersion[]>} */
    models: async (call) =>
      expectList('GET /models', expectObject('GET /models', await json('/models', call), { models: 'array' }).models, MODEL),
    /** @param {Call} [call] @returns {Promise<{reviews: import('../model/training_sources.js').ReviewSource[], exports: import('../model/training_sources.js').ExportAge[]}>} */
    trainingSources: async (call) =>
      expectObject('GET /models/sources', await json('/models/sources', call), { reviews: 'array', exports: 'array' }),
    /** @param {import('../types.js').ModelRequest} request @param {Call} [call] @returns {Promise<import('../types.js').ModelVersion>} */
    train: async (request, call) => expectObject('POST /models', await json('/models', { ...call, method: 'POST', body: request }), MODEL),
    /** @param {string} id @param {'promote'|'cancel'|'resume'} what @param {Call} [call] @returns {Promise<import('../types.js').ModelVersion>} */
    changeModel: async (id, what, call) =>
      expectObject(`POST /models/…/${what}`, await json(`/models/${encode(id)}/${what}`, { ...call, method: 'POST' }), MODEL),
    /** @param {Call} [call] @returns {Promise<import('../types.js').ModelVersion>} the version that is active now */
    rollBackModels: async (call) =>
      expectObject('POST /models/rollback', await json('/models/rollback', { ...call, method: 'POST' }), MODEL),
    /** @param {string} id @param {Call} [call] @returns {Promise<void>} */
    removeModel: (id, call) => json(`/models/${encode(id)}`, { ...call, method: 'DELETE' }),
  };
}
