// @ts-check
/** The label set changes while a page is open: an id of the old one is never taken for a label of the new one. */
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ApiError } from '../../../static/js/api/errors.js';
import { createMemoryOutbox } from '../../../static/js/editing/outbox.js';
import { withLabelKey } from '../../../static/js/model/labels.js';
import { setLabels } from '../../../static/js/store/actions/page.js';
import { label } from '../labels.js';
import { RUN, createServer, createEditorFixture } from './editor_fixture.js';
import { pluck } from '../pluck.js';

const LABELS = [label({ id: 43, key: 'bus-stop', name: 'bus stop' }), label({ id: 44, key: 'halt', name: 'halt', merged_into: 43 })];

/** A server whose set has lost the label `gone`. @param {any[]} sent */
function serverWithoutLabel(sent) {
  const server = createServer();
  const { edit } = server;
  server.edit = async (run, one, revisions) => {
    sent.push(one.command);
    if (one.command.label_key === 'gone') throw new ApiError(422, 'no_such_label', 'The label set has no label gone.');
    return edit(run, one, revisions);
  };
  return server;
}

const createTrack = (/** @type {string} */ key) =>
  /** @type {any} */ ({ name: 'create_track', key, frame: 3, box: [0, 0, 9, 9], class_id: 43, label_key: 'gone' });

test('a command says which label it means, by key', () => {
  const relabel = /** @type {any} */ ({ name: 'relabel_track', key: 'm1', frame: 0, class_id: 43 });
  assert.equal(withLabelKey(relabel, LABELS).label_key, 'bus-stop');
  assert.equal(withLabelKey({ ...relabel, class_id: 44 }, LABELS).label_key, 'halt', 'the one that was given, not what stands for it');
  assert.equal(withLabelKey({ ...relabel, label_key: 'old' }, LABELS).label_key, 'old', 'what was chosen before the set changed');
  for (const class_id of [-1, null, 7]) assert.equal('label_key' in withLabelKey({ ...relabel, class_id }, LABELS), false);
});

test('a sent command names its label by key, also after a reload', async () => {
  /** @type {any[]} */ const sent = [];
  const fixture = await createEditorFixture(serverWithoutLabel(sent));
  fixture.store.dispatch(setLabels, LABELS);
  fixture.editor.edit({ name: 'relabel_track', key: 'm1', frame: 0, class_id: 43 });
  fixture.store.dispatch(setLabels, [label({ id: 43, key: 'boar', name: 'boar' })]);
  await fixture.editor.settled();
  assert.deepEqual(pluck(sent, 'label_key'), ['bus-stop']);
  fixture.end();
});

test('a drawn track is stored without a label that no longer exists', async () => {
  /** @type {any[]} */ const sent = [];
  const fixture = await createEditorFixture(serverWithoutLabel(sent));
  fixture.editor.edit(createTrack('hdrawn01'));
  fixture.editor.edit({ name: 'relabel_track', key: 'm1', frame: 0, class_id: 43, label_key: 'gone' });
  await fixture.editor.settled();
  assert.equal(fixture.review().docs.hdrawn01.class_id, null);
  assert.equal(fixture.review().docs.m1, undefined, 'the engine says what it is, as before');
  assert.match(fixture.toasts[0], /^The new track has no label yet\. The label set has no label gone\./);
  assert.match(fixture.toasts[1], /^Track relabelled was not possible\./);
  assert.equal((await fixture.outbox.all()).length, 0);
  fixture.end();
});

test('a drawn track of a closed review is also stored without its deleted label', async () => {
  /** @type {any[]} */ const sent = [];
  const outbox = createMemoryOutbox();
  await outbox.put({ op_id: 'op-left-0001', run: RUN, author: 'a', command: createTrack('hdrawn02'), seen: {} });
  const fixture = await createEditorFixture(serverWithoutLabel(sent), outbox, null);
  await fixture.backgroundSender.flush();
  assert.equal(fixture.server.docs.hdrawn02.class_id, null);
  assert.deepEqual(pluck(sent, 'class_id'), [43, null]);
  assert.match(fixture.toasts[0], /^A new track has no label yet\./);
  fixture.end();
});
