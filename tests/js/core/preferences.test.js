// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { setTheme } from '../../../static/js/store/actions/page.js';
import { openReview, toggleFewLabels, toggleLayer } from '../../../static/js/store/actions/review.js';
import { initialState } from '../../../static/js/store/initial.js';
import { createStore } from '../../../static/js/store/store.js';
import { rememberChoices, rememberedFewLabels, rememberedLayers, rememberedTheme } from '../../../static/js/core/preferences.js';
import { withStorage } from '../storage.js';

test('theme, layers and labels are remembered with the choice, whether or not the page is drawn', async (t) => {
  withStorage(t);
  const store = createStore(openReview(initialState(), /** @type {any} */ ({ id: 'v' })));
  rememberChoices(store);
  const truth = store.get().layers.truth;
  store.dispatch((state) => toggleFewLabels(toggleLayer(setTheme(state, 'dark'), 'truth')));
  await Promise.resolve();
  assert.deepEqual([rememberedTheme(), rememberedLayers().truth, rememberedFewLabels()], ['dark', !truth, true]);
});
