// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { canResume, whyNoTracks } from '../../../static/js/model/no_tracks.js';

const OPEN = { tracks: null, run: null, timebase: {} };

for (const [what, review, total, said] of /** @type {[string, any, number, string][]} */ ([
  ['a video whose table is still on its way', { ...OPEN, timebase: null }, 0, 'Loading the tracks…'],
  ['a video without a run', OPEN, 0, 'No run yet: start one with “Runs”.'],
  ['a run that waits', { ...OPEN, run: { state: 'queued' } }, 0, 'The run is waiting for its turn.'],
  [
    'a run that waits for another server',
    { ...OPEN, run: { state: 'queued', note: 'the server b has the video' } },
    0,
    'The run is waiting: the server b has the video.',
  ],
  ['a run whose tracks are on their way', { ...OPEN, run: { state: 'running' } }, 0, 'Loading the tracks…'],
  [
    'a run that has found nothing',
    { ...OPEN, run: { state: 'complete' }, tracks: { id: [] } },
    0,
    'The run has found no sign. N draws a track by hand.',
  ],
  [
    'a run that is drawn by hand',
    { ...OPEN, run: { state: 'complete', kind: 'imported' }, tracks: { id: [] } },
    0,
    'The run has no track yet. N draws one.',
  ],
  ['a run whose tracks are all deleted', { ...OPEN, run: { state: 'complete' }, tracks: { id: [1] } }, 0, 'Every track is deleted.'],
  [
    'a run that has found nothing yet',
    { ...OPEN, run: { state: 'running', frames_done: 85, frames_total: 200 }, tracks: { id: [] } },
    0,
    'The run has found no sign yet; 42 % of its frames are done.',
  ],
  [
    'a run that compiles kernels',
    { ...OPEN, run: { state: 'running', frames_done: 0, frames_total: 200, note: 'compiling' }, tracks: { id: [] } },
    0,
    'The run has found no sign yet: it is compiling.',
  ],
  [
    'a run that does not know how long it is',
    { ...OPEN, run: { state: 'running', frames_done: 85, frames_total: null }, tracks: { id: [] } },
    0,
    'The run has found no sign yet; 0 % of its frames are done.',
  ],
  [
    'a run that failed',
    { ...OPEN, run: { state: 'failed', error: 'Frame 7 cannot be decoded.' }, tracks: { id: [] } },
    0,
    'The run failed: Frame 7 cannot be decoded.',
  ],
  [
    'a run that failed without a word',
    { ...OPEN, run: { state: 'failed', error: null } },
    0,
    'The run failed: the terminal of the server says why.',
  ],
  [
    'a run that was cancelled',
    { ...OPEN, run: { state: 'cancelled', frames_done: 30 }, tracks: { id: [] } },
    0,
    'The run was cancelled after 30 frames, and has found no sign in them.',
  ],
  ['tracks that people drew before any run', OPEN, 2, ''],
])) {
  test(what, () => assert.equal(whyNoTracks(review, total), said));
}

test('only a run of the engine that has stopped early and shows nothing is offered to go on', () => {
  /** @param {string} state @param {string} [kind] @param {number} [total] */
  const offered = (state, kind = 'engine', total = 0) => canResume(/** @type {any} */ ({ ...OPEN, run: { state, kind } }), total);
  assert.deepEqual(
    ['queued', 'running', 'complete', 'failed', 'cancelled', 'interrupted'].map((state) => offered(state)),
    [false, false, false, true, true, true],
  );
  assert.equal(offered('failed', 'whatif'), false);
  assert.equal(offered('failed', 'engine', 3), false);
});
