// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { NEW_ATTRIBUTE, changeOf, formOf } from '../../../static/js/model/label_form.js';
import { attribute, label } from '../labels.js';

const stop = label({
  id: 14,
  key: 'stop',
  name: 'stop',
  aliases: ['halt'],
  size_mm: 900,
  pinned: 2,
  colour: '#aa0000',
  attributes: [
    attribute({ name: 'dirty', mutable: true, default: false }),
    attribute({ name: 'ground', kind: 'select', values: ['red', 'yellow'], default: 'red' }),
  ],
});

test('what nobody has changed changes nothing', () => assert.deepEqual(changeOf(stop, formOf(stop)), { change: null }));

test('only changed fields are sent', () => {
  const form = { ...formOf(stop), name: ' Stop! ', aliases: 'halt\n\n  B2a \nhalt', pinned: '', size_mm: '' };
  assert.deepEqual(changeOf(stop, form), {
    change: { type: 'update', id: 14, name: 'Stop!', aliases: ['halt', 'B2a'], pinned: null, size_mm: null },
  });
});

test('a new label has the typed fields, and a key only if one was typed', () => {
  const form = {
    ...formOf(null),
    name: 'no parking',
    attributes: [{ ...NEW_ATTRIBUTE, name: 'width', kind: /** @type {const} */ ('number'), low: '0', high: '2.5', start: '1' }],
  };
  const found = changeOf(null, form);
  assert.ok('change' in found && found.change);
  assert.equal(found.change.type, 'add');
  assert.ok(!('key' in found.change));
  assert.equal(found.change.pinned, null);
  assert.deepEqual(found.change.attributes, [{ name: 'width', kind: 'number', mutable: false, values: [], low: 0, high: 2.5, default: 1 }]);
  const keyed = changeOf(null, { ...form, key: ' C,19 ' });
  assert.equal('change' in keyed && keyed.change?.key, 'C,19');
});

test('a stored value that the form refuses can be corrected', () => {
  const narrow = { ...stop, attributes: [attribute({ name: 'angle', kind: 'number', low: 1e-7 })] };
  const form = formOf(narrow);
  assert.match(Object(changeOf(narrow, form)).error, /the smallest value must be a number, not “1e-7”/);
  const { change } = Object(changeOf(narrow, { ...form, attributes: [{ ...form.attributes[0], low: '0' }] }));
  assert.equal(change.attributes[0].low, 0);
});

test('invalid input gives a sentence', () => {
  const withOne = (/** @type {object} */ more) => ({ ...formOf(stop), attributes: [{ ...NEW_ATTRIBUTE, name: 'a', ...more }] });
  for (const [form, words] of /** @type {[any, RegExp][]} */ ([
    [{ ...formOf(stop), name: ' ' }, /name/],
    [{ ...formOf(stop), size_mm: '1e3' }, /width must be a number/],
    [withOne({ name: ' ' }), /every attribute a name/],
    [withOne({ kind: 'select', values: ' \n' }), /one per line/],
    [withOne({ kind: 'select', values: 'x\ny', start: 'z' }), /one of its values/],
    [withOne({ kind: 'number', low: 'few' }), /the smallest value must be a number, not “few”/],
  ])) {
    const found = changeOf(stop, form);
    assert.match('error' in found ? found.error : '', words);
  }
});
