// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { blankDoc } from '../../../static/js/model/documents.js';
import { MAX_DIFFERENCES, differences, regionAround } from '../../../static/js/model/version_differences.js';
import { pluck } from '../pluck.js';
import { keyFrame } from '../server_data.js';

/** @typedef {import('../../../static/js/types.js').Box} Box */

/** @param {number} at @param {object} [more] */
const key = (at, more = {}) => keyFrame({ box: [at, at, at + 10, at + 10], ...more });
/** @param {Record<number, ReturnType<typeof key>>} keys @param {object} [more] */
const doc = (keys, more = {}) => ({ ...blankDoc('m1'), segments: [{ track: 1, first: 0, last: 50 }], keys, ...more });
/** The engine's box of the frames that are loaded. @param {number} _ @param {number} frame @returns {Box|null} */
const engineBox = (_, frame) => (frame < 20 ? [frame, 0, frame + 5, 5] : null);

test('frames in which the boxes differ, with what each version shows there', () => {
  const saved = doc({ 3: key(1), 8: key(2) });
  const mine = doc({ 3: key(1), 8: key(2.5) });
  assert.deepEqual(differences(saved, mine, engineBox, 0), [{ frame: 8, saved: [2, 2, 12, 12], mine: [2.5, 2.5, 12.5, 12.5] }]);
  assert.deepEqual(differences(saved, saved, engineBox, 0), []);
  assert.deepEqual(differences(saved, doc({ 3: key(1), 8: key(2.01) }), engineBox, 0), [], 'rounding moves nothing');
});

test('a version without a key frame shows the engine’s box; a deleted or hidden track shows nothing', () => {
  assert.deepEqual(differences(doc({}), doc({ 7: key(2, { interpolate: false }) }), engineBox, 0), [
    { frame: 7, saved: [7, 0, 12, 5], mine: [2, 2, 12, 12] },
  ]);
  assert.deepEqual(differences(doc({ 30: key(4) }, { gone: true }), doc({ 30: key(4) }), engineBox, 0), [
    { frame: 30, saved: null, mine: [4, 4, 14, 14] },
  ]);
  assert.deepEqual(differences(doc({ 30: key(4, { box: null, outside: true }) }), doc({ 30: key(4) }), engineBox, 0)[0].saved, null);
  assert.deepEqual(differences(undefined, doc({ 9: key(1) }), engineBox, 0), [{ frame: 9, saved: null, mine: [1, 1, 11, 11] }]);
  assert.deepEqual(differences(doc({ 30: key(0, { box: null }) }), doc({}), engineBox, 0), [], 'neither is known here');
});

test('of many frames those nearest to the cursor, in order', () => {
  const saved = doc(Object.fromEntries([2, 10, 14, 18, 40].map((frame) => [frame, key(1)])));
  const mine = doc(Object.fromEntries([2, 10, 14, 18, 40].map((frame) => [frame, key(3)])));
  assert.deepEqual(pluck(differences(saved, mine, engineBox, 15), 'frame'), [10, 14, 18]);
  assert.equal(MAX_DIFFERENCES, 3);
});

test('the part of the picture holds both boxes, is not too small and stays within', () => {
  const part = regionAround(
    [
      [100, 100, 140, 140],
      [120, 110, 160, 150],
    ],
    1280,
    720,
  );
  assert.deepEqual(part, { x: 130 - part.width / 2, y: 125 - part.height / 2, width: (part.height * 4) / 3, height: 125 });
  assert.equal(regionAround([[600, 300, 604, 304]], 1280, 720).height, 60);
  const corner = regionAround([[1260, 700, 1280, 720]], 1280, 720);
  assert.deepEqual([corner.x + corner.width, corner.y + corner.height], [1280, 720]);
  const whole = regionAround([[0, 0, 1280, 720]], 1280, 720);
  assert.deepEqual(whole, { x: 160, y: 0, width: 960, height: 720 });
});
