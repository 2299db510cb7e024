// @ts-check
import assert from 'node:assert/strict';
import test from 'node:test';

import { describeAge, defaultChoice, isChosen, describeReview } from '../../../static/js/model/training_sources.js';

/** @param {number} accepted @param {number} rejected @param {number} left */
const source = (accepted, rejected, left) => ({
  run: 'r',
  run_name: '',
  video: 'v',
  video_name: 'drive.mp4',
  edit_revision: 41,
  accepted,
  rejected,
  left,
});

test('videos are chosen by how far their review is', () => {
  const [done, begun, open] = [source(3, 1, 0), source(2, 0, 5), source(0, 0, 7)];
  assert.deepEqual(
    [done, begun, open].map((one) => isChosen(one, 'finished')),
    [true, false, false],
  );
  assert.deepEqual(
    [done, begun, open].map((one) => isChosen(one, 'begun')),
    [true, true, false],
  );
  assert.deepEqual([[done, open], [begun, open], [open], []].map(defaultChoice), ['finished', 'begun', 'all', 'all']);
  assert.equal(isChosen(source(0, 0, 0), 'finished'), false, 'of nothing nothing is finished');
});

test('a review says what it teaches and up to which edit', () => {
  assert.equal(describeReview(source(12, 1, 4)), '12 accepted, 1 false positive, 4 undecided, not used unless edited · up to edit 41');
  assert.equal(describeReview(source(2, 0, 0)), '2 accepted · up to edit 41');
});

test('a file shows edits and undos since, and a removed run', () => {
  assert.equal(describeAge(undefined), '');
  assert.equal(describeAge({ id: 'e', edits: 0, undone: 0, gone: [] }), '');
  assert.equal(
    describeAge({ id: 'e', edits: 3, undone: 1, gone: [] }),
    'Out of date: 3 edits were made since. 1 edit that it holds was undone since, but would still be used for training.',
  );
  assert.match(describeAge({ id: 'e', edits: 0, undone: 0, gone: ['a.mp4'] }), /^The run of a\.mp4 no longer exists/);
});
