// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { attributesAt } from '../../../static/js/model/documents.js';
import { setAttribute, selectedAttributes, toggleAttribute } from '../../../static/js/operations/attributes.js';
import { setLabels } from '../../../static/js/store/actions/page.js';
import { changeReview } from '../../../static/js/store/actions/review.js';
import { createEditorFixture } from '../editing/editor_fixture.js';
import { attribute, label } from '../labels.js';
import { rowsOf } from '../pluck.js';

const stop = label({
  id: 14,
  attributes: [
    attribute({ name: 'lit', kind: 'select', values: ['day', 'night'] }),
    attribute({ name: 'damaged' }),
    attribute({ name: 'temporary', mutable: true }),
  ],
});

test('keys tick the checkboxes of the label in their order; those that may change do so from here on', async () => {
  const { store, editor, server, review, end } = await createEditorFixture();
  const app = { store, edit: editor.edit };
  /** @type {string[]} */ const said = [];
  const toggle = (/** @type {number} */ digit) => toggleAttribute(app, digit, (text) => void said.push(text));
  toggle(1);
  store.dispatch((state) => setLabels(changeReview(state, { selected: 'm1', frame: 20 }), [stop]));
  editor.edit({ name: 'relabel_track', key: 'm1', frame: 20, class_id: 14 });
  toggle(1);
  toggle(2);
  toggle(3);
  await editor.settled();
  assert.deepEqual(attributesAt(review().docs.m1, 19), { damaged: true });
  assert.deepEqual(attributesAt(review().docs.m1, 20), { damaged: true, temporary: true });
  assert.equal(review().docs.m1.keys[20].box, null, 'the box stays the engine’s');
  store.dispatch(changeReview, { frame: 30 });
  toggle(2);
  setAttribute(app, 'lit', 'night', false);
  await editor.settled();
  assert.deepEqual(
    [29, 30].map((frame) => attributesAt(review().docs.m1, frame).temporary),
    [true, false],
  );
  assert.deepEqual(rowsOf(selectedAttributes(store.get()), 'name', 'value'), [
    ['lit', 'night'],
    ['damaged', true],
    ['temporary', false],
  ]);
  await editor.undo();
  assert.deepEqual(review().docs.m1.attributes, { damaged: true });
  assert.deepEqual(said, [
    'The label has no checkbox 1. Add attributes to it on the Labels page.',
    'damaged: yes',
    'temporary: yes, from this frame on',
    'The label has no checkbox 3. Add attributes to it on the Labels page.',
    'temporary: no, from this frame on',
  ]);
  assert.equal(server.log.filter((name) => name === 'attribute').length, 4);
  end();
});
