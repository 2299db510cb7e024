// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { arrange } from '../../../static/js/model/library_order.js';
import { arrangeConfusion, cellWords } from '../../../static/js/views/compare-confusion.js';
import { sides, viewOf } from '../../../static/js/views/compare-places.js';
import { describe as describeDoc, differingKeys } from '../../../static/js/views/dialogs/conflict.js';
import { firstChoice } from '../../../static/js/views/dialogs/compare.js';
import { lacking } from '../../../static/js/views/dialogs/add-video.js';
import { groupOperations } from '../../../static/js/views/dialogs/help.js';
import { NO_CLASS, emptyDoc } from '../../../static/js/model/documents.js';
import { finderOf } from '../../../static/js/model/label_finder.js';
import { mergeWords } from '../../../static/js/views/dialogs/label-merge.js';
import { furtherRow, isSaid, sideOf, votesFor, withFirst } from '../../../static/js/views/dialogs/relabel.js';
import { label, named } from '../labels.js';
import { bytes, clock, figure, frameSpan, percent, timeLeft } from '../../../static/js/model/format.js';
import { savedWords } from '../../../static/js/views/topbar.js';
import { findParameters, parseValue, presetValue } from '../../../static/js/views/parameters.js';
import { changedFrames, changesOf } from '../../../static/js/views/whatif.js';

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

const LABELS = named([
  'speed limit 20 km/h',
  'speed limit 30 km/h',
  'speed limit 80 km/h',
  'end of speed limit 80 km/h',
  'no overtaking',
  'stop',
]);
/** @param {readonly import('../../../static/js/types.js').Label[]} labels @param {string} text */
const findLabels = (labels, text) => finderOf(labels).search(text, labels);

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

test('a folder that holds more than is listed says how much is, and what to do', () => {
  const videos = Array.from({ length: 1999 }, (_, k) => ({ name: `${k}.mp4`, path: `/v/${k}.mp4`, size: 1 }));
  assert.match(lacking({ folders: ['a'], videos }), /first 2,000 folders and videos .* Type the path/);
});

test('parameters are found by name and by meaning, names first', () => {
  const all = [parameter({ name: 'delta', description: 'like tau, of the classifier' }), parameter()];
  assert.deepEqual(
    findParameters(all, 'tau').map(({ name }) => name),
    ['tau', 'delta'],
  );
  assert.deepEqual(
    findParameters(all, 'CONFIDENT gate').map(({ name }) => name),
    ['tau'],
  );
});

test('classes are found by number, by beginnings, by parts', () => {
  /** @param {string} text */
  const ids = (text) => findLabels(LABELS, text).map(({ id }) => id);
  assert.equal(ids('2')[0], 2);
  assert.deepEqual(ids('80'), [2, 3]);
  assert.deepEqual(ids('sp 80'), [2, 3]);
  assert.deepEqual(ids('st'), [5]);
  assert.deepEqual(ids('overt'), [4]);
  assert.deepEqual(ids('zebra'), []);
  assert.equal(ids(' ').length, LABELS.length);
});

test('what a track is and what the engine has read besides is offered first, until something is typed', () => {
  const lane = { classes: [2, 3, 5, 0], votes: [[1, 0, 0, 0], [0.6, 0.001, 0.399, 0], null] };
  assert.deepEqual(
    [...votesFor(lane)],
    [
      [2, 0.6],
      [5, 0.399],
      [3, 0.001],
    ],
  );
  assert.deepEqual([...votesFor(null), ...votesFor({ classes: [2], votes: [null] })], []);
  const offered = withFirst(LABELS, [4, ...votesFor(lane).keys()]);
  assert.deepEqual(
    findLabels(offered, '').map(({ id }) => id),
    [4, 2, 5, 3, 0, 1],
  );
  assert.deepEqual(
    findLabels(offered, 'speed').map(({ id }) => id),
    [0, 1, 2, 3],
  );
  assert.deepEqual(withFirst(LABELS, [NO_CLASS, null]), LABELS);
});

test('what people have said already is not said again; single boxes make a difference', () => {
  const doc = { ...emptyDoc({ track: 7, first: 0, last: 99 }), class_id: NO_CLASS };
  const key = { box: null, occluded: false, outside: false, interpolate: false, class_id: 14, followed: false };
  assert.deepEqual([isSaid(doc, null, NO_CLASS), isSaid(doc, null, null), isSaid(doc, 5, null)], [true, false, true]);
  const single = { ...doc, keys: { 5: key } };
  assert.deepEqual([isSaid(single, null, NO_CLASS), isSaid(single, 5, 14), isSaid(single, 5, null)], [false, true, false]);
});

test('what is written on a sign goes before the number of a class', () => {
  const all = [...LABELS, ...['ice or snow', 'children'].map((name, i) => label({ id: 30 + i, name }))];
  assert.deepEqual(
    findLabels(all, '30').map(({ name }) => name),
    ['speed limit 30 km/h', 'ice or snow'],
  );
  assert.deepEqual(
    findLabels(all, '31').map(({ name }) => name),
    ['children'],
  );
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

test('a confusion matrix has its rows and columns in order, what one side lacks last', () => {
  /** @param {number|null} reference @param {number|null} candidate @param {number} count */
  const cell = (reference, candidate, count) => ({
    reference,
    candidate,
    count,
    frames: [],
    lasts: [],
    tracks: [],
    partners: [],
    pairs: [],
  });
  const found = arrangeConfusion({ classes: [4, 13], cells: [cell(4, 4, 9), cell(4, null, 2), cell(null, 13, 1)] });
  assert.deepEqual(found.rows, [4, null]);
  assert.deepEqual(found.columns, [4, 13, null]);
  assert.equal(found.cell(4, null)?.count, 2);
  assert.equal(found.cell(4, 13), undefined);
  assert.equal(found.most, 9);
});

test('a sign of none of the classes is neither missed nor nothing', () => {
  const labels = [label({ id: 14, name: 'stop' })];
  /** @param {number|null} reference @param {number|null} candidate */
  const words = (reference, candidate) => cellWords({ reference, candidate }, labels);
  assert.equal(words(14, -1), 'stop, read as not in the set');
  assert.equal(words(-1, null), 'not in the set, missed');
  assert.equal(words(null, -1), 'No sign, read as not in the set');
  assert.equal(words(14, null), 'stop, missed');
  assert.equal(words(null, 14), 'No sign, read as stop');
  /** @param {number|null} reference @param {number|null} candidate */
  const cell = (reference, candidate) => ({ reference, candidate, count: 1, frames: [], lasts: [], tracks: [], partners: [], pairs: [] });
  const found = arrangeConfusion({ classes: [14, -1], cells: [cell(-1, -1), cell(14, -1), cell(null, -1), cell(-1, null)] });
  assert.deepEqual(
    [found.rows, found.columns],
    [
      [14, -1, null],
      [-1, null],
    ],
  );
});

test('the dialog of a comparison begins with what is compared, else with a run against the best that there is', () => {
  const offered = ['run:a', 'run:b', 'annotation:a', 'truth:t'];
  assert.deepEqual(firstChoice(offered, { run: 'b', reference: 'run:a', candidate: 'run:b' }), { reference: 'run:a', candidate: 'run:b' });
  assert.deepEqual(firstChoice(offered, { run: 'b' }), { reference: 'truth:t', candidate: 'run:b' });
  assert.deepEqual(firstChoice(offered.slice(0, 3), { run: 'gone', reference: 'run:gone', candidate: 'run:a' }), {
    reference: 'annotation:a',
    candidate: 'run:a',
  });
  assert.equal(firstChoice(['truth:t'], {}), null);
});

test('a place opens with both sides in view', () => {
  /** @param {string} reference @param {string} candidate @param {'reference'|'candidate'} side @param {boolean} [edited] */
  const view = (reference, candidate, side, edited = false) =>
    viewOf(
      /** @type {any} */ ({
        reference,
        candidate,
        sides: { reference: { kind: reference.split(':')[0], edited }, candidate: { kind: candidate.split(':')[0], edited } },
      }),
      side,
    );
  const raw = (/** @type {string} */ run) => ({ run, corrected: false });
  const corrected = (/** @type {string} */ run) => ({ run, corrected: true });
  assert.deepEqual(view('truth:t', 'run:r', 'reference'), { run: 'r', own: false, second: null, truth: 't' });
  assert.deepEqual(view('truth:t', 'run:r', 'candidate'), { run: 'r', own: true, second: null, truth: 't' });
  assert.deepEqual(
    view('truth:t', 'run:r', 'reference', true),
    { run: 'r', own: false, second: raw('r'), truth: 't' },
    'what the engine had, not what people made of it',
  );
  assert.deepEqual(view('truth:t', 'run:r', 'candidate', true), { run: 'r', own: true, second: raw('r'), truth: 't' });
  assert.deepEqual(view('truth:t', 'annotation:q', 'candidate'), { run: 'q', own: true, second: null, truth: 't' });
  assert.deepEqual(view('truth:t', 'truth:u', 'candidate'), { run: null, own: false, second: null, truth: 'u' });
  assert.deepEqual(view('run:a', 'run:b', 'reference'), { run: 'a', own: true, second: raw('b'), truth: null });
  assert.deepEqual(view('run:a', 'run:b', 'candidate'), { run: 'b', own: true, second: raw('a'), truth: null });
  assert.deepEqual(view('annotation:q', 'run:b', 'reference'), { run: 'q', own: true, second: raw('b'), truth: null });
  assert.deepEqual(
    view('annotation:q', 'run:b', 'candidate'),
    { run: 'q', own: false, second: raw('b'), truth: null },
    'corrections are drawn on their own run',
  );
  assert.deepEqual(
    view('annotation:q', 'run:q', 'candidate'),
    { run: 'q', own: true, second: raw('q'), truth: null },
    'what the engine had lies over what people made of it',
  );
  assert.deepEqual(view('annotation:q', 'annotation:p', 'candidate'), { run: 'p', own: true, second: corrected('q'), truth: null });
});

test('a place says whose track it is on, in the words of the review', () => {
  const drawn = { h0001: 'drawn at 70' };
  const found = /** @type {any} */ ({
    reference: 'annotation:q',
    candidate: 'run:b',
    sides: { reference: { names: drawn }, candidate: { names: {} } },
  });
  const some = { title: '', frames: [1, 1], lasts: [1, 1], places: 2 };
  /** @param {any} compared @param {any} places */
  const reported = (compared, places) => sides(compared, { ...some, ...places }, viewOf(compared, places.side), 0);
  assert.equal(reported(found, { side: 'reference', tracks: ['h0001'], partners: [null] }), 'drawn at 70');
  assert.equal(reported(found, { side: 'candidate', tracks: ['m3'], partners: ['h0001'] }), '#3 of the other run, drawn at 70');
  assert.equal(
    reported({ ...found, candidate: 'truth:t' }, { side: 'candidate', tracks: ['4'], partners: ['h0001'] }),
    'truth 4, drawn at 70',
  );
  assert.equal(reported({ ...found, candidate: 'truth:t' }, { side: 'candidate', tracks: ['4'], partners: [null] }), 'truth 4');
});

test('what is not saved yet says what it waits for', () => {
  assert.equal(savedWords(false, 0, 0), 'All saved');
  assert.equal(savedWords(false, 2, 0), 'Saving 2 …');
  assert.equal(savedWords(false, 2, 2), '2 to decide on');
  assert.equal(savedWords(false, 5, 2), '2 to decide on, saving 3 …');
  assert.equal(savedWords(true, 5, 2), 'Offline, 5 to save');
});

test('two versions of a track differ where they do', () => {
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
  const words = describeDoc(doc, LABELS);
  assert.equal(words.Label, 'speed limit 80 km/h');
  assert.equal(words.Frames, '4–9');
  assert.equal(words.Notes, 'A: <img onerror=x>');
  assert.equal(describeDoc({ ...doc, gone: true, merged_into: 'm1' }, LABELS).State, 'merged into #1');
  assert.equal(describeDoc(undefined, LABELS).State, 'not there');
});

test('the dialog of classes stands where it does not hide the sign', () => {
  const review = /** @type {any} */ ({ viewport: { x: 500, y: 300, zoom: 1 } });
  assert.equal(sideOf(review, [600, 0, 640, 40]), 'left');
  assert.equal(sideOf(review, [300, 0, 340, 40]), 'right');
  assert.equal(sideOf(review, null), undefined);
});

test('a label is found by other words for it, behind those that are called so', () => {
  const labels = [
    label({ id: 13, name: 'give way', aliases: ['yield'] }),
    label({ id: 9, name: 'no overtaking', aliases: ['no passing'] }),
    label({ id: 25, name: 'road works', aliases: ['construction'] }),
  ];
  /** @param {string} text */
  const found = (text) => findLabels(labels, text).map(({ id }) => id);
  assert.deepEqual([found('yield'), found('no pass'), found('construction'), found('give'), found('yeti')], [[13], [9], [25], [13], []]);
});

test('an unknown name can be added, a hidden label shown again, and a merged label found by its other name', () => {
  const labels = [
    label({ id: 0, key: 'stop', name: 'stop' }),
    label({ id: 1, key: 'bus', name: 'bus stop', hidden: true }),
    label({ id: 2, key: 'halt', name: 'halt', merged_into: 0 }),
  ];
  assert.deepEqual(furtherRow(labels, 'no parking'), { text: `Add 'no parking'`, hidden: null });
  assert.deepEqual(furtherRow(labels, '7'), { text: `Add '7'`, hidden: null });
  assert.equal(furtherRow(labels, '0')?.text, `Add '0'`, 'a number that is an id is no name');
  assert.equal(furtherRow(labels, 'BUS-stop')?.hidden, labels[1]);
  assert.deepEqual(
    ['Stop', 'halt', '', '#9', '#'].map((text) => furtherRow(labels, text)),
    [null, null, null, null, null],
  );
});

test('the consequences of a merge name the number of tracks', () => {
  const [a, b] = named(['bus', 'bus stop']);
  assert.match(mergeWords(a, b, { tracks: 1, videos: 1 }), /^1 track in 1 video is 'bus' and will count as 'bus stop'\./);
  assert.match(mergeWords(a, b, { tracks: 1200, videos: 3 }), /^1,?200 tracks in 3 videos are/);
  assert.match(mergeWords(a, b, { tracks: 0, videos: 0 }), /^No track is 'bus' yet/);
  assert.match(mergeWords(a, b, null), /^Its names will mean 'bus stop'/);
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
  assert.deepEqual(
    changesOf(run, 'gained', LABELS).map(({ text, frame, own }) => [text, frame, own]),
    [['stop, frames 10–30', 10, true]],
  );
  assert.match(changesOf(run, 'switched', LABELS)[0].text, /2 parts at frame 44/);
  assert.equal(changesOf(run, 'relabelled', LABELS)[0].text, 'unlabelled → speed limit 20 km/h');
  assert.deepEqual(changesOf(run, 'lost', LABELS), []);
});

test('numbers read as people write them', () => {
  assert.deepEqual([frameSpan(20, 20), frameSpan(20, 1034)], ['20', '20–1,034']);
  assert.deepEqual(
    [bytes(0), bytes(999), bytes(1500), bytes(3_700_000), bytes(250e9)],
    ['0 bytes', '999 bytes', '1.5 kB', '3.7 MB', '250 GB'],
  );
  assert.deepEqual([clock(0), clock(12.4), clock(3723), clock(null)], ['0:00', '0:12', '1:02:03', '–']);
  assert.deepEqual(
    [timeLeft(3), timeLeft(24), timeLeft(130), timeLeft(7200)],
    ['a few seconds left', 'about 25 s left', 'about 2 min left', 'about 2.0 h left'],
  );
  assert.deepEqual(
    [figure(0.16044), figure(132400), figure(null), percent(0.5432), percent(1)],
    ['0.16', '132,400', '–', '54.3 %', '100 %'],
  );
});

test('versions that differ in a box alone say where', () => {
  const key = { box: [10, 20.04, 30, 40], occluded: false, outside: false, interpolate: false, class_id: null, followed: false };
  /** @param {Record<string, object>} keys @returns {any} */
  const doc = (keys) => ({ keys });
  assert.deepEqual(
    differingKeys(
      doc({ 7: key, 9: key }),
      doc({ 7: { ...key, box: [12, 20, 30, 40] }, 9: { ...key }, 11: { ...key, box: null, occluded: true } }),
    ),
    [
      ['Frame 7', '10, 20, 30, 40', '12, 20, 30, 40'],
      ['Frame 11', 'no key frame', 'the engine’s box; occluded'],
    ],
  );
  const many = Object.fromEntries(Array.from({ length: 9 }, (_, at) => [at, key]));
  assert.deepEqual(differingKeys(undefined, doc(many)).at(-1), ['More frames', '3 differ', '3 differ']);
});

test('a replay with the same tracks still says in how many frames it differs', () => {
  /** @param {object} more @returns {any} */
  const run = (more) => ({ frames_done: 76, summary: { identical_frames: 43, ...more } });
  assert.equal(changedFrames(run({})), 33);
  assert.equal(changedFrames(run({ identical_frames: 76 })), 0);
  assert.equal(changedFrames({ ...run({}), summary: {} }), 0);
});
