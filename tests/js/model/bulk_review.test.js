// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { MAX_TRACKS_PER_OPERATION, tracksToReview, reviewCommands } from '../../../static/js/model/bulk_review.js';

/** @param {string} key @param {string} review @param {number|null} uncertainty */
const entry = (key, review, uncertainty) =>
  /** @type {import('../../../static/js/model/track_entries.js').TrackEntry} */ ({ key, review, uncertainty });
const SHOWN = [
  entry('m1', 'open', 0.9),
  entry('m2', 'open', 0.1),
  entry('m3', 'accepted', 0.1),
  entry('m4', 'needs_work', 0.2),
  entry('m5', 'rejected', 0),
];

test('a verdict is for those that it changes, that are sure enough and, if wanted, have none', () => {
  const all = { review: /** @type {const} */ ('accepted'), openOnly: true, maxUncertainty: 1 };
  assert.deepEqual(tracksToReview(SHOWN, all), ['m1', 'm2']);
  assert.deepEqual(tracksToReview(SHOWN, { ...all, maxUncertainty: 0.1 }), ['m2']);
  assert.deepEqual(tracksToReview(SHOWN, { ...all, openOnly: false }), ['m1', 'm2', 'm4', 'm5']);
  assert.deepEqual(tracksToReview(SHOWN, { ...all, review: 'open', openOnly: false }), ['m3', 'm4', 'm5']);
});

test('a track with unknown uncertainty is reviewed only without an uncertainty limit', () => {
  const shown = [entry('m1', 'open', null)];
  const wanted = { review: /** @type {const} */ ('accepted'), openOnly: true };
  assert.deepEqual(
    [tracksToReview(shown, { ...wanted, maxUncertainty: 1 }), tracksToReview(shown, { ...wanted, maxUncertainty: 0.99 })],
    [['m1'], []],
  );
});

test('many tracks are judged in few operations', () => {
  const keys = Array.from({ length: MAX_TRACKS_PER_OPERATION + 2 }, (_, at) => `m${at}`);
  const made = reviewCommands(keys, 'rejected', 7);
  assert.deepEqual(
    made.map(({ key, others }) => [key, others?.length]),
    [
      ['m0', MAX_TRACKS_PER_OPERATION - 1],
      [`m${MAX_TRACKS_PER_OPERATION}`, 1],
    ],
  );
  assert.deepEqual(made[1], {
    name: 'review_tracks',
    frame: 7,
    key: `m${MAX_TRACKS_PER_OPERATION}`,
    others: [`m${MAX_TRACKS_PER_OPERATION + 1}`],
    review: 'rejected',
  });
  assert.deepEqual(reviewCommands([], 'open', 0), []);
});
