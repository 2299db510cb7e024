// @ts-check
/** What the 3-D view asks the server for. */

import {createSend, readJson} from '../../api/http.js';
import {expectObject} from '../../api/shapes.js';

/** @typedef {'volume'|'prior'|'drive'} Mode */
/** @typedef {{url: string, view: string, modes: {id: Mode, title: string}[]}} Space */
/** @typedef {{frame: number, track: string|null, view: string, mode?: Mode}} Cursor */
/** @typedef {{id: string, name: string, state: 'queued'|'running'|'complete'|'failed'|'cancelled', error: string|null}} SceneFile */
/** @typedef {ReturnType<typeof createSpaceApi>} SpaceApi */

const FILE = /** @type {const} */ ({id: 'string', name: 'string', state: 'string'});

/** @param {{base: string, signal?: AbortSignal, fetch?: typeof fetch}} setup   base: of the API */
export function createSpaceApi({base, signal, fetch = globalThis.fetch.bind(globalThis)}) {
  const send = createSend({base, fetch, signal});
  const e = encodeURIComponent;
  return {
    /** @param {string} run @param {string|null} view @returns {Promise<Space>} */
    space: async (run, view) => expectObject('GET /runs/…/space', await readJson(await send(`/runs/${e(run)}/space`, {query: {view}})), {url: 'string', view: 'string', modes: 'array'}),
    /** @param {string} run @param {Cursor} cursor @returns {Promise<void>} */
    move: async (run, cursor) => {
      await send(`/runs/${e(run)}/space/cursor`, {method: 'POST', body: cursor});
    },
    /** @param {string} run @param {{mode: Mode, frame: number, track: string|null}} scene @returns {Promise<SceneFile>} */
    save: async (run, scene) => expectObject('POST /runs/…/scenes', await readJson(await send(`/runs/${e(run)}/scenes`, {method: 'POST', body: scene})), FILE),
    /** @param {string} id @returns {Promise<SceneFile>} */
    file: async (id) => expectObject('GET /artefacts/…', await readJson(await send(`/artefacts/${e(id)}`)), FILE),
    /** @param {string} id @returns {string} */
    fileUrl: (id) => `${base}/artefacts/${e(id)}/download`,
  };
}
