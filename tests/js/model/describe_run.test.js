// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { replayWarning, runInexact, runProgress, runTitle } from '../../../static/js/model/describe_run.js';

/** @param {Record<string, any>} summary @returns {import('../../../static/js/types.js').Run} */
const replay = (summary) =>
  /** @type {any} */ ({ kind: 'whatif', state: 'complete', name: 'n = 60', created: '2026-11-21T06:20:00Z', summary });

test('a replay that lacked pixels is marked as not exact everywhere', () => {
  assert.equal(
    runInexact(replay({ missing_pixels: 1234, missing_frames: 1 })),
    'Not exact: 1,234 pixels in 1 frame are not in the evidence; the nearest stored ones were used instead. A new run with a larger keep_radius is exact.',
  );
  assert.match(runInexact(replay({ missing_pixels: 1, missing_frames: 1 })), /1 pixel in 1 frame is not/);
  assert.match(runTitle(replay({ missing_pixels: 9, missing_frames: 2 })), / \(not exact\)$/);
});

test('one that had all says nothing, nor does one of an older version', () => {
  for (const summary of [{ missing_pixels: 0, missing_frames: 0 }, {}]) {
    assert.equal(runInexact(replay(summary)), '');
    assert.doesNotMatch(runTitle(replay(summary)), /exact/);
  }
});

test('a run that compiles kernels says so instead of its speed', () => {
  const run = /** @type {any} */ ({ state: 'running', frames_done: 0, frames_total: 300, rate: null, remaining: null, note: '' });
  assert.equal(runProgress(run), '0 of 300 frames · starting');
  assert.equal(runProgress({ ...run, note: 'compiling' }), '0 of 300 frames · compiling');
  assert.equal(runProgress({ ...run, state: 'queued', note: 'compiling' }), 'Waiting · compiling');
  assert.equal(runProgress({ ...run, note: 'compiling', rate: 9, remaining: 30 }), '0 of 300 frames · compiling');
});

test('a search beyond the stored pixels gives a warning before the replay', () => {
  assert.match(replayWarning('search_radius', 41, 40), /up to 40 px .* not exact\.$/);
  assert.equal(replayWarning('search_radius', 40, 40), '');
  assert.equal(replayWarning('tau', 41, 40), '');
  assert.equal(replayWarning('search_radius', 41, undefined), '');
});
