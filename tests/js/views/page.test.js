// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { arrange } from '../../../static/js/model/library_order.js';
import { describeVersion as describeDoc, differingKeyFrames } from '../../../static/js/views/dialogs/conflict.js';
import { truncatedMessage } from '../../../static/js/views/dialogs/add_video.js';
import { groupOperations } from '../../../static/js/views/dialogs/help.js';
import { SPEED_LABELS as LABELS } from '../labels.js';
import { tooltipPlace } from '../../../static/js/views/tooltip.js';
import { describeSaveState } from '../../../static/js/views/topbar.js';
import { findParameters, parseValue, presetValue } from '../../../static/js/views/parameter_fields.js';
import { changedFrameCount, listChanges } from '../../../static/js/views/whatif_changes.js';
import { pluck, rowsOf } from '../pluck.js';
import { keyFrame } from '../server_data.js';

/** @param {Partial<import('../../../static/js/types.js').Parameter>} [more] @returns {import('../../../static/js/types.js').Parameter} */
const parameter = (more = {}) => ({
  section: 'gate',
  name: 'tau',
  type: 'number',
  default: 15,
  low: 0,
  high: 100,
  choices: null,
  description: 'largest L that is confident',
  replayable: true,
  presets: { paper: 10 },
  ...more,
});

test('typed values are checked against type and range', () => {
  assert.deepEqual(parseValue(parameter(), ' 2.5e1 '), { value: 25 });
  assert.deepEqual(parseValue(parameter(), '.5'), { value: 0.5 });
  for (const [text, word] of [
    ['', 'number'],
    ['NaN', 'number'],
    ['Infinity', 'number'],
    ['0x10', 'number'],
    ['-1', 'below 0'],
    ['101', 'above 100'],
  ]) {
    const result = parseValue(parameter(), text);
    assert.ok('error' in result && result.error.toLowerCase().includes(word), `${text}: ${JSON.stringify(result)}`);
  }
  assert.ok('error' in parseValue(parameter({ type: 'integer' }), '2.5'));
  assert.deepEqual(parseValue(parameter({ default: null }), ''), { value: null });
  assert.deepEqual(parseValue(parameter({ type: 'text', default: [1, 2] }), '1, 2 3'), { value: [1, 2, 3] });
  assert.ok('error' in parseValue(parameter({ type: 'choice', choices: ['a', 'b'] }), 'c'));
  assert.deepEqual(parseValue(parameter({ type: 'boolean' }), 'false'), { value: false });
});

test('a preset differs from the default only in its own values', () => {
  assert.equal(presetValue(parameter(), 'paper'), 10);
  assert.equal(presetValue(parameter(), 'default'), 15);
  assert.equal(presetValue(parameter({ presets: { paper: null } }), 'paper'), null);
});

test('the message for a truncated folder says how many entries are listed and what to do', () => {
  const videos = Array.from({ length: 1999 }, (_, k) => ({ name: `${k}.mp4`, path: `/v/${k}.mp4`, size: 1 }));
  assert.match(truncatedMessage({ folders: ['a'], videos }), /first 2,000 folders and videos .* Type the path/);
});

test('parameters are found by name and by meaning, names first', () => {
  const all = [parameter({ name: 'delta', description: 'like tau, of the classifier' }), parameter()];
  assert.deepEqual(pluck(findParameters(all, 'tau'), 'name'), ['tau', 'delta']);
  assert.deepEqual(pluck(findParameters(all, 'CONFIDENT gate'), 'name'), ['tau']);
});

test('the library searches for every word and sorts by the chosen order', () => {
  const base = { size: 1, state: 'ready', runs: 0, created: '2026-01-01T00:00:00', review: { tracks: 0, reviewed: 0 }, duration: 1 };
  const videos = /** @type {any[]} */ ([
    { ...base, id: 'a', name: 'drive 10.mp4', path: '/x/drive 10.mp4', created: '2026-01-03T00:00:00' },
    { ...base, id: 'b', name: 'drive 9.mp4', path: '/x/drive 9.mp4', review: { tracks: 9, reviewed: 1 }, created: '2026-01-02T00:00:00' },
    { ...base, id: 'c', name: 'Town.mkv', path: '/y/Town.mkv', duration: 60 },
  ]);
  /** @param {string} text @param {string} sort */
  const ids = (text, sort) =>
    arrange(videos, text, sort)
      .map(({ id }) => id)
      .join('');
  assert.equal(ids('', 'newest'), 'abc');
  assert.equal(ids('DRIVE', 'name'), 'ba');
  assert.equal(ids('', 'open')[0], 'b');
  assert.equal(ids('', 'longest')[0], 'c');
  assert.equal(ids('drive /y', 'name'), '');
});

test('help groups keep the order and search keys too', () => {
  const operation = { tooltip: '', available: () => true, disabled: () => null, repeats: false, run: () => {} };
  const operations = [
    { ...operation, id: 'a', label: 'Next frame', keys: ['F'], group: 'Move' },
    { ...operation, id: 'b', label: 'Undo', keys: ['Ctrl+Z'], group: 'Edit' },
    { ...operation, id: 'c', label: 'Previous frame', keys: ['D'], group: 'Move' },
  ];
  assert.deepEqual(
    groupOperations(operations, '').map(([group, found]) => [group, found.length]),
    [
      ['Move', 2],
      ['Edit', 1],
    ],
  );
  assert.deepEqual(
    groupOperations(operations, 'ctrl+z').map(([, [found]]) => found.id),
    ['b'],
  );
});

test('the save state says what is not saved yet', () => {
  assert.equal(describeSaveState(false, 0, 0), 'All saved');
  assert.equal(describeSaveState(false, 2, 0), 'Saving 2 …');
  assert.equal(describeSaveState(false, 2, 2), '2 to decide on');
  assert.equal(describeSaveState(false, 5, 2), '2 to decide on, saving 3 …');
  assert.equal(describeSaveState(true, 5, 2), 'Offline, 5 to save');
});

test('the description of a track version has its label, frames and notes', () => {
  /** @type {import('../../../static/js/types.js').TrackDoc} */
  const doc = {
    key: 'm3',
    revision: 2,
    class_id: 2,
    review: 'accepted',
    not_a_sign: false,
    segments: [{ track: 3, first: 4, last: 9 }],
    keys: {},
    notes: [{ id: 'n', frame: 4, text: '<img onerror=x>', author: 'A', time: '' }],
    gone: false,
    merged_into: null,
  };
  const description = describeDoc(doc, LABELS);
  assert.equal(description.Label, 'speed limit 80 km/h');
  assert.equal(description.Frames, '4–9');
  assert.equal(description.Notes, 'A: <img onerror=x>');
  assert.equal(describeDoc({ ...doc, gone: true, merged_into: 'm1' }, LABELS).State, 'merged into #1');
  assert.equal(describeDoc(undefined, LABELS).State, 'not there');
});

test('differences of a replay are described, with the frame to open', () => {
  const run = /** @type {any} */ ({
    summary: {
      difference: {
        gained: [{ track: 9, frame: 10, last: 30, class_id: 5 }],
        switched: [{ track: 3, parts: [3, 8], frame: 44 }],
        relabelled: [{ track: 2, before: null, after: 0, frame: 7 }],
      },
    },
  });
  assert.deepEqual(rowsOf(listChanges(run, 'gained', LABELS), 'text', 'frame', 'isReplayTrack'), [['stop, frames 10–30', 10, true]]);
  assert.match(listChanges(run, 'switched', LABELS)[0].text, /2 parts at frame 44/);
  assert.equal(listChanges(run, 'relabelled', LABELS)[0].text, 'unlabelled → speed limit 20 km/h');
  assert.deepEqual(listChanges(run, 'lost', LABELS), []);
});

test('key frames that differ only in a box are listed', () => {
  const key = keyFrame({ box: [10, 20.04, 30, 40], interpolate: false });
  /** @param {Record<string, object>} keys @returns {any} */
  const doc = (keys) => ({ keys });
  assert.deepEqual(
    differingKeyFrames(
      doc({ 7: key, 9: key }),
      doc({ 7: { ...key, box: [12, 20, 30, 40] }, 9: { ...key }, 11: { ...key, box: null, occluded: true } }),
    ),
    [
      ['Frame 7', '10, 20, 30, 40', '12, 20, 30, 40'],
      ['Frame 11', 'no key frame', 'the engine’s box; occluded'],
    ],
  );
  const many = Object.fromEntries(Array.from({ length: 9 }, (_, at) => [at, key]));
  assert.deepEqual(differingKeyFrames(undefined, doc(many)).at(-1), ['More frames', '3 differ', '3 differ']);
});

test('changed frames are counted even if the tracks are the same', () => {
  /** @param {object} more @returns {any} */
  const run = (more) => ({ frames_done: 76, summary: { identical_frames: 43, ...more } });
  assert.equal(changedFrameCount(run({})), 33);
  assert.equal(changedFrameCount(run({ identical_frames: 76 })), 0);
  assert.equal(changedFrameCount({ ...run({}), summary: {} }), 0);
});

test('a tooltip covers no entry of its menu', () => {
  const screen = { width: 1000, height: 600 };
  const tip = { width: 300, height: 50 };
  const entry = (/** @type {number} */ left, /** @type {number} */ top) => ({ left, top, bottom: top + 20, width: 200 });
  assert.deepEqual(tooltipPlace(entry(100, 580), { left: 100, right: 300 }, tip, screen), [306, 544]);
  assert.deepEqual(tooltipPlace(entry(780, 40), { left: 780, right: 980 }, tip, screen), [474, 40]);
  assert.deepEqual(tooltipPlace(entry(250, 40), { left: 250, right: 750 }, tip, screen), [200, 66], 'no room beside it');
  assert.deepEqual(tooltipPlace(entry(100, 40), null, tip, screen), [50, 66]);
  assert.deepEqual(tooltipPlace(entry(950, 570), null, tip, screen), [694, 514]);
});
