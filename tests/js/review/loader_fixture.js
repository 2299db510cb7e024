// @ts-check
/** A loader with an open run, for its tests. */

import { ApiError } from '../../../static/js/api/errors.js';
import { createLoader } from '../../../static/js/review/loader.js';
import { seek } from '../../../static/js/store/actions/review.js';
import { initialState } from '../../../static/js/store/initial.js';
import { createStore } from '../../../static/js/store/store.js';
import { FRAME_TABLE } from '../server_data.js';
import { tick } from '../wait_until.js';

/**
 * A loader with an open run. Requests for overlays are answered by the test.
 * @param {{answers?: Record<string, (...given: any[]) => Promise<any>>, track?: string|null}} [given]   routes with other answers; the track in the address
 * @param {Partial<Parameters<typeof createLoader>[1]>} [hooks]
 */
export async function createLoaderFixture({ answers = {}, track = null } = {}, hooks = {}) {
  const video = /** @type {any} */ ({ id: 'v', state: 'ready', latest_run: 'r', frames: 5000 });
  const run = /** @type {any} */ ({ id: 'r', state: 'complete', first: 0, frames_done: 5000 });
  const store = createStore({ ...initialState(), route: { screen: 'review', video: 'v', run: 'r', frame: 0, track } });
  /** @type {{first: number, answer: () => void}[]} */
  const overlayRequests = [];
  /** Tracks whose lanes were requested. @type {number[]} */
  const requestedLanes = [];
  /** The error of requests for lanes. @type {{thrown: Error|null}} */
  const failure = { thrown: null };
  /** Ground truths of the video, those that were removed, and requests for boxes. @type {{list: {id: string, name?: string}[], deleted: Set<string>, requested: string[]}} */
  const groundTruths = { list: [], deleted: new Set(), requested: [] };
  const api = /** @type {any} */ ({
    video: async () => video,
    runs: async () => [run],
    frameTable: async () => FRAME_TABLE,
    tracks: async () => null,
    lanes: async () => null,
    earlier: async () => null,
    groundTruths: async () => groundTruths.list,
    truthBoxes: async (/** @type {string} */ id, /** @type {number} */ first) => {
      groundTruths.requested.push(`${id}/${first}`);
      if (groundTruths.deleted.has(id)) throw new ApiError(404, 'not_found', `There is no truth '${id}'.`);
      return [];
    },
    annotation: async () => ({ docs: [{ key: 'm1' }] }),
    track: async (/** @type {string} */ _run, /** @type {number} */ id) => {
      requestedLanes.push(id);
      if (failure.thrown) throw failure.thrown;
      return { id, frame: [requestedLanes.length] };
    },
    overlays: (/** @type {string} */ _run, /** @type {number} */ first) =>
      new Promise((resolve) => {
        overlayRequests.push({ first, answer: () => resolve([{ frame: first, detections: [], tracks: [] }]) });
      }),
    ...answers,
  });
  const load = async (/** @type {() => Promise<any>} */ get, /** @type {any} */ action) => {
    const found = await get();
    store.dispatch(action, found);
  };
  const app = /** @type {any} */ ({ store, api, load, signal: new AbortController().signal });
  const loader = createLoader(app, { onOpened: () => {}, onClosed: () => {}, openFirst: () => {}, ...hooks });
  store.subscribe(() => loader.sync());
  loader.sync();
  for (let i = 0; i < 5; i++) await tick();
  return {
    store,
    overlayRequests,
    requestedLanes,
    failure,
    groundTruths,
    loader,
    moveTo: async (/** @type {number} */ frame) => {
      store.dispatch(seek, frame);
      await tick();
    },
  };
}
