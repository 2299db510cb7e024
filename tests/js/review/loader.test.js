// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { createLoader } from '../../../static/js/review/loader.js';
import { changeReview, seek } from '../../../static/js/store/actions/review.js';
import { initialState } from '../../../static/js/store/initial.js';
import { createStore } from '../../../static/js/store/store.js';

const turn = () => new Promise((resolve) => setTimeout(resolve, 2));

/** A loader on an open run whose overlays come when the test says so. */
async function create() {
  const video = /** @type {any} */ ({ id: 'v', state: 'ready', latest_run: 'r', frames: 5000 });
  const run = /** @type {any} */ ({ id: 'r', state: 'complete', first: 0, frames_done: 5000 });
  const store = createStore({ ...initialState(), route: { screen: 'review', video: 'v', run: 'r', frame: 0, track: null } });
  /** @type {{first: number, come: () => void}[]} */
  const asked = [];
  const api = /** @type {any} */ ({
    video: async () => video,
    runs: async () => [run],
    frameTable: async () => ({ frames: 5000, time_base: [1, 25], first_pts: 0, steps: [[1, 4999]], keys: [0], corrupt: [] }),
    tracks: async () => null,
    lanes: async () => null,
    truths: async () => [],
    overlays: (/** @type {string} */ _run, /** @type {number} */ first) => new Promise((resolve) => {
      asked.push({ first, come: () => resolve([{ frame: first, detections: [], tracks: [] }]) });
    }),
  });
  const load = async (/** @type {() => Promise<any>} */ get, /** @type {any} */ action) => {
    const found = await get();
    store.dispatch((state) => action(state, found));
  };
  const app = /** @type {any} */ ({ store, api, load, signal: new AbortController().signal });
  const loader = createLoader(app, { opened: () => {}, closed: () => {} });
  store.subscribe(() => loader.sync());
  loader.sync();
  for (let i = 0; i < 5; i++) await turn();
  return { store, asked, go: async (/** @type {number} */ frame) => {
    store.dispatch((state) => seek(state, frame));
    await turn();
  } };
}

test('the cursor\'s own overlays come first, its neighbours when they are there', async () => {
  const { asked, go } = await create();
  assert.deepEqual(asked.map(({ first }) => first), [0]);
  asked[0].come();
  await turn();
  assert.deepEqual(asked.map(({ first }) => first), [0, 128]);
  await go(5); // nothing new is needed there
  assert.equal(asked.length, 2);
});

test('who scrubs has one request on its way, and the next is for where the cursor is then', async () => {
  const { asked, store, go } = await create();
  asked[0].come();
  await turn();
  const before = asked.length;
  for (const frame of [1000, 2000, 3000, 4000]) await go(frame);
  assert.deepEqual(asked.slice(before).map(({ first }) => first), [896]);
  asked[before].come();
  await turn();
  assert.deepEqual(asked.slice(before).map(({ first }) => first), [896, 3968]);
  assert.ok(store.get().review?.overlays[896]); // what came late is kept
});

test('overlays that had to make room are asked for again', async () => {
  const { asked, store, go } = await create();
  asked[0].come();
  await turn();
  await go(2000);
  asked.at(-1)?.come();
  await turn();
  store.dispatch((state) => changeReview(state, { overlays: {} }));
  await turn();
  assert.equal(asked.filter(({ first }) => first === 1920).length, 2);
});
