// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { paintLayers } from '../../../static/js/views/picture/painter.js';
import { changeReview, hover, openReview, toggleFewLabels } from '../../../static/js/store/actions/review.js';
import { initialState } from '../../../static/js/store/initial.js';
import { fakeContext } from '../canvas.js';
import { overlayTrack } from '../server_data.js';

/** @param {number} id @param {number} x */
const track = (id, x) => overlayTrack({ id, box: [x, 10, x + 20, 30], class_id: id });

/** A state with three tracks, a detection of each and one of none, and a box of ground truth. */
function createState() {
  const detections = [1, 2, 3, null].map((of, i) => ({ box: [100 * i, 10, 100 * i + 20, 30], raw: i, prior: 0, score: i, track: of }));
  const overlay = { frame: 0, detections, tracks: [track(1, 0), track(2, 100), track(3, 200)] };
  const layers = {
    detections: true,
    predictions: true,
    search: true,
    relocalisations: true,
    results: true,
    corrected: true,
    truth: true,
    second: true,
  };
  const state = openReview(initialState(), /** @type {any} */ ({ id: 'v', width: 640, height: 360, frames: 10 }));
  return changeReview(
    state,
    /** @type {any} */ ({
      shown: 0,
      layers,
      overlays: { 0: overlay },
      truth: { 0: [{ box: [300, 10, 320, 30], class_id: 9, track: 1 }] },
      viewport: { zoom: 1, x: 320, y: 180 },
      selected: 'm2',
    }),
  );
}

/** The texts in the picture, and the counts of the layers. @param {import('../../../static/js/state-types.js').State} state */
function paintedTexts(state) {
  /** @type {string[]} */
  const texts = [];
  const ctx = fakeContext((name, [text]) => {
    if (name === 'fillText') texts.push(text);
  });
  const inks = { colour: () => '#fff', casing: '#000', font: '', unit: 1 };
  const review = /** @type {import('../../../static/js/state-types.js').ReviewState} */ (state.review);
  const counts = paintLayers(ctx, review, review.viewport, { width: 640, height: 360 }, inks, (id) => `class ${id}`);
  return { texts: texts.sort(), counts };
}

test('all tracks have labels, or only the selected and the hovered one; all boxes stay', () => {
  const all = paintedTexts(createState());
  assert.deepEqual(all.texts, ['0.0 → 0.0', '1.0 → 1.0', '2.0 → 2.0', '3.0 → 3.0', 'class 1', 'class 2', 'class 3', 'class 9']);
  const fewLabels = toggleFewLabels(createState());
  assert.deepEqual(paintedTexts(fewLabels).texts, ['1.0 → 1.0', 'class 2']);
  assert.deepEqual(paintedTexts(fewLabels).counts, all.counts);
  assert.deepEqual(paintedTexts(hover(fewLabels, 'm3')).texts, ['1.0 → 1.0', '2.0 → 2.0', 'class 2', 'class 3']);
  assert.deepEqual(paintedTexts(hover(hover(fewLabels, 'm3'), null)).texts, ['1.0 → 1.0', 'class 2']);
  assert.deepEqual(paintedTexts(toggleFewLabels(hover(fewLabels, 'm3'))).texts, all.texts);
});

test('the choice stays for the next video; with all labels the pointer changes nothing', () => {
  const fewLabels = toggleFewLabels(createState());
  assert.equal(openReview(fewLabels, /** @type {any} */ ({ id: 'w' })).review?.fewLabels, true);
  const all = createState();
  assert.equal(hover(all, 'm1'), all);
  const hovered = hover(fewLabels, 'm3');
  assert.equal(hover(hovered, 'm3'), hovered);
});
