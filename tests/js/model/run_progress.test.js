// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { isResumable, runShare, runPercent } from '../../../static/js/model/run_progress.js';

/** @param {Partial<import('../../../static/js/types.js').Run>} fields @returns {import('../../../static/js/types.js').Run} */
const run = (fields) => /** @type {any} */ ({ kind: 'engine', state: 'running', frames_done: 0, frames_total: 200, ...fields });

for (const [what, fields, part, percent] of /** @type {[string, Parameters<typeof run>[0], number, string][]} */ ([
  ['a run that has just begun', {}, 0, '0 %'],
  ['one under way', { frames_done: 85 }, 0.425, '42 %'],
  ['one that lacks a single frame', { frames_done: 199 }, 0.995, '99 %'],
  ['one that has found more frames than the file promised', { frames_done: 201 }, 1, '100 %'],
  ['one that does not know how long it is', { frames_done: 85, frames_total: null }, 0, '0 %'],
  ['one of a video without frames', { frames_total: 0 }, 0, '0 %'],
  ['a complete one, of however few frames', { state: 'complete', frames_done: 30, frames_total: null }, 1, '100 %'],
  ['one that was stopped', { state: 'cancelled', frames_done: 50 }, 0.25, '25 %'],
])) {
  test(`how far is ${what}`, () => assert.deepEqual([runShare(run(fields)), runPercent(run(fields))], [part, percent]));
}

test('every frame of a hundred is one per cent', () => {
  const every = Array.from({ length: 101 }, (_, frames_done) => frames_done);
  assert.deepEqual(
    every.map((frames_done) => runPercent(run({ frames_done, frames_total: 100 }))),
    every.map((k) => `${k} %`),
  );
});

test('only a run of the engine that has stopped early can go on', () => {
  const states = /** @type {const} */ (['queued', 'running', 'complete', 'failed', 'cancelled', 'interrupted']);
  assert.deepEqual(
    states.filter((state) => isResumable(run({ state }))),
    ['failed', 'cancelled', 'interrupted'],
  );
  for (const kind of /** @type {const} */ (['whatif', 'imported']))
    assert.deepEqual(
      states.filter((state) => isResumable(run({ kind, state }))),
      [],
    );
});
