// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ApiError } from '../../../static/js/api/errors.js';
import { initialState } from '../../../static/js/store/initial.js';
import { createStore } from '../../../static/js/store/store.js';
import { startLive } from '../../../static/js/views/live.js';
import { waitUntil } from '../wait_until.js';

test('a full disk is a banner until there is room, or until another connection says nothing of it', () => {
  /** @type {any} */
  let hooks;
  const store = createStore(initialState());
  const api = { session: async () => ({ version: '1.0.0' }) };
  const app = /** @type {any} */ ({ store, api, signal: new AbortController().signal, receive: () => {}, load: async () => {} });
  startLive(app, { open: (options) => ((hooks = options), /** @type {any} */ ({ retry: () => {} })) });
  const shown = () => store.get().banners.map((/** @type {{id: string, text: string}} */ banner) => [banner.id, banner.text]);
  hooks.onConnection('online');
  hooks.onStorage('The disk is full.');
  assert.deepEqual(shown(), [['storage', 'The disk is full.']]);
  hooks.onStorage(null);
  assert.deepEqual(shown(), []);
  hooks.onStorage('The disk is full.');
  hooks.onConnection('online');
  assert.deepEqual(shown(), []);
});

test('what could not be loaded without the server is loaded when it is back, and no banner stays', async () => {
  let away = true;
  const store = createStore(initialState());
  const load = async () => {
    if (away) throw new ApiError(0, 'offline', 'No answer.');
  };
  const life = new AbortController();
  const live = startLive(/** @type {any} */ ({ store, api: {}, signal: life.signal, receive: () => {}, load }), {
    open: () => /** @type {any} */ ({ retry: () => {} }),
    again: 5,
  });
  const shown = () => store.get().banners.map((/** @type {{id: string}} */ banner) => banner.id);
  await live.reload();
  assert.deepEqual(shown(), ['load']);
  away = false;
  await waitUntil(() => shown().length === 0);
  life.abort();
});

test('who is signed out goes to sign in, and keeps a page that holds work', async () => {
  const denied = () => new ApiError(401, 'signed_out', 'Nobody is signed in here.');
  for (const session of [null, { person: { name: 'ann' } }]) {
    const store = createStore(/** @type {any} */ ({ ...initialState(), session }));
    /** @type {any} */
    let hooks;
    let left = 0;
    const api = { session: async () => Promise.reject(denied()) };
    startLive(/** @type {any} */ ({ store, api, signal: new AbortController().signal, receive: () => {}, load: async () => {} }), {
      open: (options) => ((hooks = options), /** @type {any} */ ({ retry: () => {} })),
      signIn: () => (left += 1),
    });
    hooks.onDenied();
    await new Promise((resolve) => setTimeout(resolve, 5));
    assert.equal(left, session === null ? 1 : 0);
    assert.deepEqual(
      store.get().banners.map((/** @type {any} */ banner) => banner.action?.operation),
      session === null ? [] : ['sign-in'],
    );
  }
});

test('a page of an older version than the server offers to reload, and does so only after an upgrade', async () => {
  /** @type {any} */
  let hooks;
  let version = '1.0.0';
  const store = createStore(initialState());
  const api = { session: async () => ({ version }), outputs: async () => [], assignments: async () => [] };
  const load = async () => store.dispatch((state) => ({ ...state, session: /** @type {any} */ ({ version }) }));
  startLive(/** @type {any} */ ({ store, api, signal: new AbortController().signal, receive: () => {}, load }), {
    open: (options) => ((hooks = options), /** @type {any} */ ({ retry: () => {} })),
  });
  const again = async () => {
    hooks.onConnection('offline');
    hooks.onConnection('online');
    await new Promise((resolve) => setTimeout(resolve, 5));
    return store.get().banners.map(({ text, action }) => [text, action?.operation]);
  };
  assert.deepEqual(await again(), []);
  assert.deepEqual(await again(), []);
  version = '1.1.0';
  const text = 'The server runs tsr 1.1.0 now, and this page is from 1.0.0. Reload it; unsaved changes are kept.';
  assert.deepEqual(await again(), [[text, 'reload']]);
  version = '1.0.0';
  assert.deepEqual(await again(), []);
});
