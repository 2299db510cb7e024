// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { NO_FILTERS, matchQuery } from '../../../static/js/views/library_filters.js';
import { label } from '../labels.js';

const LABELS = [
  label({ id: 13, key: 'give-way', name: 'give way', aliases: ['yield'] }),
  label({ id: 50, key: 'hump', name: 'hump bridge' }),
];
const asked = (/** @type {object} */ chosen) => matchQuery({ ...NO_FILTERS, ...chosen }, LABELS);

test('what is chosen becomes one question; nothing chosen asks nothing', () => {
  assert.equal(asked({ label: '  ' }), null);
  assert.equal(asked({ value: 'yes' }), null, 'an answer without an attribute');
  assert.deepEqual(asked({ label: ' Yield ' }), { label: 'give-way' });
  assert.deepEqual(asked({ label: 'not in the set', state: 'open' }), { label: '-1', state: 'open' });
  assert.deepEqual(asked({ attribute: 'dirty', value: 'true' }), { attribute: 'dirty', value: 'true' });
  assert.deepEqual(asked({ attribute: 'dirty' }), { attribute: 'dirty' });
  assert.deepEqual(asked({ label: '#50' }), { label: 'hump' });
});

test('a name without a label is reported; a bare number is not a label', () => {
  assert.deepEqual(asked({ label: 'boar', state: 'open' }), { error: 'No label is called “boar”.' });
  assert.deepEqual(asked({ label: '50' }), { error: 'No label is called “50”.' });
});
