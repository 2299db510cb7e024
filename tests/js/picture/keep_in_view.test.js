// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { changeReview, openReview } from '../../../static/js/store/actions/review.js';
import { initialState } from '../../../static/js/store/initial.js';
import { createKeepInView } from '../../../static/js/views/picture/keep_in_view.js';
import { overlayTrack } from '../server_data.js';

const SCREEN = { width: 400, height: 300 };

/** @param {number} x */
const overlay = (x, frame = 0) => ({ frame, detections: [], tracks: [overlayTrack({ box: [x, 100, x + 20, 120] })] });

/** A zoomed view of a track that moves 20 px to the right per frame; returns a function that changes the review. */
function startReview() {
  const overlays = Object.fromEntries([0, 1, 2, 3, 4, 5, 6].map((frame) => [frame, overlay(100 + 20 * frame, frame)]));
  let state = openReview(initialState(), /** @type {any} */ ({ id: 'v', width: 1280, height: 720, frames: 7 }));
  const keepInView = createKeepInView();
  /** @param {Record<string, any>} change */
  const apply = (change) => {
    state = changeReview(state, /** @type {any} */ (change.frame === undefined ? change : { ...change, shown: change.frame }));
    const review = /** @type {import('../../../static/js/state-types.js').ReviewState} */ (state.review);
    const view = keepInView.nextViewport(review, SCREEN, false);
    state = changeReview(state, { viewport: view });
    return view;
  };
  apply({ overlays, frame: 0, selected: 'm1', viewport: { zoom: 4, x: 110, y: 110 } });
  return apply;
}

test('a track that leaves the view over time is followed at the same zoom', () => {
  const apply = startReview();
  const view = apply({ frame: 1 });
  assert.deepEqual(view, { zoom: 4, x: 110, y: 110 }, 'it is still visible');
  assert.equal(apply({ frame: 2 }), view);
  assert.deepEqual(apply({ frame: 3 }), { zoom: 4, x: 170, y: 110 });
  assert.deepEqual(apply({ frame: 0 }), { zoom: 4, x: 110, y: 110 }, 'back as well');
});

test('a view that was moved away from the track stays until the track is visible again', () => {
  const apply = startReview();
  const movedView = apply({ viewport: { zoom: 4, x: 600, y: 400 } });
  assert.deepEqual(movedView, { zoom: 4, x: 600, y: 400 });
  assert.equal(apply({ frame: 3 }), movedView);
  apply({ viewport: { zoom: 4, x: 180, y: 110 } });
  assert.deepEqual(apply({ frame: 6 }), { zoom: 4, x: 230, y: 110 });
});

test('a view zoomed into a corner of the box stays', () => {
  const apply = startReview();
  const closeView = apply({ viewport: { zoom: 30, x: 110, y: 110 } });
  assert.equal(closeView.zoom, 30);
  assert.equal(apply({ frame: 1 }), closeView);
});

test('the view stays while boxes are loading, and follows a track over a gap', () => {
  const apply = startReview();
  const view = apply({ frame: 1 });
  assert.equal(apply({ frame: 5, overlays: {}, run: { first: 0, frames_done: 7 } }), view);
  assert.equal(apply({ frame: 5, overlays: { 5: { frame: 5, detections: [], tracks: [] } } }), view, 'no box here');
  assert.deepEqual(apply({ frame: 6, overlays: { 6: overlay(220, 6) } }), { zoom: 4, x: 230, y: 110 });
});
