// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { setTheme } from '../../../static/js/store/actions/page.js';
import { openReview, toggleFewLabels, toggleLayer } from '../../../static/js/store/actions/review.js';
import { initialState } from '../../../static/js/store/initial.js';
import { createStore } from '../../../static/js/store/store.js';
import { rememberChoices, rememberedFewLabels, rememberedLayers, rememberedTheme } from '../../../static/js/core/preferences.js';

test('theme, layers and labels are remembered with the choice, whether or not the page is drawn', async () => {
  /** @type {Map<string, string>} */
  const kept = new Map();
  Object.defineProperty(globalThis, 'localStorage', {
    configurable: true,
    value: {
      getItem: (/** @type {string} */ name) => kept.get(name) ?? null,
      setItem: (/** @type {string} */ name, /** @type {string} */ value) => kept.set(name, value),
    },
  });
  const store = createStore(openReview(initialState(), /** @type {any} */ ({ id: 'v' })));
  rememberChoices(store);
  const truth = store.get().layers.truth;
  store.dispatch((state) => toggleFewLabels(toggleLayer(setTheme(state, 'dark'), 'truth')));
  await Promise.resolve();
  assert.deepEqual([rememberedTheme(), rememberedLayers().truth, rememberedFewLabels()], ['dark', !truth, true]);
  Reflect.deleteProperty(globalThis, 'localStorage');
});
