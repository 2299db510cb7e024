// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { clearestFrame } from '../../../static/js/model/clearest.js';
import { blankDoc, emptyDoc } from '../../../static/js/model/documents.js';
import { syntheticRun } from '../harness/synthetic_run.js';
import { keyFrame } from '../server_data.js';

const tracks = { ...syntheticRun(1000, 2).tracks, id: [1, 2], first: [10, 50], last: [40, 90], clearest: [36, 90], side: [80, 60] };
const whole = { track: 1, first: 10, last: 40 };
const key = keyFrame();

test('the clearest frame of an engine track is the one in which the engine saw it best', () => {
  assert.equal(clearestFrame(emptyDoc(whole), tracks), 36);
  assert.equal(clearestFrame({ ...emptyDoc(whole), gone: true }, tracks), null);
  assert.equal(clearestFrame(emptyDoc(whole), null), 10, 'nothing is known of it yet');
});

test('if that frame was cut off or marked as outside, the nearest remaining frame is used', () => {
  assert.equal(clearestFrame(emptyDoc({ ...whole, last: 30 }), tracks), 30);
  assert.equal(clearestFrame({ ...emptyDoc(whole), keys: { 20: { ...key, outside: true } } }, tracks), 19);
  assert.equal(clearestFrame(emptyDoc({ ...whole, first: 38 }), tracks), 38);
});

test('of merged tracks, the part with the larger box counts', () => {
  const merged = { ...emptyDoc(whole), segments: [whole, { track: 2, first: 50, last: 90 }] };
  assert.equal(clearestFrame(merged, tracks), 36);
  assert.equal(clearestFrame(merged, { ...tracks, side: [60, 80] }), 90);
});

test('a drawn track: the largest of its boxes that the picture does not cut', () => {
  const doc = /** @type {any} */ ({
    ...blankDoc('hab'),
    keys: {
      5: { ...key, box: [10, 10, 19, 19] },
      8: { ...key, box: [10, 10, 22, 22] },
      9: { ...key, box: [80, 10, 100, 40] },
      12: { ...key, outside: true },
    },
  });
  assert.equal(clearestFrame(doc, tracks), 9);
  assert.equal(clearestFrame(doc, tracks, { width: 100, height: 60 }), 8);
  assert.equal(clearestFrame(doc, tracks, { width: 22, height: 22 }), 5, 'the one that the picture does not cut');
});
