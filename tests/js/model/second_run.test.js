// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { overlayableRuns } from '../../../static/js/model/second_run.js';
import { switchLayer } from '../../../static/js/operations/view.js';
import { initialReview, initialState } from '../../../static/js/store/initial.js';
import { pluck } from '../pluck.js';

test('every other run that has results can lie over the open one', () => {
  const runs = /** @type {any[]} */ (
    [
      ['a', 'complete', 9],
      ['b', 'queued', 0],
      ['c', 'running', 3],
      ['d', 'failed', 0],
      ['e', 'cancelled', 2],
    ].map(([id, state, frames_done]) => ({ id, state, frames_done }))
  );
  assert.deepEqual(pluck(overlayableRuns(runs, 'a'), 'id'), ['c', 'e']);
  assert.deepEqual(pluck(overlayableRuns(runs, null), 'id'), ['a', 'c', 'e']);
});

test('the layer of the second run asks which, until there is one; other layers just switch', () => {
  const state = { ...initialState(), review: initialReview(/** @type {any} */ ({ id: 'v' })) };
  const asked = switchLayer(state, 'second');
  assert.equal(asked.dialog?.kind, 'second');
  assert.equal(asked.review, state.review);
  const chosen = { ...state, review: { ...state.review, second: 'r' } };
  assert.deepEqual([switchLayer(chosen, 'second').dialog, switchLayer(chosen, 'second').review?.layers.second], [null, false]);
  assert.deepEqual([switchLayer(state, 'search').dialog, switchLayer(state, 'search').review?.layers.search], [null, true]);
});
