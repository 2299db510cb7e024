// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { createTimebase } from '../../../static/js/model/timebase.js';

/** @type {[number, number][]} */
const STEPS = [
  [512, 4],
  [1024, 2],
  [256, 3],
];
const base = createTimebase({ frames: 10, time_base: [1, 12800], first_pts: 77, steps: STEPS, keys: [0, 4, 8], corrupt: [5] });
const seconds = [0];
for (const [step, count] of STEPS) for (let k = 0; k < count; k++) seconds.push(/** @type {number} */ (seconds.at(-1)) + step / 12800);

test('times of a variable rate come from the table', () => {
  for (let k = 0; k < 10; k++) assert.ok(Math.abs(base.secondsAt(k) - seconds[k]) < 1e-12, `frame ${k}`);
});

test('at a time the last frame shown at or before it is on screen', () => {
  for (let k = 0; k < 10; k++) {
    assert.equal(base.frameAt(seconds[k]), k);
    if (k < 9) assert.equal(base.frameAt((seconds[k] + seconds[k + 1]) / 2), k);
  }
  assert.equal(base.frameAt(-1), 0);
  assert.equal(base.frameAt(1e9), 9);
});

test('key frames before and after', () => {
  assert.deepEqual([base.nextKey(0), base.nextKey(5), base.nextKey(8)], [4, 8, null]);
  assert.deepEqual([base.previousKey(8), base.previousKey(5), base.previousKey(0)], [4, 4, null]);
  assert.deepEqual([base.isCorrupt(5), base.isCorrupt(4)], [true, false]);
});

test('one frame alone has a time', () => {
  const one = createTimebase({ frames: 1, time_base: [1, 25], first_pts: 0, steps: [], keys: [0], corrupt: [] });
  assert.deepEqual([one.secondsAt(0), one.frameAt(3), one.nextKey(0)], [0, 0, null]);
});
