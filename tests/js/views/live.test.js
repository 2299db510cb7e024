// @ts-check
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {initialState} from '../../../static/js/store/initial.js';
import {startLive} from '../../../static/js/views/live.js';

test('a full disk is a banner until there is room, or until another connection says nothing of it', () => {
  let state = /** @type {any} */ (initialState());
  /** @type {any} */
  let hooks;
  const store = {get: () => state, dispatch: (/** @type {(state: any) => any} */ action) => (state = action(state))};
  const app = /** @type {any} */ ({store, api: {}, signal: new AbortController().signal, hear: () => {}, load: async () => {}});
  startLive(app, {open: (options) => ((hooks = options), /** @type {any} */ ({retry: () => {}}))});
  const shown = () => state.banners.map((/** @type {{id: string, text: string}} */ banner) => [banner.id, banner.text]);
  hooks.onConnection('online');
  hooks.onStorage('The disk is full.');
  assert.deepEqual(shown(), [['storage', 'The disk is full.']]);
  hooks.onStorage(null);
  assert.deepEqual(shown(), []);
  hooks.onStorage('The disk is full.');
  hooks.onConnection('online');
  assert.deepEqual(shown(), []);
});
