// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { attributeChoices, attributeProblem, attributeRows, hasAttribute, valueOfText } from '../../../static/js/model/attributes.js';
import { withAttribute } from '../../../static/js/model/relabel.js';
import { emptyDoc } from '../../../static/js/model/documents.js';
import { attribute, label } from '../labels.js';
import { rowsOf } from '../pluck.js';

const stop = label({
  id: 14,
  attributes: [
    attribute({ name: 'temporary', mutable: true, default: false }),
    attribute({ name: 'lit', kind: 'select', values: ['day', 'night'] }),
    attribute({ name: 'metres', kind: 'number', low: 0, high: 90 }),
    attribute({ name: '__proto__' }),
  ],
});
const doc = emptyDoc({ track: 1, first: 0, last: 99 });

test('the form has the attributes of the label in its order, with what holds in the frame', () => {
  const edited = withAttribute(withAttribute(doc, 'temporary', true, 10), 'lit', 'night', null);
  const rows = attributeRows(stop, edited, 12);
  assert.deepEqual(rowsOf(rows, 'name', 'value', 'given', 'changes', 'digit'), [
    ['temporary', true, true, true, 1],
    ['lit', 'night', true, false, 0],
    ['metres', null, false, false, 0],
    ['__proto__', null, false, false, 2],
  ]);
  assert.deepEqual(attributeRows(stop, edited, 9)[0], {
    name: 'temporary',
    attribute: stop.attributes[0],
    value: false,
    given: false,
    changes: true,
    digit: 1,
  });
  assert.equal(attributeRows(stop, null, 0).length, 4);
});

test('a value left over from an earlier label is shown and can be removed', () => {
  const edited = withAttribute(doc, 'colour', 'red', null);
  assert.deepEqual(attributeRows(label({ id: 3 }), edited, 0), [
    { name: 'colour', attribute: null, value: 'red', given: true, changes: false, digit: 0 },
  ]);
  assert.deepEqual(attributeRows(undefined, withAttribute(edited, 'colour', null, null), 0), []);
});

test('values that are none, in the words of the form', () => {
  const [temporary, lit, metres] = stop.attributes;
  const text = attribute({ name: 'note', kind: 'text' });
  for (const [one, value] of /** @type {[typeof lit, any][]} */ ([
    [temporary, true],
    [lit, 'day'],
    [metres, 0],
    [metres, 90],
    [text, '<b> é 🚸'],
  ]))
    assert.equal(attributeProblem(one, value), null);
  assert.equal(attributeProblem(metres, 91), 'metres must be within 0 and 90.');
  assert.equal(attributeProblem({ ...metres, low: null }, 91), 'metres must be at most 90.');
  assert.equal(attributeProblem({ ...metres, high: null }, -1), 'metres must be at least 0.');
  assert.equal(attributeProblem(lit, 'dusk'), 'lit must be one of day, night.');
  assert.equal(attributeProblem(text, 'x'.repeat(1001)), 'note must have at most 1000 characters.');
  for (const value of [Number.NaN, Infinity, true, '4']) assert.equal(attributeProblem(metres, value), 'metres must be a number.');
  assert.deepEqual([valueOfText(metres, ' 2.5 '), valueOfText(text, '2.5'), valueOfText(text, ' ')], [2.5, '2.5', null]);
});

test('filters: what can be chosen, and which tracks have it in any frame', () => {
  const edited = withAttribute(withAttribute(doc, 'temporary', true, 10), 'metres', 4, null);
  const left = withAttribute(emptyDoc({ track: 2, first: 0, last: 9 }), 'colour', 'red', null);
  assert.deepEqual(rowsOf(attributeChoices([stop], [edited, left]), 'name', 'values'), [
    ['__proto__', [true, false]],
    ['colour', ['red']],
    ['lit', ['day', 'night']],
    ['metres', [4]],
    ['temporary', [true, false]],
  ]);
  assert.ok(hasAttribute(stop, edited, 'temporary', true));
  assert.ok(hasAttribute(stop, edited, 'temporary', false), 'before frame 10 the default counts');
  assert.ok(hasAttribute(stop, undefined, 'temporary', false));
  assert.ok(!hasAttribute(stop, withAttribute(doc, 'temporary', true, null), 'temporary', false));
  assert.ok(hasAttribute(undefined, left, 'colour', null));
  assert.ok(!hasAttribute(stop, left, 'temporary', null), 'a default is given by nobody');
  assert.ok(!hasAttribute(stop, edited, 'toString', null));
});
