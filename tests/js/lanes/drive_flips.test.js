// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { flippedTracks, nextFlippedTrack } from '../../../static/js/model/drive_flips.js';

const flips = {
  tau: 20,
  run_tau: 15,
  verdicts: 90,
  to_confident: 3,
  to_rejected: 1,
  tracks: [
    { id: 2, flips: 1, frame: 40 },
    { id: 5, flips: 1, frame: 12 },
    { id: 9, flips: 2, frame: 70 },
  ],
};
/** @param {string} key @param {Partial<import('../../../static/js/types.js').TrackDoc>} more @returns {import('../../../static/js/types.js').TrackDoc} */
const doc = (key, more) =>
  /** @type {import('../../../static/js/types.js').TrackDoc} */ (/** @type {unknown} */ ({ key, gone: false, segments: [], ...more }));

test('places are in the order of frames', () => {
  assert.deepEqual(flippedTracks(flips, {}), [
    { key: 'm5', frame: 12, flips: 1 },
    { key: 'm2', frame: 40, flips: 1 },
    { key: 'm9', frame: 70, flips: 2 },
  ]);
});

test('a deleted track has no place; a merged track has its place in the other track', () => {
  const docs = {
    m5: doc('m5', { gone: true }),
    m9: doc('m9', { gone: true }),
    m2: doc('m2', {
      segments: [
        { track: 2, first: 30, last: 50 },
        { track: 9, first: 60, last: 90 },
      ],
    }),
  };
  assert.deepEqual(flippedTracks(flips, docs), [
    { key: 'm2', frame: 40, flips: 1 },
    { key: 'm2', frame: 70, flips: 2 },
  ]);
});

test('next goes from place to place and wraps around', () => {
  const places = flippedTracks(flips, {});
  assert.equal(nextFlippedTrack(places, 'm5', 12)?.key, 'm2');
  assert.equal(nextFlippedTrack(places, 'm9', 70)?.key, 'm5');
  assert.equal(nextFlippedTrack(places, null, 41)?.key, 'm9', 'without a selection the next in time');
  assert.equal(nextFlippedTrack(places, 'm4', 71)?.key, 'm5');
  assert.equal(nextFlippedTrack([], 'm4', 71), null);
  const joined = [
    { key: 'm2', frame: 40, flips: 1 },
    { key: 'm2', frame: 70, flips: 2 },
    { key: 'm3', frame: 70, flips: 1 },
  ];
  assert.equal(nextFlippedTrack(joined, 'm2', 40)?.frame, 70, 'a merged track has two');
  assert.equal(nextFlippedTrack(joined, 'm2', 70)?.key, 'm3');
  assert.equal(nextFlippedTrack(joined, 'm2', 30)?.frame, 40);
});
