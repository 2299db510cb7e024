// @ts-check
import assert from 'node:assert/strict';
import test from 'node:test';

import { chosenTruth, nextTruth, truthAt } from '../../../static/js/review/chosen_truth.js';
import { initialReview, initialState } from '../../../static/js/store/initial.js';

/** @typedef {import('../../../static/js/types.js').Box} Box */

const VIDEO = /** @type {any} */ ({ id: 'v', width: 1280, height: 720 });
/** @param {number} track @param {Box} box */
const truth = (track, box) => ({ track, box, class_id: 14 });

/** @param {Partial<import('../../../static/js/state-types.js').ReviewState>} [more] */
function review(more = {}) {
  const start = initialReview(VIDEO, initialState().layers, false);
  const tracks = [
    { id: 1, box: [100, 100, 140, 140], state: 'confirmed', class_id: 14 },
    { id: 2, box: [300, 100, 340, 140], state: 'confirmed', class_id: 3 },
  ];
  return {
    ...start,
    layers: { ...start.layers, truth: true },
    truthId: 't',
    frame: 5,
    overlays: /** @type {any} */ ({ 5: { frame: 5, detections: [], tracks } }),
    truth: { 5: [truth(9, [500, 100, 540, 140]), truth(7, [110, 100, 150, 140])] },
    ...more,
  };
}

test('the current sign is the one that overlaps the selected track', () => {
  const found = chosenTruth(review({ selected: 'm1' }));
  assert.equal(found?.sign, 7);
  assert.equal(found?.on?.key, 'm1');
  assert.equal(found?.on?.iou.toFixed(2), '0.60');
  assert.equal(chosenTruth(review({ selected: 'm2' })), null);
  assert.equal(chosenTruth(review()), null);
});

test('a chosen sign takes precedence, also in frames without its box', () => {
  assert.deepEqual(chosenTruth(review({ selected: 'm1', truthSign: 9 })), { sign: 9, box: [500, 100, 540, 140], class_id: 14, on: null });
  assert.deepEqual(chosenTruth(review({ truthSign: 11 })), { sign: 11, box: null, class_id: null, on: null });
});

test('keys go from left to right, and round', () => {
  assert.equal(nextTruth(review()), 7);
  assert.equal(nextTruth(review({ truthSign: 7 })), 9);
  assert.equal(nextTruth(review({ truthSign: 9 })), 7);
  assert.equal(nextTruth(review({ frame: 6 })), null);
});

test('while the layer is hidden, no sign can be chosen', () => {
  const hidden = review({ truthSign: 7, layers: { ...review().layers, truth: false } });
  assert.deepEqual([chosenTruth(hidden), nextTruth(hidden), truthAt(hidden, 120, 120)], [null, null, null]);
});

test('a click finds the box under the pointer', () => {
  assert.deepEqual([truthAt(review(), 520, 120), truthAt(review(), 10, 10)], [9, null]);
});
