// @ts-check
/** Requests of the 3-D view. */

import { createSend, readJson } from '../../api/http.js';
import { expectObject } from '../../api/shapes.js';

/** @typedef {'volume'|'prior'|'drive'} Mode */
/** @typedef {{url: string, view: string, modes: {id: Mode, title: string}[]}} SceneView */
/** @typedef {{frame: number, track: string|null, view: string, mode?: Mode}} Cursor */
/** @typedef {{id: string, name: string, state: 'queued'|'running'|'complete'|'failed'|'cancelled', error: string|null}} SceneFile */
/** @typedef {ReturnType<typeof createScene3dApi>} Scene3dApi */

const FILE = /** @type {const} */ ({ id: 'string', name: 'string', state: 'string' });

/** @param {{base: string, signal?: AbortSignal, fetch?: typeof fetch}} setup   base: of the API */
export function createScene3dApi({ base, signal, fetch = globalThis.fetch.bind(globalThis) }) {
  const send = createSend({ base, fetch, signal });
  const e = encodeURIComponent;
  return {
    /** @param {string} run @param {string|null} view @returns {Promise<SceneView>} */
    scene3d: async (run, view) =>
      expectObject('GET /runs/…/scene3d', await readJson(await send(`/runs/${e(run)}/scene3d`, { query: { view } })), {
        url: 'string',
        view: 'string',
        modes: 'array',
      }),
    /** @param {string} run @param {Cursor} cursor @returns {Promise<void>} */
    move: async (run, cursor) => {
      await send(`/runs/${e(run)}/scene3d/cursor`, { method: 'POST', body: cursor });
    },
    /** @param {string} run @param {{mode: Mode, frame: number, track: string|null}} scene @returns {Promise<SceneFile>} */
    save: async (run, scene) =>
      expectObject('POST /runs/…/scenes', await readJson(await send(`/runs/${e(run)}/scenes`, { method: 'POST', body: scene })), FILE),
    /** @param {string} id @returns {Promise<SceneFile>} */
    file: async (id) => expectObject('GET /outputs/…', await readJson(await send(`/outputs/${e(id)}`)), FILE),
    /** @param {string} id @returns {string} */
    fileUrl: (id) => `${base}/outputs/${e(id)}/download`,
  };
}
