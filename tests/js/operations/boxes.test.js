// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { boxes } from '../../../static/js/operations/boxes.js';
import { changeReview, openReview, putOverlays, select } from '../../../static/js/store/actions/review.js';
import { initialState } from '../../../static/js/store/initial.js';

const box = /** @type {import('../../../static/js/types.js').Box} */ ([10, 10, 30, 30]);

/** A track in frames 3 to 5 is selected; the cursor is in a frame of which nothing has come yet. @param {number} frame */
function loadingState(frame) {
  const video = /** @type {any} */ ({ id: 'v', frames: 20, width: 100, height: 100 });
  const run = /** @type {any} */ ({ id: 'r', state: 'complete', first: 0, frames_done: 20 });
  const tracks = /** @type {any} */ ({ id: [1], first: [3], last: [5], class_id: [14] });
  const open = openReview({ ...initialState(), route: { screen: 'review', video: 'v', run: 'r', frame, track: null } }, video);
  return select(changeReview(open, { run, tracks, frame }), 'm1');
}

/** The boxes of the frame have come. @param {ReturnType<typeof loadingState>} state @param {boolean} hasBox   whether the track has one */
const withOverlay = (state, hasBox) =>
  putOverlays(
    state,
    'overlays',
    /** @type {any} */ ([
      { frame: state.review?.frame, detections: [], tracks: hasBox ? [{ id: 1, box, state: 'confirmed', class_id: 14 }] : [] },
    ]),
  );

/** Why a key does nothing now. @param {string} id @param {ReturnType<typeof loadingState>} state */
const disabledReason = (id, state) => boxes.find((one) => one.id === id)?.disabled(state);

test('what depends on the box of the frame waits for it, and does not carry another one there', () => {
  for (const id of ['key-frame', 'occluded', 'move-left']) {
    assert.equal(disabledReason(id, loadingState(4)), 'The boxes of this frame are still loading.', id);
    assert.equal(disabledReason(id, withOverlay(loadingState(4), true)), null, id);
  }
  assert.equal(disabledReason('key-frame', withOverlay(loadingState(9), false)), null, 'its nearest box is carried');
  assert.equal(disabledReason('move-left', withOverlay(loadingState(9), false)), 'The track has no box in this frame.');
});

test('a frame that the run has not got to is not waited for', () => {
  const state = changeReview(loadingState(9), (review) => ({ run: /** @type {any} */ ({ ...review.run, frames_done: 6 }) }));
  assert.equal(disabledReason('key-frame', state), null);
  assert.equal(disabledReason('move-left', state), 'The track has no box in this frame.');
});
