// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { NO_CLASS, emptyDoc } from '../../../static/js/model/documents.js';
import { labelFinder } from '../../../static/js/model/label_finder.js';
import { describeMerge } from '../../../static/js/views/dialogs/label_merge.js';
import { unmatchedTextRow, isAlreadySet, sideBesideBox, voteShares, reordered } from '../../../static/js/views/dialogs/relabel.js';
import { SPEED_LABELS as LABELS, label, labelsNamed } from '../labels.js';
import { pluck } from '../pluck.js';
import { keyFrame } from '../server_data.js';

/** @param {readonly import('../../../static/js/types.js').Label[]} labels @param {string} text */
const findLabels = (labels, text) => labelFinder(labels).search(text, labels);

test('labels are found by number, by prefix and by parts of words', () => {
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

test('the present label and the engine’s other readings come first until something is typed', () => {
  const lane = { classes: [2, 3, 5, 0], votes: [[1, 0, 0, 0], [0.6, 0.001, 0.399, 0], null] };
  assert.deepEqual(
    [...voteShares(lane)],
    [
      [2, 0.6],
      [5, 0.399],
      [3, 0.001],
    ],
  );
  assert.deepEqual([...voteShares(null), ...voteShares({ classes: [2], votes: [null] })], []);
  const offered = reordered(LABELS, [4, ...voteShares(lane).keys()]);
  assert.deepEqual(pluck(findLabels(offered, ''), 'id'), [4, 2, 5, 3, 0, 1]);
  assert.deepEqual(pluck(findLabels(offered, 'speed'), 'id'), [0, 1, 2, 3]);
  assert.deepEqual(reordered(LABELS, [NO_CLASS, null]), LABELS);
});

test('a label that is already set is not set again; labels of single boxes count', () => {
  const doc = { ...emptyDoc({ track: 7, first: 0, last: 99 }), class_id: NO_CLASS };
  assert.deepEqual([isAlreadySet(doc, null, NO_CLASS), isAlreadySet(doc, null, null), isAlreadySet(doc, 5, null)], [true, false, true]);
  const single = { ...doc, keys: { 5: keyFrame({ class_id: 14 }) } };
  assert.deepEqual(
    [isAlreadySet(single, null, NO_CLASS), isAlreadySet(single, 5, 14), isAlreadySet(single, 5, null)],
    [false, true, false],
  );
});

test('a number in the name of a label goes before a class number', () => {
  const all = [...LABELS, ...['ice or snow', 'children'].map((name, i) => label({ id: 30 + i, name }))];
  assert.deepEqual(pluck(findLabels(all, '30'), 'name'), ['speed limit 30 km/h', 'ice or snow']);
  assert.deepEqual(pluck(findLabels(all, '31'), 'name'), ['children']);
});

test('the label dialog opens on the side away from the sign', () => {
  const review = /** @type {any} */ ({ viewport: { x: 640, y: 360, zoom: 0.75 } });
  const stage = { left: 0, width: 920, height: 430 };
  /** @param {import('../../../static/js/types.js').Box|null} box @param {number} windowWidth */
  const side = (box, windowWidth) => sideBesideBox(review, box, stage, windowWidth);
  assert.equal(side([1000, 0, 1040, 40], 1280), 'left');
  assert.equal(side([300, 0, 340, 40], 1280), 'right');
  assert.equal(side([720, 0, 760, 40], 1280), 'right', 'right of the middle of the picture, left of that of the window');
  assert.equal(side([1000, 0, 1040, 40], 1600), 'right', 'the picture ends before a dialog on the right');
  assert.equal(side(null, 1280), undefined);
  assert.equal(sideBesideBox(review, [0, 0, 9, 9], undefined, 1280), undefined);
});

test('a label is found by its aliases, after labels with that name', () => {
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
  assert.deepEqual(unmatchedTextRow(labels, 'no parking'), { text: `Add 'no parking'`, hidden: null });
  assert.deepEqual(unmatchedTextRow(labels, '7'), { text: `Add '7'`, hidden: null });
  assert.equal(unmatchedTextRow(labels, '0')?.text, `Add '0'`, 'a number that is an id is no name');
  assert.equal(unmatchedTextRow(labels, 'BUS-stop')?.hidden, labels[1]);
  assert.deepEqual(
    ['Stop', 'halt', '', '#9', '#'].map((text) => unmatchedTextRow(labels, text)),
    [null, null, null, null, null],
  );
});

test('the consequences of a merge name the number of tracks', () => {
  const [a, b] = labelsNamed(['bus', 'bus stop']);
  const usage = (/** @type {number} */ tracks, /** @type {number} */ videos) => ({ labels: { [a.id]: { tracks, videos } }, unread: 0 });
  assert.match(describeMerge(a, b, usage(1, 1)), /^1 track in 1 video is 'bus' and will count as 'bus stop'\./);
  assert.match(describeMerge(a, b, usage(1200, 3)), /^1,?200 tracks in 3 videos are/);
  assert.match(describeMerge(a, b, { labels: {}, unread: 0 }), /^No track is 'bus' yet/);
  assert.match(describeMerge(a, b, { labels: {}, unread: 2 }), /^The tracks of 2 more videos are not counted\./);
  assert.match(describeMerge(a, b, null), /^Its names will mean 'bus stop'/);
});
