// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { findItems, prepareItems } from '../../../static/js/model/palette.js';

const ITEMS = prepareItems([
  { text: 'Delete the whole track' },
  { text: 'Deleted tracks', also: 'What was deleted' },
  { text: 'Track #7 · stop', also: '7' },
  { text: 'Track #17 · no stopping', also: '17' },
  { text: 'Überholverbot', also: '276 no_overtaking' },
  { text: '禁止停车' },
]);
/** @param {string} typed */
const find = (typed) => findItems(ITEMS, typed, 10).found.map(({ text }) => text);

test('every word must be there; whole words come before beginnings, and these before what is inside', () => {
  assert.deepEqual(find('track 7'), ['Track #7 · stop', 'Track #17 · no stopping']);
  assert.deepEqual(find('#7'), ['Track #7 · stop']);
  assert.deepEqual(find('stop'), ['Track #7 · stop', 'Track #17 · no stopping']);
  assert.deepEqual(find('track delete'), ['Delete the whole track', 'Deleted tracks']);
  assert.deepEqual(find('delete').at(-1), 'Deleted tracks');
  assert.deepEqual(find('stop give'), []);
});

test('letters in order find an item from the start of a word, after what fits better', () => {
  assert.deepEqual(find('dtr'), ['Delete the whole track', 'Deleted tracks']);
  assert.deepEqual(find('xyz'), []);
});

test('names of any script, also by key', () => {
  assert.deepEqual(find('über'), ['Überholverbot']);
  assert.deepEqual(find('no'), ['Track #17 · no stopping', 'Überholverbot'], 'what stands beside the text comes last');
  assert.deepEqual(find('overtaking'), ['Überholverbot']);
  assert.deepEqual(find('停车'), ['禁止停车']);
});

test('an empty search finds everything, up to the limit', () => {
  assert.equal(find('').length, ITEMS.length);
  const { found, total } = findItems(ITEMS, 't', 2);
  assert.deepEqual([found.length, total], [2, 5]);
});

test('5,000 tracks and 400 labels are searched within a keystroke', () => {
  const many = prepareItems([
    ...Array.from({ length: 400 }, (_, i) => ({ text: `${'very '.repeat(30)}long name of label ${i}`, also: `key_${i}` })),
    ...Array.from({ length: 5000 }, (_, i) => ({ text: `Track #${i} · speed limit ${i % 13}0 km/h`, also: String(i) })),
  ]);
  const times = ['s', 'sp', 'speed 4999', 'tslk', 'zzzzzz'].map((typed) => {
    const began = performance.now();
    findItems(many, typed, 60);
    return performance.now() - began;
  });
  assert.ok(Math.min(...times) >= 0 && Math.max(...times) < 250, `${times.map((ms) => ms.toFixed(1))} ms`);
});
