// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { clearestFrame } from '../../../static/js/model/clearest.js';
import { blankDoc, emptyDoc } from '../../../static/js/model/documents.js';
import { drive } from '../harness/synthetic.js';

const tracks = { ...drive(1000, 2).tracks, id: [1, 2], first: [10, 50], last: [40, 90], clearest: [36, 90] };
const whole = { track: 1, first: 10, last: 40 };
const key = { box: null, occluded: false, outside: false, interpolate: true, class_id: null, followed: false };

test('a track of the engine: its last detection', () => {
  assert.equal(clearestFrame(emptyDoc(whole), tracks), 36);
  assert.equal(clearestFrame({ ...emptyDoc(whole), gone: true }, tracks), null);
  assert.equal(clearestFrame(emptyDoc(whole), null), 10, 'nothing is known of it yet');
});

test('where a person has cut it off, or taken it out of sight, that frame is not its own', () => {
  assert.equal(clearestFrame(emptyDoc({ ...whole, last: 30 }), tracks), 10);
  assert.equal(clearestFrame({ ...emptyDoc(whole), keys: { 20: { ...key, outside: true } } }, tracks), 10);
});

test('merged tracks: the later one', () => {
  assert.equal(clearestFrame({ ...emptyDoc(whole), segments: [whole, { track: 2, first: 50, last: 90 }] }, tracks), 90);
});

test('a drawn track: the largest of its boxes', () => {
  const doc = { ...blankDoc('hab'), keys: { 5: { ...key, box: [0, 0, 9, 9] }, 8: { ...key, box: [0, 0, 12, 12] }, 9: { ...key, outside: true } } };
  assert.equal(clearestFrame(/** @type {any} */ (doc), tracks), 8);
});
