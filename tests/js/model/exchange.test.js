// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { blankDoc, emptyDoc } from '../../../static/js/model/documents.js';
import { countOut, DEFAULT_STATES, FIRST_CHOICE, isVideoFile, NO_CLASS, numberIn, restoreChoice } from '../../../static/js/model/exchange.js';

const tracks = /** @type {any} */ ({ id: [1, 2, 3], first: [0, 50, 90], last: [19, 99, 99], frames: [20, 25, 10], class_id: [14, 2, null] });
/** @param {object} [more] */
const rule = (more = {}) => ({ states: [...DEFAULT_STATES], classes: null, first: 0, last: 2 ** 31 - 2, ...more });

test('without corrections every track of the engine goes out', () => {
  assert.deepEqual(countOut(tracks, [], rule()), { tracks: 3, boxes: 20 + 25 + 10, rejected: 0 });
  assert.deepEqual(countOut(tracks, [], rule({ states: ['accepted'] })), { tracks: 0, boxes: 0, rejected: 0 });
});

test('classes and frames cut the count; a track that is half inside counts half', () => {
  assert.deepEqual(countOut(tracks, [], rule({ classes: [14, NO_CLASS] })), { tracks: 2, boxes: 30, rejected: 0 });
  assert.deepEqual(countOut(tracks, [], rule({ first: 75, last: 95 })), { tracks: 2, boxes: Math.round(21 * 0.5) + 6, rejected: 0 });
});

test('what people said about a track counts instead of the engine', () => {
  const span = { track: 2, first: 50, last: 99 };
  const rejected = { ...emptyDoc(span), review: /** @type {const} */ ('rejected') };
  const nothing = { ...emptyDoc({ track: 1, first: 0, last: 19 }), not_a_sign: true };
  const merged = { ...emptyDoc({ track: 3, first: 90, last: 99 }), gone: true };
  assert.deepEqual(countOut(tracks, [rejected, nothing, merged], rule()), { tracks: 0, boxes: 0, rejected: 2 });
  assert.deepEqual(countOut(tracks, [rejected, nothing, merged], rule({ states: ['accepted'] })), { tracks: 0, boxes: 0, rejected: 0 });
  const own = { ...blankDoc('hx'), class_id: 5, keys: { 10: { box: /** @type {any} */ ([0, 0, 9, 9]), occluded: false, outside: false, interpolate: true, class_id: null } } };
  assert.deepEqual(countOut(tracks, [own], rule({ classes: [5] })), { tracks: 1, boxes: 1, rejected: 0 });
});

test('what was remembered comes back; nonsense is as if nothing was', () => {
  const kept = { ...FIRST_CHOICE, format: 'yolo', states: ['accepted'], classes: [1, 2], switches: { yolo: { image: 'png' } } };
  assert.deepEqual(restoreChoice(JSON.stringify(kept)), kept);
  for (const text of [null, '', '{', '3', 'null', '[]']) assert.deepEqual(restoreChoice(text), FIRST_CHOICE, String(text));
  const odd = restoreChoice('{"format": 3, "states": [], "classes": ["x"], "shares": ["1"], "pictures": "many", "switches": []}');
  assert.deepEqual(odd, FIRST_CHOICE);
});

test('typed numbers are numbers in their range', () => {
  const side = { name: 'The side', low: 0, high: 10, empty: null };
  assert.deepEqual(numberIn('', side), { value: null });
  assert.deepEqual(numberIn(' 2.5 ', side), { value: 2.5 });
  for (const text of ['11', '-1', 'x', '1e3', '0x1', 'NaN']) assert.ok('error' in numberIn(text, side), text);
  assert.ok('error' in numberIn('', { name: 'The seed', low: 0, high: 5, whole: true }));
  assert.ok('error' in numberIn('1.5', { name: 'The seed', low: 0, high: 5, whole: true }));
});

test('videos are told from annotations by name', () => {
  assert.deepEqual(['a.MP4', 'b.mkv', 'c.xml', 'd.zip', 'mp4.json'].map((name) => isVideoFile({ name })), [true, true, false, false, false]);
});
