// @ts-check
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { comparable, labelFinder } from '../../../static/js/model/label_finder.js';
import { labelName, labelFor, offeredLabels, resolveLabelId } from '../../../static/js/model/labels.js';
import { NO_CLASS } from '../../../static/js/model/documents.js';
import { label, labelsNamed } from '../labels.js';
import { pluck } from '../pluck.js';

/** What the server's matcher answers: tests/labels/test_page_matcher.py. @type {{labels: any[], comparable: [string, string][], find: [string, [number, string]|null][]}} */
const CASES = JSON.parse(readFileSync(new URL('../../labels/words.json', import.meta.url), 'utf8'));
const SET = CASES.labels.map((one) => label(one));

test('names are compared as the server compares them', () => {
  for (const [name, answer] of CASES.comparable) assert.equal(comparable(name), answer, JSON.stringify(name));
});

test('a word names the label that the server finds for it', () => {
  const finder = labelFinder(SET);
  assert.ok(CASES.find.length > 30);
  for (const [word, answer] of CASES.find) {
    const found = finder.find(word);
    assert.deepEqual(found && [found.label.id, found.how], answer, JSON.stringify(word));
  }
});

test('a merged label is resolved, also across several merges', () => {
  assert.deepEqual(
    [44, 47, 46, NO_CLASS, 999].map((id) => resolveLabelId(SET, id)),
    [43, 45, 46, NO_CLASS, 999],
  );
  assert.equal(resolveLabelId(SET, null), null);
  assert.equal(labelFor(SET, 44)?.name, 'no parking');
  assert.deepEqual(
    [44, NO_CLASS, null, 999].map((id) => labelName(SET, id)),
    ['no parking', 'not in the set', 'unlabelled', 'label 999'],
  );
  assert.deepEqual(pluck(offeredLabels(SET), 'id'), [0, 14, 13, 40, 43, 46, 48]);
  const circle = [label({ id: 1, merged_into: 2 }), label({ id: 2, merged_into: 1 }), label({ id: 3, merged_into: 9 })];
  assert.equal(circle.map(({ id }) => resolveLabelId(circle, id)).length, 3);
});

/** @param {import('../../../static/js/types.js').Label[]} labels @param {string} text */
const found = (labels, text) =>
  labelFinder(labels)
    .search(text, offeredLabels(labels))
    .map(({ id }) => id);

test('a search finds by name, alias, key, short name and number', () => {
  assert.deepEqual(found(SET, '#40'), [40]);
  assert.deepEqual(found(SET, '40'), [0, 40]);
  assert.deepEqual(found(SET, '13'), [13]);
  assert.deepEqual(found(SET, 'noparking'), [43]);
  assert.deepEqual(found(SET, 'NO_PARK'), [43]);
  assert.deepEqual(found(SET, 'verbot'), [43]);
  assert.deepEqual(found(SET, 'elsőb'), [13]);
  assert.deepEqual(found(SET, 'C,19'), [43]);
  assert.deepEqual(found(SET, 'b2a'), [14]);
  assert.deepEqual(found(SET, 'עצור'), [46]);
  assert.deepEqual(found(SET, '🅿️'), [43]);
  assert.deepEqual(found(SET, 'zebra'), []);
  assert.deepEqual(found(SET, '#'), []);
  assert.equal(found(SET, '  ').length, 7);
});

test('exact matches rank before prefix matches', () => {
  const labels = labelsNamed(['stop and give way', 'no stop', 'stop']);
  assert.deepEqual(found(labels, 'stop'), [2, 0, 1]);
});

test('names of labels are always shown as text', () => {
  const labels = [
    label({ id: 0, name: '<img src=x onerror=alert(1)>' }),
    label({ id: 1, name: 'a'.repeat(200) }),
    label({ id: 2, name: '.*(' }),
  ];
  assert.deepEqual([found(labels, '<img'), found(labels, 'aaaa'), found(labels, '.*(')], [[0], [1], [2]]);
});

test('a keystroke in 400 labels takes less than 50 ms', () => {
  const labels = labelsNamed(Array.from({ length: 400 }, (_, i) => `sign of the road number ${i} with a long name`)).map((one) => ({
    ...one,
    aliases: [`alias ${one.id}`, `Zeichen ${one.id}`, `tábla ${one.id}`],
  }));
  found(labels, 'warm');
  const start = performance.now();
  for (const text of ['s', 'si', 'sign', 'zeich', 'tábla 3', '39', '#12', 'nothing of the kind', 'long name', 'road 2'])
    found(labels, text);
  assert.ok((performance.now() - start) / 10 < 50);
});
