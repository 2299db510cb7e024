// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ApiError } from '../../../static/js/api/errors.js';
import { initialState } from '../../../static/js/store/initial.js';
import { createStore } from '../../../static/js/store/store.js';
import { startLiveUpdates } from '../../../static/js/views/live_updates.js';
import { waitUntil } from '../wait_until.js';

/** Updates over a stream whose events the test makes. @param {object} [parts]   of the app @param {Parameters<typeof startLiveUpdates>[1]} [options] */
function createFixture(parts = {}, options = {}) {
  /** @type {any} */
  let hooks;
  const store = createStore(initialState());
  const app = /** @type {any} */ ({
    store,
    api: {},
    signal: new AbortController().signal,
    receive: () => {},
    load: async () => {},
    ...parts,
  });
  const open = (/** @type {any} */ given) => ((hooks = given), /** @type {any} */ ({ retry: () => {} }));
  const updates = startLiveUpdates(app, { open, ...options });
  return { hooks, updates, store: /** @type {typeof store} */ (app.store) };
}

test('a full disk shows a banner until there is space or a new connection reports none', () => {
  const { hooks, store } = createFixture({ api: { session: async () => ({ version: '1.0.0' }) } });
  const shownBanners = () => store.get().banners.map((/** @type {{id: string, text: string}} */ banner) => [banner.id, banner.text]);
  hooks.onConnection('online');
  hooks.onStorage('The disk is full.');
  assert.deepEqual(shownBanners(), [['storage', 'The disk is full.']]);
  hooks.onStorage(null);
  assert.deepEqual(shownBanners(), []);
  hooks.onStorage('The disk is full.');
  hooks.onConnection('online');
  assert.deepEqual(shownBanners(), []);
});

test('the page loads once when the stream opens, or after a second without one', (t) => {
  t.mock.timers.enable({ apis: ['setTimeout'] });
  for (const isStreamLate of [false, true]) {
    let loadCount = 0;
    const load = () => ((loadCount += 1), new Promise(() => {}));
    const { hooks } = createFixture({ load });
    assert.equal(loadCount, 0);
    if (!isStreamLate) hooks.onConnection('online');
    t.mock.timers.tick(5000);
    assert.equal(loadCount, 1);
    if (isStreamLate) hooks.onConnection('online');
    assert.equal(loadCount, isStreamLate ? 2 : 1);
  }
});

test('a failed load is repeated when the server is back, and its banner is removed', async () => {
  let isOffline = true;
  const load = async () => {
    if (isOffline) throw new ApiError(0, 'offline', 'No answer.');
  };
  const lifetime = new AbortController();
  const { updates, store } = createFixture({ signal: lifetime.signal, load }, { retryDelayMs: 5 });
  const shownBanners = () => store.get().banners.map((/** @type {{id: string}} */ banner) => banner.id);
  await updates.reload();
  assert.deepEqual(shownBanners(), ['load']);
  isOffline = false;
  await waitUntil(() => shownBanners().length === 0);
  lifetime.abort();
});

test('a signed-out person is sent to sign in, but a page with work stays open', async () => {
  const denied = () => new ApiError(401, 'signed_out', 'Nobody is signed in here.');
  for (const session of [null, { person: { name: 'ann' } }]) {
    let signInCount = 0;
    const { hooks, store } = createFixture(
      {
        store: createStore(/** @type {any} */ ({ ...initialState(), session })),
        api: { session: async () => Promise.reject(denied()) },
      },
      { signIn: () => (signInCount += 1) },
    );
    hooks.onDenied();
    await new Promise((resolve) => setTimeout(resolve, 5));
    assert.equal(signInCount, session === null ? 1 : 0);
    assert.deepEqual(
      store.get().banners.map((/** @type {any} */ banner) => banner.action?.operation),
      session === null ? [] : ['sign-in'],
    );
  }
});

test('the page offers a reload only if the server has another version or build', async () => {
  let version = '1.0.0';
  let page = 'files-1';
  const api = { session: async () => ({ version, page }), outputs: async () => [], assignments: async () => [] };
  const load = async () => store.dispatch((state) => ({ ...state, session: /** @type {any} */ ({ version, page }) }));
  const { hooks, store } = createFixture({ api, load }, { files: 'files-1' });
  const reconnect = async () => {
    hooks.onConnection('offline');
    hooks.onConnection('online');
    await new Promise((resolve) => setTimeout(resolve, 5));
    return store.get().banners.map(({ text, action }) => [text, action?.operation]);
  };
  assert.deepEqual(await reconnect(), []);
  assert.deepEqual(await reconnect(), []);
  version = '1.1.0';
  const text = 'The server runs tsr 1.1.0 now, and this page is from 1.0.0. Reload it; unsaved changes are kept.';
  assert.deepEqual(await reconnect(), [[text, 'reload']]);
  version = '1.0.0';
  assert.deepEqual(await reconnect(), []);
  page = 'files-2';
  const built = 'The server runs another build of tsr 1.0.0 now, and this page is from an older one. Reload it; unsaved changes are kept.';
  assert.deepEqual(await reconnect(), [[built, 'reload']]);
  page = 'files-1';
  assert.deepEqual(await reconnect(), []);
});
