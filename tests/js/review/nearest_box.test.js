// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { nearestBox } from '../../../static/js/review/nearest_box.js';

/** @param {number} x @returns {import('../../../static/js/types.js').Box} */
const box = (x) => [x, 0, x + 10, 10];
const lane = { frame: [10, 11, 12], box: [box(10), box(11), box(12)] };
const doc = { segments: [{ track: 7, first: 10, last: 11 }], keys: { 30: { box: box(30) }, 40: { box: null } } };
const review = /** @type {any} */ ({ docs: { m7: doc, h1: { segments: [], keys: {} } }, laneOf: { 7: lane, 8: lane } });

test('the nearest box is a corrected one, or one of the engine in the remaining parts', () => {
  for (const [key, frame, found] of /** @type {[string, number, number|null][]} */ ([
    ['m7', 0, 10],
    ['m7', 13, 11],
    ['m7', 25, 30],
    ['m7', 90, 30],
    ['m8', 20, 12],
    ['m9', 3, null],
    ['h1', 3, null],
  ])) {
    assert.deepEqual(nearestBox({ ...review, frame }, key)?.box ?? null, found === null ? null : box(found), `${key} at ${frame}`);
  }
});
