// @ts-check
/** Routes of model versions. */

/** @typedef {import('./http.js').Call} Call */

const MODEL = /** @type {const} */ ({
  id: 'string',
  name: 'string',
  state: 'string',
  figures: 'object',
  lineage: 'object',
  active: 'boolean',
});

/** @param {import('./http.js').Routes} routes */
export const modelRoutes = ({ json, list, object }) => ({
  /** @param {Call} [call] @returns {Promise<import('../types.js').ModelVersion[]>} */
  models: (call) => list('GET /models', [], MODEL, call, 'models'),
  /** @param {Call} [call] @returns {Promise<{reviews: import('../model/training_sources.js').ReviewSource[], exports: import('../model/training_sources.js').ExportAge[]}>} */
  trainingSources: (call) => object('GET /models/sources', [], { reviews: 'array', exports: 'array' }, call),
  /** @param {import('../types.js').ModelRequest} request @param {Call} [call] @returns {Promise<import('../types.js').ModelVersion>} */
  train: (request, call) => object('POST /models', [], MODEL, { ...call, body: request }),
  /** @param {string} id @param {'promote'|'cancel'|'resume'} what @param {Call} [call] @returns {Promise<import('../types.js').ModelVersion>} */
  changeModel: (id, what, call) => object(`POST /models/…/${what}`, [id], MODEL, call),
  /** @param {Call} [call] @returns {Promise<import('../types.js').ModelVersion>} the version that is active now */
  rollBackModels: (call) => object('POST /models/rollback', [], MODEL, call),
  /** @param {string} id @param {Call} [call] @returns {Promise<void>} */
  removeModel: (id, call) => json('DELETE /models/…', [id], call),
});
