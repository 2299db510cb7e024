// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { focusPoint, focusWords } from '../../../static/js/model/focus.js';

/** @param {Record<string, any>} summary */
const run = (summary) => /** @type {import('../../../static/js/types.js').Run} */ (/** @type {unknown} */ ({ summary }));
const video = { width: 960, height: 540 };

test('a focus is a place of the picture', () => {
  assert.deepEqual(focusPoint(run({ focus: { x: 0.5, y: 0.44, named: false } }), video), [480, 237.6]);
});

test('no run, an older one, an untold one and a video without a size have none', () => {
  assert.equal(focusPoint(null, video), null);
  assert.equal(focusPoint(run({}), video), null);
  assert.equal(focusPoint(run({ focus: null }), video), null);
  assert.equal(focusPoint(run({ focus: { x: 0.5, y: 0.44, named: false } }), { width: null, height: null }), null);
  assert.equal(focusWords(run({})), null);
});

test('words say where a focus comes from', () => {
  assert.equal(focusWords(run({ focus: { x: 0.5, y: 0.4419, named: false } })), '0.442 of the height, estimated from the drive');
  assert.equal(focusWords(run({ focus: { x: 0.5, y: 0.5, named: true } })), '0.500 of the height, as it was named');
});
