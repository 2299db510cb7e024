// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { closeReview, openReview, playOrPause, seek, toggleLayer } from '../../../static/js/store/actions/review.js';
import { DEFAULT_LAYERS, initialState } from '../../../static/js/store/initial.js';

const opened = () => openReview(initialState(), /** @type {any} */ ({ id: 'v', frames: 100 }));
/** @param {import('../../../static/js/state-types.js').State} state */
const playing = ({ review }) => [review?.frame, review?.playing];

test('layers that a person showed or hid are so in the next video', () => {
  let state = toggleLayer(toggleLayer(opened(), 'truth'), 'results');
  assert.deepEqual([state.review?.layers.truth, state.review?.layers.results], [true, false]);
  state = openReview(closeReview(state), /** @type {any} */ ({ id: 'w', frames: 9 }));
  assert.deepEqual(state.review?.layers, { ...DEFAULT_LAYERS, truth: true, results: false });
  assert.deepEqual(toggleLayer(closeReview(state), 'truth').layers, state.layers, 'without a review there is nothing to show');
});

test('playing begins where one is, at the end from the start, and stops where it is', () => {
  assert.deepEqual(playing(playOrPause(seek(opened(), 98))), [98, true]);
  assert.deepEqual(playing(playOrPause(seek(opened(), 99))), [0, true]);
  assert.deepEqual(playing(playOrPause(playOrPause(seek(opened(), 7)))), [7, false]);
  assert.equal(playOrPause(initialState()).review, null);
});
