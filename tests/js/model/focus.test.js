// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { focusPoint, describeFocus } from '../../../static/js/model/focus.js';

/** @param {Record<string, any>} summary */
const run = (summary) => /** @type {import('../../../static/js/types.js').Run} */ (/** @type {unknown} */ ({ summary }));
const video = { width: 960, height: 540 };

test('a focus is a place of the picture', () => {
  assert.deepEqual(focusPoint(run({ focus: { x: 0.5, y: 0.44, named: false } }), video), [480, 237.6]);
});

test('there is no focus without a run, in an older run, if it is unknown, or without the video’s size', () => {
  assert.equal(focusPoint(null, video), null);
  assert.equal(focusPoint(run({}), video), null);
  assert.equal(focusPoint(run({ focus: null }), video), null);
  assert.equal(focusPoint(run({ focus: { x: 0.5, y: 0.44, named: false } }), { width: null, height: null }), null);
  assert.equal(describeFocus(run({})), null);
});

test('the description names the origin of a focus', () => {
  assert.equal(describeFocus(run({ focus: { x: 0.5, y: 0.4419, named: false } })), '0.442 of the height, estimated from the drive');
  assert.equal(describeFocus(run({ focus: { x: 0.5, y: 0.5, named: true } })), '0.500 of the height, as it was named');
});
