// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { describeContent, describeOutput, progressOf, skippedItems, outputWarnings } from '../../../static/js/views/output_text.js';
import { describeCutTracks, describeExpectation } from '../../../static/js/views/dialogs/bundle.js';
import { describeRange, rangeAround } from '../../../static/js/views/dialogs/frame_range.js';
import { notifyWhenFinished, outputNotice } from '../../../static/js/views/output_notice.js';
import { createStore } from '../../../static/js/store/store.js';
import { initialState } from '../../../static/js/store/initial.js';
import { putOutput, setOutputs } from '../../../static/js/store/actions/page.js';
import { describeLineage, describeProgress, describeRunModels, modelVersionSuffix } from '../../../static/js/views/model_version_text.js';

/** @param {object} [more] */
const output = (more = {}) =>
  /** @type {import('../../../static/js/types.js').Output} */ ({
    id: 'a',
    kind: 'export',
    run_id: null,
    name: 'x.zip',
    state: 'complete',
    error: null,
    options: { format: 'yolo' },
    done: 0,
    total: null,
    size: 1500,
    sha256: '',
    summary: {},
    created: '2026-11-21T09:00:00Z',
    finished: null,
    ...more,
  });

test('the description of a file has its kind, videos and size', () => {
  assert.match(describeOutput(output({ summary: { title: 'YOLO' } }), 'drive.mp4'), /^Export: YOLO · drive\.mp4 · 1\.5 kB · /);
  assert.match(
    describeOutput(output({ kind: 'recording', options: { first: 1000, stop: 1300 }, size: null }), ''),
    /^Recording · frames 1,000 to 1,299 · /,
  );
  assert.equal(
    describeContent(output({ summary: { counts: { videos: 1, tracks: 2, boxes: 1, by: {} }, files: 3 } })),
    '1 video, 2 tracks, 1 box, 3 files',
  );
  assert.equal(
    describeContent(output({ summary: { counts: { tracks: 1300, boxes: 2 }, split: { tracks: { train: 1200, val: 100 } } } })),
    '1,300 tracks (train 1,200, val 100), 2 boxes',
  );
  assert.equal(describeContent(output()), '');
});

test('there may be more skipped items than are listed', () => {
  const items = [{ what: 'a', reason: 'b' }];
  assert.deepEqual(skippedItems(output({ summary: { skipped: items, skipped_count: 7 } })), { items, total: 7 });
  assert.deepEqual(skippedItems(output()), { items: [], total: 0 });
});

test('progress is a fraction, or null if it is unknown', () => {
  assert.equal(progressOf({ state: 'running', done: 5, total: null }), null);
  assert.equal(progressOf({ state: 'running', done: 5, total: 4 }), 1);
  assert.equal(progressOf({ state: 'complete', done: 0, total: 0 }), 1);
});

test('texts give the reason for a range and the expectation of the replay', () => {
  assert.match(describeRange('#2', false), /^Around the selected track #2/);
  assert.match(describeRange('#2', true), /^All frames of the run: the selected track #2/);
  assert.equal(describeRange(null, true), 'All frames of the run.');
  assert.match(describeRange(null, false), /select a track first/);
  assert.match(describeExpectation(0), /No track is corrected yet/);
  assert.match(describeExpectation(1), /your corrections of 1 track, as far as these frames show it/);
  assert.match(describeExpectation(3), /3 tracks.*show them/);
  assert.equal(describeCutTracks([], 9), '');
  assert.match(describeCutTracks(['#3'], 1209), /^Track #3 continues after frame 1,209\. .* includes it completely\.$/);
  assert.match(
    describeCutTracks(['#1', '#2', '#3', '#4', '#5', '#6'], 9),
    /^Tracks #1, #2, #3, #4 and 2 more continue .* includes them completely\.$/,
  );
});

test('a range surrounds the track, else the cursor, within the run', () => {
  assert.deepEqual(rangeAround({ frame: 100, span: { first: 90, last: 120 }, first: 0, last: 299, maxLength: 300 }), {
    first: 75,
    last: 135,
  });
  assert.deepEqual(rangeAround({ frame: 2, span: { first: 0, last: 10 }, first: 0, last: 299, maxLength: 300 }), { first: 0, last: 25 });
  const long = rangeAround({ frame: 500, span: { first: 0, last: 999 }, first: 0, last: 999, maxLength: 100 });
  assert.equal(long.last - long.first, 99);
  assert.ok(long.first <= 500 && 500 <= long.last);
  for (const frame of [0, 150, 299]) {
    const around = rangeAround({ frame, span: null, first: 0, last: 299, maxLength: 100 });
    assert.ok(
      around.first >= 0 && around.last <= 299 && around.first <= frame && frame <= around.last && around.last - around.first < 100,
      JSON.stringify(around),
    );
  }
  const end = rangeAround({ frame: 990, span: { first: 500, last: 999 }, first: 0, last: 999, maxLength: 100 });
  assert.deepEqual(end, { first: 900, last: 999 });
});

test('the description of a run names its models', () => {
  const versions = /** @type {any[]} */ ([
    { name: 'Version 2', models: { detector: 'a', classifier: 'c' } },
    { name: 'Shipped', models: { detector: 'a', classifier: 'b' } },
  ]);
  assert.equal(describeRunModels({ models: { detector: 'a', classifier: 'b' } }, versions), 'Models: Shipped');
  assert.equal(describeRunModels({ models: { detector: 'a', classifier: 'c' } }, versions), 'Models: Version 2');
  assert.equal(describeRunModels({ models: { detector: 'z' } }, versions), 'Models that were removed');
  assert.equal(describeRunModels({ models: {} }, versions), '', 'an imported run');
  assert.equal(describeRunModels({ models: { detector: 'a' } }, null), '');
  assert.equal(
    describeRunModels({ models: { detector: 'a', classifier: 'b', 'onnx 640x640 yolo': 'd' } }, versions),
    'Models: Shipped',
    'with an additional network',
  );
});

test('a list of runs shows model versions if there are several', () => {
  const [two, shipped] = /** @type {any[]} */ ([
    { name: 'Version 2', state: 'complete', models: { detector: 'a' } },
    { name: 'Shipped', state: 'complete', models: { detector: 'b' } },
  ]);
  assert.equal(modelVersionSuffix({ models: { detector: 'a' } }, [two, shipped]), ' · Version 2');
  assert.equal(modelVersionSuffix({ models: { detector: 'b' } }, [two, shipped]), ' · Shipped');
  assert.equal(modelVersionSuffix({ models: { detector: 'b' } }, [{ ...two, state: 'running' }, shipped]), '', 'only one is complete');
  assert.equal(modelVersionSuffix({ models: {} }, [two, shipped]), '');
  assert.equal(modelVersionSuffix({ models: { detector: 'z' } }, [two, shipped]), '');
  assert.equal(modelVersionSuffix({ models: { detector: 'a' } }, null), '');
});

test('lineage names parent, exports, corrections, data and seed', () => {
  const version = /** @type {any} */ ({
    id: 'v2',
    parent_id: 'v1',
    state: 'running',
    stage: 'trial: boosting',
    note: '',
    done: 3,
    total: 9,
    lineage: {
      asked: { exports: [{ output: 'e', name: 'drive.zip' }], folders: { gtsdb: '/d' }, seed: 4, parts: ['detector'] },
      exports: [{ names: ['drive.mp4'], videos: ['ab'], runs: [{ edit_revision: 12 }], edits_since: 2, undone_since: 1 }],
      used: { frames: 30, signs: 2, videos: ['drive.mp4'] },
      held_out: { by: 'sign', signs: ['s'] },
      seed: 4,
      parts: ['detector'],
    },
  });
  const rows = Object.fromEntries(describeLineage(version, [/** @type {any} */ ({ id: 'v1', name: 'First' })]));
  assert.deepEqual(rows, {
    'Made from': 'First',
    Exports: 'drive.zip',
    Corrections: 'drive.mp4 up to edit 12 (2 edits made since, 1 edit of it undone since)',
    Data: 'GTSDB in /d',
    Parts: 'Detector',
    Seed: '4',
    'Learned from': '2 signs in 30 frames of drive.mp4',
    'Measured on': '1 sign, chosen by sign, with a trial version trained without it',
  });
  assert.equal(describeProgress(version), 'trial: boosting · 3 of 9');
  assert.equal(describeProgress({ ...version, note: 'compiling' }), 'trial: boosting · 3 of 9 · compiling');
  assert.equal(Object.fromEntries(describeLineage({ ...version, parent_id: 'gone' }, []))['Made from'], 'a version that was removed');
  const reads = (/** @type {string[]} */ lacks) => Object.fromEntries(describeLineage({ ...version, labels: 43, lacks }, []))['Labels'];
  assert.equal(reads(['no stopping']), '43; it lacks these of the label set: no stopping');
  assert.equal(reads([]), '43; all signs of the label set');
});

test('a requested file is announced once, unless it is visible or was cancelled', () => {
  assert.deepEqual(outputNotice(output(), false), { text: 'x.zip is ready.', tone: 'good', offers: 'download' });
  assert.deepEqual(outputNotice(output({ state: 'failed', error: 'The disk is full.' }), false), {
    text: 'x.zip could not be made: The disk is full.',
    tone: 'bad',
    offers: 'files',
  });
  assert.equal(outputNotice(output(), true), null);
  assert.equal(outputNotice(output({ state: 'cancelled' }), false), null);
  assert.equal(outputNotice(undefined, false), null);

  const store = createStore(initialState(), (run) => run());
  const app = { store, signal: new AbortController().signal, api: /** @type {any} */ ({}) };
  /** @type {string[]} */
  const notices = [];
  notifyWhenFinished(app, 'a', ({ text, action, topic }) => notices.push(`${text} ${action?.label} ${topic}`));
  store.dispatch((state) => ({ ...state })); // the list of files is not loaded yet
  store.dispatch(setOutputs, [output({ state: 'running' })]);
  assert.deepEqual(notices, []);
  store.dispatch(putOutput, output({ state: 'complete' }));
  store.dispatch(putOutput, output({ state: 'complete', size: 7 }));
  assert.deepEqual(notices, ['x.zip is ready. Download made-a']);
});

test('missing labels of a split part and omitted open tracks are reported', () => {
  const lacks = { val: ['stop', '<b>boar</b>'], test: [] };
  assert.deepEqual(outputWarnings(output({ summary: { split: { lacks }, open_left: 1 } })), [
    'The val part has no sign of stop, <b>boar</b>, which others have.',
    '1 open track left out: not reviewed or edited yet.',
  ]);
  assert.match(
    outputWarnings(output({ summary: { split: { lacks: { train: Array.from({ length: 9 }, (_, i) => `s${i}`) } } } }))[0],
    /s5 and 3 more/,
  );
  assert.deepEqual(outputWarnings(output({ summary: { open_left: 0 } })), []);
  assert.deepEqual(outputWarnings(output()), []);
});
