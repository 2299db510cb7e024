// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { stepToKeyFrame } from '../../../static/js/operations/navigate.js';
import { changeReview, seek, select } from '../../../static/js/store/actions/review.js';
import { createEditorFixture, setBox } from '../editing/editor_fixture.js';

test("with a track the key frames are the track's, and the last one says so; without one they are the video's", async () => {
  const { store, editor, review, end } = await createEditorFixture();
  const timebase = /** @type {any} */ ({
    frames: 200,
    nextKey: (/** @type {number} */ at) => at + 30,
    previousKey: (/** @type {number} */ at) => at - 30,
  });
  store.dispatch((state) => select(changeReview(state, { timebase }), 'm1'));
  /** @type {string[]} */
  const messages = [];
  /** @param {1|-1} direction */
  const press = (direction) => {
    stepToKeyFrame(/** @type {any} */ ({ store }), direction, (text) => messages.push(text));
    return review().frame;
  };
  assert.deepEqual([press(1), messages], [0, ['Track #1 has no key frame yet.']]);
  for (const frame of [20, 40]) editor.edit(setBox('m1', frame, 20));
  assert.deepEqual([press(1), press(1), press(1)], [20, 40, 40]);
  assert.deepEqual([press(-1), press(-1)], [20, 20]);
  assert.deepEqual(messages.slice(1), ['Track #1 has no later key frame.', 'Track #1 has no earlier key frame.']);
  store.dispatch((state) => seek(select(state, null), 50));
  assert.deepEqual([press(1), press(-1)], [80, 50]);
  await editor.settled();
  end();
});
