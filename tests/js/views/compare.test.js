// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { arrangeConfusion, describeCell } from '../../../static/js/views/compare_confusion.js';
import { describeTracks, reviewTarget } from '../../../static/js/views/compare_places.js';
import { initialSides, sidesAfterImport } from '../../../static/js/views/dialogs/compare.js';
import { label } from '../labels.js';

test('a confusion matrix has rows and columns in class order, with missing boxes last', () => {
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
  const matrix = arrangeConfusion({ classes: [4, 13], cells: [cell(4, 4, 9), cell(4, null, 2), cell(null, 13, 1)] });
  assert.deepEqual(matrix.rows, [4, null]);
  assert.deepEqual(matrix.columns, [4, 13, null]);
  assert.equal(matrix.cell(4, null)?.count, 2);
  assert.equal(matrix.cell(4, 13), undefined);
  assert.equal(matrix.maxCount, 9);
});

test('a sign outside the label set is named as such, not as missed or absent', () => {
  const labels = [label({ id: 14, name: 'stop' })];
  /** @param {number|null} reference @param {number|null} candidate */
  const cellText = (reference, candidate) => describeCell({ reference, candidate }, labels);
  assert.equal(cellText(14, -1), 'stop, read as not in the set');
  assert.equal(cellText(-1, null), 'not in the set, missed');
  assert.equal(cellText(null, -1), 'No sign, read as not in the set');
  assert.equal(cellText(14, null), 'stop, missed');
  assert.equal(cellText(null, 14), 'No sign, read as stop');
  /** @param {number|null} reference @param {number|null} candidate */
  const cell = (reference, candidate) => ({ reference, candidate, count: 1, frames: [], lasts: [], tracks: [], partners: [], pairs: [] });
  const matrix = arrangeConfusion({ classes: [14, -1], cells: [cell(-1, -1), cell(14, -1), cell(null, -1), cell(-1, null)] });
  assert.deepEqual(
    [matrix.rows, matrix.columns],
    [
      [14, -1, null],
      [-1, null],
    ],
  );
});

test('the dialog starts with the present comparison, else with a run against ground truth or its corrections', () => {
  const offered = ['run:a', 'run:b', 'annotation:a', 'truth:t'];
  assert.deepEqual(initialSides(offered, { run: 'b', reference: 'run:a', candidate: 'run:b' }), { reference: 'run:a', candidate: 'run:b' });
  assert.deepEqual(initialSides(offered, { run: 'b' }), { reference: 'truth:t', candidate: 'run:b' });
  assert.deepEqual(initialSides(offered.slice(0, 3), { run: 'gone', reference: 'run:gone', candidate: 'run:a' }), {
    reference: 'annotation:a',
    candidate: 'run:a',
  });
  assert.equal(initialSides(['truth:t'], {}), null);
});

test('a place opens with both sides visible', () => {
  /** @param {string} reference @param {string} candidate @param {'reference'|'candidate'} side @param {boolean} [edited] */
  const view = (reference, candidate, side, edited = false) =>
    reviewTarget(
      /** @type {any} */ ({
        reference,
        candidate,
        sides: { reference: { kind: reference.split(':')[0], edited }, candidate: { kind: candidate.split(':')[0], edited } },
      }),
      side,
    );
  const engineResults = (/** @type {string} */ run) => ({ run, corrected: false });
  const corrected = (/** @type {string} */ run) => ({ run, corrected: true });
  assert.deepEqual(view('truth:t', 'run:r', 'reference'), { run: 'r', hasTrack: false, second: null, truth: 't' });
  assert.deepEqual(view('truth:t', 'run:r', 'candidate'), { run: 'r', hasTrack: true, second: null, truth: 't' });
  assert.deepEqual(
    view('truth:t', 'run:r', 'reference', true),
    { run: 'r', hasTrack: false, second: engineResults('r'), truth: 't' },
    'the engine’s results, not the corrections',
  );
  assert.deepEqual(view('truth:t', 'run:r', 'candidate', true), { run: 'r', hasTrack: true, second: engineResults('r'), truth: 't' });
  assert.deepEqual(view('truth:t', 'annotation:q', 'candidate'), { run: 'q', hasTrack: true, second: null, truth: 't' });
  assert.deepEqual(view('truth:t', 'truth:u', 'candidate'), { run: null, hasTrack: false, second: null, truth: 'u' });
  assert.deepEqual(view('run:a', 'run:b', 'reference'), { run: 'a', hasTrack: true, second: engineResults('b'), truth: null });
  assert.deepEqual(view('run:a', 'run:b', 'candidate'), { run: 'b', hasTrack: true, second: engineResults('a'), truth: null });
  assert.deepEqual(view('annotation:q', 'run:b', 'reference'), { run: 'q', hasTrack: true, second: engineResults('b'), truth: null });
  assert.deepEqual(
    view('annotation:q', 'run:b', 'candidate'),
    { run: 'q', hasTrack: false, second: engineResults('b'), truth: null },
    'corrections are drawn on their own run',
  );
  assert.deepEqual(
    view('annotation:q', 'run:q', 'candidate'),
    { run: 'q', hasTrack: true, second: engineResults('q'), truth: null },
    'the engine’s results are drawn over the corrections',
  );
  assert.deepEqual(view('annotation:q', 'annotation:p', 'candidate'), { run: 'p', hasTrack: true, second: corrected('q'), truth: null });
});

test('a place names its track as the review does', () => {
  const trackNames = { h0001: 'drawn at 70' };
  const found = /** @type {any} */ ({
    reference: 'annotation:q',
    candidate: 'run:b',
    sides: { reference: { names: trackNames }, candidate: { names: {} } },
  });
  const common = { title: '', frames: [1, 1], lasts: [1, 1], places: 2 };
  /** @param {any} compared @param {any} places */
  const describe = (compared, places) => describeTracks(compared, { ...common, ...places }, reviewTarget(compared, places.side), 0);
  assert.equal(describe(found, { side: 'reference', tracks: ['h0001'], partners: [null] }), 'drawn at 70');
  assert.equal(describe(found, { side: 'candidate', tracks: ['m3'], partners: ['h0001'] }), '#3 of the other run, drawn at 70');
  assert.equal(
    describe({ ...found, candidate: 'truth:t' }, { side: 'candidate', tracks: ['4'], partners: ['h0001'] }),
    'truth 4, drawn at 70',
  );
  assert.equal(describe({ ...found, candidate: 'truth:t' }, { side: 'candidate', tracks: ['4'], partners: [null] }), 'truth 4');
});

test('an imported file becomes a side of the comparison', () => {
  const sides = { reference: 'annotation:r', candidate: 'run:r' };
  assert.deepEqual(sidesAfterImport(sides, { kind: 'truth', id: 't' }), { reference: 'truth:t', candidate: 'run:r' });
  assert.deepEqual(sidesAfterImport(sides, { kind: 'run', id: 's' }), { reference: 'annotation:r', candidate: 'run:s' });
  assert.deepEqual(sidesAfterImport(sides, null), sides, 'nothing was imported');
});
