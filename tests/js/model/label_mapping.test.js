// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { mappingOf, parseLabelMap, proposed } from '../../../static/js/model/label_mapping.js';
import { label } from '../labels.js';

const LABELS = [label({ id: 13, key: 'give-way', name: 'give way', aliases: ['yield'] }), label({ id: 14, key: 'stop', name: 'stop' }), label({ id: 15, key: 'halt', name: 'halt', merged_into: 14 })];
const name = (/** @type {string} */ text, /** @type {any[]} */ suggestions = []) => ({ name: text, tracks: 1, boxes: 9, suggestions, example: null });

test('what is like a label is proposed as that, anything else as a new one', () => {
  assert.deepEqual(proposed(name('giveway', [{ id: 13, key: 'give-way', name: 'give way' }, { id: 14, key: 'stop', name: 'stop' }])), { kind: 'label', word: 'give way' });
  assert.deepEqual(proposed(name('pedestrian_crossing')), { kind: 'add', word: '' });
});

test('answers become labels by key, names to add and names to leave out', () => {
  const unknown = ['a', 'b', 'c', 'd', 'e'].map((one) => name(one));
  const answers = /** @type {any[]} */ ([{ kind: 'label', word: 'YIELD' }, { kind: 'label', word: 'halt' }, { kind: 'none', word: 'x' }, { kind: 'add', word: 'x' }, { kind: 'skip', word: '' }]);
  assert.deepEqual(mappingOf(unknown, answers, LABELS), { map: { a: 'give-way', b: 'stop', c: -1 }, add: ['d'], skip: ['e'] });
  assert.deepEqual(mappingOf(unknown.slice(0, 2), [answers[0], { kind: 'label', word: ' boar ' }], LABELS), { error: 'No label is called “boar”.', at: 1 });
  assert.deepEqual(mappingOf([name('<b>')], [{ kind: 'label', word: ' ' }], LABELS), { error: 'Say which label “<b>” is.', at: 0 });
});

test('names of another tool are typed one a line', () => {
  assert.deepEqual(parseLabelMap('stop sign = 14\n\n a = b=yield \nc=#13', LABELS), { map: { 'stop sign': 'stop', 'a = b': 'give-way', c: 'give-way' } });
  for (const text of ['b', '= 3', 'b =', 'b = boar']) {
    const found = parseLabelMap(`a = 14\n${text}`, LABELS);
    assert.match('error' in found ? found.error : '', /^Line 2/, text);
  }
});
