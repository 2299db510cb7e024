// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { blankDoc, emptyDoc } from '../../../static/js/model/documents.js';
import {
  countExported,
  DEFAULT_STATES,
  DEFAULT_CHOICE,
  isVideoFile,
  namedSwitches,
  parseNumber,
  restoreChoice,
} from '../../../static/js/model/exchange.js';
import { keyFrame } from '../server_data.js';

const tracks = /** @type {any} */ ({
  id: [1, 2, 3],
  first: [0, 50, 90],
  last: [19, 99, 99],
  frames: [20, 25, 10],
  class_id: [14, 2, null],
});
/** @param {object} [more] */
const rule = (more = {}) => ({
  states: ['open', 'edited', 'accepted', 'needs_work', 'rejected'],
  labels: null,
  notInSet: 'class',
  first: 0,
  last: 2 ** 31 - 2,
  ...more,
});
/** @param {any[]} docs @param {any} asked */
const countExportedTracks = (docs, asked) => {
  const { tracks: signs, boxes, rejected } = countExported(tracks, docs, asked);
  return { tracks: signs, boxes, rejected };
};

test('without corrections every track of the engine is exported', () => {
  assert.deepEqual(countExportedTracks([], rule()), { tracks: 3, boxes: 20 + 25 + 10, rejected: 0 });
  assert.deepEqual(countExportedTracks([], rule({ states: ['accepted'] })), { tracks: 0, boxes: 0, rejected: 0 });
});

test('classes and frames cut the count; a track that is half inside counts half', () => {
  assert.deepEqual(countExportedTracks([], rule({ labels: new Set([14]) })), { tracks: 2, boxes: 30, rejected: 0 });
  assert.deepEqual(countExportedTracks([], rule({ first: 75, last: 95 })), { tracks: 2, boxes: Math.round(21 * 0.5) + 6, rejected: 0 });
});

test('corrections replace the engine’s values', () => {
  const span = { track: 2, first: 50, last: 99 };
  const rejected = { ...emptyDoc(span), review: /** @type {const} */ ('rejected') };
  const nothing = { ...emptyDoc({ track: 1, first: 0, last: 19 }), not_a_sign: true };
  const merged = { ...emptyDoc({ track: 3, first: 90, last: 99 }), gone: true };
  assert.deepEqual(countExportedTracks([rejected, nothing, merged], rule()), { tracks: 0, boxes: 0, rejected: 2 });
  assert.deepEqual(countExportedTracks([rejected, nothing, merged], rule({ states: ['accepted'] })), { tracks: 0, boxes: 0, rejected: 0 });
  const own = { ...blankDoc('hx'), class_id: 5, keys: { 10: keyFrame({ box: [0, 0, 9, 9] }) } };
  assert.deepEqual(countExportedTracks([own], rule({ labels: new Set([5]), notInSet: 'leave-out' })), { tracks: 1, boxes: 1, rejected: 0 });
});

test('a remembered choice is restored; invalid values are ignored', () => {
  const kept = {
    ...DEFAULT_CHOICE,
    format: 'yolo',
    states: ['accepted'],
    labels: ['stop', 'C,3a'],
    not_in_set: /** @type {const} */ ('ignore'),
    balance: true,
    switches: { yolo: { image: 'png' } },
  };
  assert.deepEqual(restoreChoice(JSON.stringify(kept)), kept);
  for (const text of [null, '', '{', '3', 'null', '[]']) assert.deepEqual(restoreChoice(text), DEFAULT_CHOICE, String(text));
  const odd = restoreChoice(
    '{"format": 3, "states": [], "labels": [3], "not_in_set": "x", "shares": ["1"], "pictures": "many", "switches": []}',
  );
  assert.deepEqual(odd, DEFAULT_CHOICE);
});

test('what stays behind is counted: open, and without a label of the set', () => {
  const own = { ...blankDoc('hx'), class_id: 5, keys: { 10: keyFrame({ box: [0, 0, 9, 9] }) } };
  const relabelled = { ...emptyDoc({ track: 2, first: 50, last: 99 }), class_id: 9 };
  const noted = { ...emptyDoc({ track: 1, first: 0, last: 19 }), notes: [{ id: 'n', frame: 3, text: 'x', author: 'A', time: '' }] };
  const found = countExported(tracks, [own, relabelled, noted], rule({ states: [...DEFAULT_STATES], notInSet: 'leave-out' }), (id) =>
    id === 9 ? 5 : id,
  );
  assert.deepEqual(
    [found.tracks, found.open, found.unlabelled, [...found.byLabel]],
    [2, 2, 0, [[5, 2]]],
    'a note is no edit; a merged label counts as the other',
  );
  assert.deepEqual(
    [countExported(tracks, [], rule({ notInSet: 'leave-out' })).unlabelled, countExported(tracks, [], rule({ notInSet: 'ignore' })).tracks],
    [1, 3],
  );
});

test('a choice of before label sets keeps what it can', () => {
  const before = restoreChoice('{"format": "yolo", "states": ["open", "accepted", "needs_work", "rejected"], "classes": [1]}');
  assert.deepEqual(before, { ...DEFAULT_CHOICE, format: 'yolo' });
});

test('typed numbers are numbers in their range', () => {
  const side = { name: 'The side', low: 0, high: 10, empty: null };
  assert.deepEqual(parseNumber('', side), { value: null });
  assert.deepEqual(parseNumber(' 2.5 ', side), { value: 2.5 });
  for (const text of ['11', '-1', 'x', '1e3', '0x1', 'NaN']) assert.ok('error' in parseNumber(text, side), text);
  assert.ok('error' in parseNumber('', { name: 'The seed', low: 0, high: 5, whole: true }));
  assert.ok('error' in parseNumber('1.5', { name: 'The seed', low: 0, high: 5, whole: true }));
});

test('videos are distinguished from annotations by name', () => {
  assert.deepEqual(
    ['a.MP4', 'b.mkv', 'c.xml', 'd.zip', 'mp4.json'].map((name) => isVideoFile({ name })),
    [true, true, false, false, false],
  );
});

test('the switches that a refusal names are found', () => {
  const formats = [['first_frame', 'size'], ['size', 'bad_boxes'], []].map((names) => ({
    import_switches: names.map((name) => /** @type {any} */ ({ name })),
  }));
  assert.deepEqual(namedSwitches('Choose the right video, or import with size=scale.', formats), ['size']);
  assert.deepEqual(namedSwitches('Import with first_frame=0 or first_frame=1.', formats), ['first_frame']);
  assert.deepEqual(namedSwitches('The box has the size 0.', formats), []);
});
