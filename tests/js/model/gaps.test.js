// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { firstGap } from '../../../static/js/model/gaps.js';
import { seededRandom } from '../harness/synthetic_run.js';

/** @param {number[]} marks @param {number} from @param {number} to @param {number} width */
const gap = (marks, from, to, width) => firstGap(from, to, width, marks.length, (i) => marks[i], 2);

test('the first room between marks', () => {
  assert.equal(gap([], 0, 10, 10), 0);
  assert.equal(gap([], 0, 10, 11), null);
  assert.equal(gap([3], 0, 20, 5), 5);
  assert.equal(gap([6], 0, 20, 4), 0);
  assert.equal(gap([0, 8, 20], 0, 40, 7), 10);
  assert.equal(gap([0, 8, 20], 0, 21, 9), null);
  assert.equal(gap([-50, -1], 0, 9, 5), 1);
});

test('it touches no mark, and there is none before it', () => {
  const next = seededRandom(5);
  for (let round = 0; round < 500; round += 1) {
    const marks = Array.from({ length: Math.floor(next() * 12) }, () => Math.floor(next() * 100)).sort((a, b) => a - b);
    const [from, width] = [Math.floor(next() * 30), 1 + Math.floor(next() * 20)];
    /** @param {number} at */
    const fits = (at) => at >= from && at + width <= 90 && marks.every((mark) => mark + 2 <= at || mark - 2 >= at + width);
    const wanted = Array.from({ length: 91 }, (_, at) => at).find(fits);
    assert.equal(gap(marks, from, 90, width), wanted ?? null, JSON.stringify({ marks, from, width }));
  }
});
