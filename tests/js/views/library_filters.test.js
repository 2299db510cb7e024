// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { NO_FILTERS, matchQuery } from '../../../static/js/views/library_filters.js';
import { label } from '../labels.js';

const LABELS = [
  label({ id: 13, key: 'give-way', name: 'give way', aliases: ['yield'] }),
  label({ id: 50, key: 'hump', name: 'hump bridge' }),
];
const queryOf = (/** @type {object} */ chosen) => matchQuery({ ...NO_FILTERS, ...chosen }, LABELS);

test('filters become one query; without filters there is none', () => {
  assert.equal(queryOf({ label: '  ' }), null);
  assert.equal(queryOf({ value: 'yes' }), null, 'an answer without an attribute');
  assert.deepEqual(queryOf({ label: ' Yield ' }), { label: 'give-way' });
  assert.deepEqual(queryOf({ label: 'not in the set', state: 'open' }), { label: '-1', state: 'open' });
  assert.deepEqual(queryOf({ attribute: 'dirty', value: 'true' }), { attribute: 'dirty', value: 'true' });
  assert.deepEqual(queryOf({ attribute: 'dirty' }), { attribute: 'dirty' });
  assert.deepEqual(queryOf({ label: '#50' }), { label: 'hump' });
});

test('a name without a label is reported; a bare number is not a label', () => {
  assert.deepEqual(queryOf({ label: 'boar', state: 'open' }), { error: 'No label is called “boar”.' });
  assert.deepEqual(queryOf({ label: '50' }), { error: 'No label is called “50”.' });
});
