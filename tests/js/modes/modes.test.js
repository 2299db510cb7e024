// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { MODES, modeChange, modeOf } from '../../../static/js/modes/index.js';
import { pick, setMode, applyTrackClick } from '../../../static/js/store/actions/review.js';
import { initialReview, initialState } from '../../../static/js/store/initial.js';

/** @param {Partial<import('../../../static/js/state-types.js').ReviewState>} fields */
const stateWith = (fields) => ({ ...initialState(), review: { ...initialReview(/** @type {any} */ ({ id: 'v', frames: 9 })), ...fields } });
/** @param {import('../../../static/js/state-types.js').State} state */
const reviewOf = (state) => /** @type {import('../../../static/js/state-types.js').ReviewState} */ (state.review);

test('a merge begins with the selected track and forgets what was marked as it ends', () => {
  const merging = setMode(stateWith({ selected: 'm7' }), 'merge');
  assert.deepEqual([reviewOf(merging).mode, reviewOf(merging).marked], ['merge', ['m7']]);
  assert.deepEqual(reviewOf(setMode(stateWith({}), 'merge')).marked, []);
  const ended = reviewOf(setMode(merging, 'draw'));
  assert.deepEqual([ended.mode, ended.marked, ended.selected], ['draw', [], 'm7']);
});

test('a box in the hand is let go with every change of mode', () => {
  const review = reviewOf(stateWith({ drag: { box: [1, 1, 9, 9], key: 'm7' } }));
  for (const mode of /** @type {const} */ (['select', 'draw', 'merge'])) assert.equal(modeChange(review, mode).drag, null);
});

test('a click on a track marks it in a merge, marks it no longer, and selects it otherwise', () => {
  const merging = setMode(stateWith({}), 'merge');
  const marked = pick(pick(merging, 'm1'), 'm2');
  assert.deepEqual([reviewOf(marked).marked, reviewOf(marked).selected], [['m1', 'm2'], null]);
  assert.deepEqual(reviewOf(pick(marked, 'm1')).marked, ['m2']);
  assert.equal(reviewOf(pick(stateWith({}), 'm1')).selected, 'm1');
  assert.deepEqual(reviewOf(applyTrackClick(stateWith({}), 'm1')).marked, [], 'the usual mode takes no track');
});

test('every mode says over the picture what it waits for', () => {
  const review = reviewOf(stateWith({ run: /** @type {any} */ ({ id: 'r' }) }));
  assert.match(MODES.select.hint(review, false), /^Click a box/);
  assert.equal(MODES.select.hint({ ...review, selected: 'm7' }, false), '');
  assert.match(MODES.select.hint({ ...review, selected: 'm7' }, true), /no box in this frame/);
  assert.match(MODES.select.hint({ ...review, run: null }, false), /^No run yet/);
  assert.match(MODES.draw.hint(review, false), /^Drag a box/);
  const hints = [[], ['m1'], ['m1', 'm2']].map((marked) => modeOf({ ...review, mode: 'merge' }).hint({ ...review, marked }, false));
  assert.match(hints[0], /^Click the tracks/);
  assert.match(hints[1], /^Track #1 is marked/);
  assert.match(hints[2], /^Tracks #1, #2 are marked/);
});
