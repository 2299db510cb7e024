// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { AT_ONCE, judgeable, judgements } from '../../../static/js/model/bulk_review.js';

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
  const all = { review: /** @type {const} */ ('accepted'), openOnly: true, mostUncertainty: 1 };
  assert.deepEqual(judgeable(SHOWN, all), ['m1', 'm2']);
  assert.deepEqual(judgeable(SHOWN, { ...all, mostUncertainty: 0.1 }), ['m2']);
  assert.deepEqual(judgeable(SHOWN, { ...all, openOnly: false }), ['m1', 'm2', 'm4', 'm5']);
  assert.deepEqual(judgeable(SHOWN, { ...all, review: 'open', openOnly: false }), ['m3', 'm4', 'm5']);
});

test('a track whose uncertainty is not known is judged only where any uncertainty will do', () => {
  const shown = [entry('m1', 'open', null)];
  const wanted = { review: /** @type {const} */ ('accepted'), openOnly: true };
  assert.deepEqual(
    [judgeable(shown, { ...wanted, mostUncertainty: 1 }), judgeable(shown, { ...wanted, mostUncertainty: 0.99 })],
    [['m1'], []],
  );
});

test('many tracks are judged in few operations', () => {
  const keys = Array.from({ length: AT_ONCE + 2 }, (_, at) => `m${at}`);
  const made = judgements(keys, 'rejected', 7);
  assert.deepEqual(
    made.map(({ key, others }) => [key, others?.length]),
    [
      ['m0', AT_ONCE - 1],
      [`m${AT_ONCE}`, 1],
    ],
  );
  assert.deepEqual(made[1], { name: 'review_tracks', frame: 7, key: `m${AT_ONCE}`, others: [`m${AT_ONCE + 1}`], review: 'rejected' });
  assert.deepEqual(judgements([], 'open', 0), []);
});
