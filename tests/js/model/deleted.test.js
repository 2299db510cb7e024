// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { deletedTracks, lastEdits, exampleFrame } from '../../../static/js/model/deleted.js';
import { OPEN_END, blankDoc } from '../../../static/js/model/documents.js';
import { keyFrame } from '../server_data.js';

/** @param {string} key @param {object} more */
const doc = (key, more) => ({ ...blankDoc(key), ...more });
/** @param {number} first @param {number} last */
const piece = (first, last) => [{ track: 1, first, last }];

test('deleted tracks are listed by their first frame, with their spans', () => {
  const box = keyFrame({ box: [0, 0, 9, 9] });
  const found = deletedTracks(
    {
      m3: doc('m3', { gone: true, segments: piece(40, 60) }),
      m1: doc('m1', { gone: true, segments: piece(10, OPEN_END) }),
      h00000001: doc('h00000001', { gone: true, keys: { 3: box, 30: box } }),
      m2: doc('m2', { segments: piece(0, 5) }),
      m4: doc('m4', { gone: true, merged_into: 'm2', segments: piece(0, 5) }),
      h00000002: doc('h00000002', { gone: true }),
    },
    () => 25,
  );
  assert.deepEqual(
    found.map(({ doc: { key }, first, last }) => [key, first, last]),
    [
      ['h00000001', 3, 30],
      ['m1', 10, 25],
      ['m3', 40, 60],
    ],
  );
});

test('the last author of a track is the person who deleted it, over several pages of the log', () => {
  const row = (/** @type {number} */ seq, /** @type {string} */ author, /** @type {string[]} */ ...keys) => ({
    seq,
    author,
    time: `t${seq}`,
    keys,
  });
  const first = lastEdits(new Map(), [row(1, 'Ann', 'm1', 'm2'), row(2, 'Bob', 'm1')]);
  assert.deepEqual(
    [...first],
    [
      ['m1', { author: 'Bob', time: 't2' }],
      ['m2', { author: 'Ann', time: 't1' }],
    ],
  );
  assert.deepEqual(lastEdits(first, [row(3, 'Cleo', 'm2')]).get('m2'), { author: 'Cleo', time: 't3' });
  assert.equal(first.get('m2')?.author, 'Ann');
});

test('the example picture is from the middle of the engine’s part, also while the track grows', () => {
  assert.deepEqual(exampleFrame(doc('m1', { segments: [{ track: 7, first: 10, last: OPEN_END }] }), 20), { track: 7, frame: 15 });
  assert.deepEqual(exampleFrame(doc('m1', { segments: piece(10, 13) }), 90), { track: 1, frame: 11 });
  assert.equal(exampleFrame(doc('h00000001', {}), 5), null);
});
