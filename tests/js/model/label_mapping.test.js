// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { mappingOf, parseLabelMap, initialAnswer } from '../../../static/js/model/label_mapping.js';
import { label } from '../labels.js';

const LABELS = [
  label({ id: 13, key: 'give-way', name: 'give way', aliases: ['yield'] }),
  label({ id: 14, key: 'stop', name: 'stop' }),
  label({ id: 15, key: 'halt', name: 'halt', merged_into: 14 }),
];
const name = (/** @type {string} */ text, /** @type {any[]} */ suggestions = [], similar = true) => ({
  name: text,
  tracks: 1,
  boxes: 9,
  suggestions,
  similar,
  example: null,
});

test('a name that resembles a label is proposed as this label, any other as a new one', () => {
  assert.deepEqual(
    initialAnswer(
      name('giveway', [
        { id: 13, key: 'give-way', name: 'give way' },
        { id: 14, key: 'stop', name: 'stop' },
      ]),
    ),
    { kind: 'label', word: 'give way' },
  );
  assert.deepEqual(initialAnswer(name('pedestrian_crossing')), { kind: 'add', word: '' });
  assert.deepEqual(
    initialAnswer(name('bus', [{ id: 1, key: 'bus-lane', name: 'no bus lane ahead' }], false)),
    { kind: 'add', word: 'no bus lane ahead' },
    'the label only contains the name',
  );
});

test('answers are mapped to keys of labels, names to add, and names to skip', () => {
  const unknown = ['a', 'b', 'c', 'd', 'e'].map((one) => name(one));
  const answers = /** @type {any[]} */ ([
    { kind: 'label', word: 'YIELD' },
    { kind: 'label', word: 'halt' },
    { kind: 'none', word: 'x' },
    { kind: 'add', word: 'x' },
    { kind: 'skip', word: '' },
  ]);
  assert.deepEqual(mappingOf(unknown, answers, LABELS), { map: { a: 'give-way', b: 'stop', c: -1 }, add: ['d'], skip: ['e'] });
  assert.deepEqual(mappingOf(unknown.slice(0, 2), [answers[0], { kind: 'label', word: ' boar ' }], LABELS), {
    error: 'No label is called “boar”.',
    at: 1,
  });
  assert.deepEqual(mappingOf([name('<b>')], [{ kind: 'label', word: ' ' }], LABELS), { error: 'Say which label “<b>” is.', at: 0 });
});

test('a bare number that may be a name or an id is ambiguous', () => {
  const many = [
    label({ id: 2, key: 'limit-50', name: 'speed limit 50 km/h' }),
    label({ id: 50, key: 'hump', name: 'hump bridge' }),
    label({ id: 150, key: 'heavy', name: 'over 3.5 t' }),
  ];
  const answer = (/** @type {string} */ word) => mappingOf([name('a')], [{ kind: 'label', word }], many);
  assert.deepEqual(answer('50'), {
    error: '“50” can be “speed limit 50 km/h”, or “hump bridge”, which has that number. Write the name, or #50.',
    at: 0,
  });
  assert.deepEqual(answer('#50'), { map: { a: 'hump' }, add: [], skip: [] });
  assert.deepEqual(answer('2'), { map: { a: 'limit-50' }, add: [], skip: [] });
  const typed = parseLabelMap('x = 50', many);
  assert.match('error' in typed ? typed.error : '', /^Line 1: “50” can be/);
});

test('names of another tool are typed one a line', () => {
  assert.deepEqual(parseLabelMap('stop sign = 14\n\n a = b=yield \nc=#13', LABELS), {
    map: { 'stop sign': 'stop', 'a = b': 'give-way', c: 'give-way' },
  });
  for (const text of ['b', '= 3', 'b =', 'b = boar']) {
    const found = parseLabelMap(`a = 14\n${text}`, LABELS);
    assert.match('error' in found ? found.error : '', /^Line 2/, text);
  }
});
