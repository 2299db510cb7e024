// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { changeReview, openReview } from '../../../static/js/store/actions/review.js';
import { initialState } from '../../../static/js/store/initial.js';
import { createKeepInView } from '../../../static/js/views/picture/keep_in_view.js';

const SCREEN = { width: 400, height: 300 };

/** @param {number} x */
const overlay = (x, frame = 0) => ({
  frame,
  detections: [],
  tracks: [
    {
      id: 1,
      state: 'confirmed',
      source: 0,
      box: [x, 100, x + 20, 120],
      class_id: 1,
      share: 1,
      prediction: null,
      gate: null,
      relocalisation: null,
    },
  ],
});

/** A track that goes 20 px to the right a frame, and a look at it frame by frame. */
function createViewer() {
  const overlays = Object.fromEntries([0, 1, 2, 3, 4, 5, 6].map((frame) => [frame, overlay(100 + 20 * frame, frame)]));
  let state = openReview(initialState(), /** @type {any} */ ({ id: 'v', width: 1280, height: 720, frames: 7 }));
  const keepInView = createKeepInView();
  /** @param {Record<string, any>} change */
  const showFrame = (change) => {
    state = changeReview(state, /** @type {any} */ (change.frame === undefined ? change : { ...change, shown: change.frame }));
    const review = /** @type {import('../../../static/js/state-types.js').ReviewState} */ (state.review);
    const view = keepInView.viewOf(review, SCREEN, false);
    state = changeReview(state, { viewport: view });
    return view;
  };
  showFrame({ overlays, frame: 0, selected: 'm1', viewport: { zoom: 4, x: 110, y: 110 } });
  return showFrame;
}

test('a track that leaves the sight as time goes on is followed, at the same zoom', () => {
  const see = createViewer();
  const view = see({ frame: 1 });
  assert.deepEqual(view, { zoom: 4, x: 110, y: 110 }, 'it is in sight still');
  assert.equal(see({ frame: 2 }), view);
  assert.deepEqual(see({ frame: 3 }), { zoom: 4, x: 170, y: 110 });
  assert.deepEqual(see({ frame: 0 }), { zoom: 4, x: 110, y: 110 }, 'back as well');
});

test('whoever has moved the view away from a track is left in peace, until it is in sight again', () => {
  const see = createViewer();
  const away = see({ viewport: { zoom: 4, x: 600, y: 400 } });
  assert.deepEqual(away, { zoom: 4, x: 600, y: 400 });
  assert.equal(see({ frame: 3 }), away);
  see({ viewport: { zoom: 4, x: 180, y: 110 } });
  assert.deepEqual(see({ frame: 6 }), { zoom: 4, x: 230, y: 110 });
});

test('a look at a corner, closer than the whole box, stays where it is', () => {
  const see = createViewer();
  const close = see({ viewport: { zoom: 30, x: 110, y: 110 } });
  assert.equal(close.zoom, 30);
  assert.equal(see({ frame: 1 }), close);
});

test('nothing moves while the boxes of a frame are on their way, and a track is followed over a gap', () => {
  const see = createViewer();
  const view = see({ frame: 1 });
  assert.equal(see({ frame: 5, overlays: {}, run: { first: 0, frames_done: 7 } }), view);
  assert.equal(see({ frame: 5, overlays: { 5: { frame: 5, detections: [], tracks: [] } } }), view, 'no box here');
  assert.deepEqual(see({ frame: 6, overlays: { 6: overlay(220, 6) } }), { zoom: 4, x: 230, y: 110 });
});
