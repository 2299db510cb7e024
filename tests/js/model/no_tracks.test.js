// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { whyNoTracks } from '../../../static/js/model/no_tracks.js';

const OPEN = { tracks: null, run: null, timebase: {} };

for (const [what, review, total, said] of /** @type {[string, any, number, string][]} */ ([
  ['a video whose table is still on its way', { ...OPEN, timebase: null }, 0, 'Loading the tracks…'],
  ['a video without a run', OPEN, 0, 'No run yet: start one with “Runs”.'],
  ['a run that waits', { ...OPEN, run: { state: 'queued' } }, 0, 'The run is waiting for its turn.'],
  ['a run whose tracks are on their way', { ...OPEN, run: { state: 'running' } }, 0, 'Loading the tracks…'],
  ['a run that has found nothing', { ...OPEN, run: { state: 'complete' }, tracks: {} }, 0, 'No track yet.'],
  ['tracks that people drew before any run', OPEN, 2, ''],
])) {
  test(what, () => assert.equal(whyNoTracks(review, total), said));
}
