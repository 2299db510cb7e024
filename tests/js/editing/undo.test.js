// @ts-check
/** Undo and redo: about what was done last when the key is pressed, whatever the server has by then. */
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { deferred } from '../deferred.js';
import { RUN, failOffline, createServer, createEditorFixture, setBox } from './editor_fixture.js';

const relabel = (/** @type {string} */ key) => /** @type {any} */ ({ name: 'relabel_track', key, frame: 5, class_id: 14 });
const note = (/** @type {string} */ key) =>
  /** @type {any} */ ({ name: 'add_note', key, frame: 7, note_id: 'n'.repeat(32), text: 'Half hidden.' });

test('an undo reverts the edit before it, not one after it, however late the server answers', async () => {
  const { editor, server, review } = await createEditorFixture();
  server.before = failOffline;
  editor.edit(setBox('m1', 5, 20));
  void editor.undo();
  assert.deepEqual(review().docs.m1.keys, {}, 'shown at once');
  editor.edit(relabel('m1'));
  server.before = () => {};
  await editor.settled();
  assert.deepEqual(server.log, ['set_box', 'undo', 'relabel_track']);
  assert.deepEqual([server.docs.m1.keys, server.docs.m1.class_id], [{}, 14]);
  assert.deepEqual(review().docs, server.docs);
});

test('after a crash of the page, edits after an undo are there, and undone ones are not', async () => {
  const first = await createEditorFixture();
  first.server.before = failOffline;
  first.editor.edit({ name: 'set_review', key: 'm1', frame: 5, review: 'needs_work' });
  first.editor.edit(setBox('m2', 60, 20));
  void first.editor.undo();
  first.editor.edit(note('m2'));
  assert.deepEqual(first.toasts, ['Undone: box corrected in frame 60']);
  await new Promise((resolve) => setTimeout(resolve, 5));
  first.end();
  first.server.before = () => {};
  const second = await createEditorFixture(first.server, first.outbox);
  assert.deepEqual(second.review().docs.m2.keys, {});
  await second.editor.settled();
  assert.deepEqual(first.server.log, ['set_review', 'set_box', 'undo', 'add_note']);
  assert.deepEqual([first.server.docs.m2.keys, first.server.docs.m2.notes.length, first.server.docs.m1.review], [{}, 1, 'needs_work']);
});

test('redo reverts a pending undo; a new edit clears the redo history', async () => {
  const { editor, server, review, toasts } = await createEditorFixture();
  server.before = failOffline;
  editor.edit(setBox('m1', 5, 20));
  editor.edit(setBox('m1', 6, 30));
  for (const what of /** @type {const} */ (['undo', 'undo', 'redo'])) void editor[what]();
  assert.deepEqual(Object.keys(review().docs.m1.keys), ['5']);
  assert.equal(review().redo?.frame, 6);
  editor.edit(relabel('m1'));
  assert.equal(review().redo, null);
  void editor.redo();
  server.before = () => {};
  await editor.settled();
  assert.deepEqual(server.log, ['set_box', 'set_box', 'undo', 'undo', 'redo', 'relabel_track']);
  assert.deepEqual([Object.keys(server.docs.m1.keys), review().docs], [['5'], server.docs]);
  assert.equal(toasts.at(-1), 'There is nothing to redo.');
});

test('undo of this page’s edits is shown at once, of earlier ones when the server answers', async () => {
  const first = await createEditorFixture();
  first.editor.edit(setBox('m1', 5, 20));
  await first.editor.settled();
  const second = await createEditorFixture(first.server, first.outbox);
  second.editor.edit(setBox('m1', 6, 30));
  await second.editor.settled();
  second.server.before = failOffline;
  for (let k = 0; k < 2; k++) void second.editor.undo();
  assert.deepEqual(Object.keys(second.review().docs.m1.keys), ['5']);
  assert.deepEqual(second.toasts, [
    'Undone: box corrected in frame 6',
    'Waiting for the server: undo (box corrected in frame 5) follows its answer.',
  ]);
  second.editor.edit(relabel('m1'));
  second.server.before = () => {};
  await second.editor.settled();
  assert.deepEqual(second.server.log.slice(2), ['undo', 'undo', 'relabel_track']);
  assert.deepEqual([second.server.docs.m1.keys, second.server.docs.m1.class_id, second.review().docs], [{}, 14, second.server.docs]);
  assert.equal(second.toasts.at(-1), 'Undone: box corrected in frame 5');
});

test('an edit that was undone before its conflict is dropped without a question', async () => {
  const { editor, server, store, outbox, review } = await createEditorFixture();
  server.before = failOffline;
  editor.edit(setBox('m1', 5, 20));
  void editor.undo();
  server.editAsOther({ name: 'set_review', key: 'm1', frame: 0, review: 'accepted' });
  server.before = () => {};
  await editor.settled();
  assert.deepEqual([store.get().dialog, server.log, await outbox.load(RUN)], [null, [], []]);
  assert.deepEqual([review().docs.m1.review, review().unsaved], ['accepted', []]);
});

test('an undo before the documents arrive keeps its position among the edits', async () => {
  const { editor, server, review } = await createEditorFixture();
  editor.edit(setBox('m2', 60, 20));
  await editor.settled();
  editor.close();
  const opened = editor.open(RUN);
  editor.edit(setBox('m1', 5, 20));
  void editor.undo();
  assert.equal(review().docs.m1.keys[5], undefined);
  editor.edit(relabel('m1'));
  await opened;
  await editor.settled();
  assert.deepEqual(server.log, ['set_box', 'set_box', 'undo', 'relabel_track']);
  assert.deepEqual([server.docs.m1.keys, server.docs.m1.class_id], [{}, 14]);
});

test('undo includes edits of the same person in another page', async () => {
  const server = createServer();
  const [one, other] = [await createEditorFixture(server), await createEditorFixture(server)];
  one.editor.edit(setBox('m1', 5, 20));
  await one.editor.settled();
  const reported = () => {
    other.editor.receive(structuredClone(Object.values(server.docs)), String(server.log.length), 'a');
    return new Promise((resolve) => setTimeout(resolve, 5));
  };
  await reported();
  assert.equal(other.review().undo?.frame, 5);
  await other.editor.undo();
  assert.deepEqual([server.log, server.docs.m1.keys], [['set_box', 'undo'], {}]);
  assert.deepEqual(other.toasts, [
    'Waiting for the server: undo (box corrected in frame 5) follows its answer.',
    'Undone: box corrected in frame 5',
  ]);
  // pressed before the answer to what was heard: it is about what the server says then
  one.editor.edit(setBox('m2', 60, 20));
  await one.editor.settled();
  void reported();
  await other.editor.undo();
  assert.deepEqual([server.log.at(-1), server.docs.m2.keys], ['undo', {}]);
});

test('a page that missed changes of another page says so, and is current afterwards', async () => {
  const server = createServer();
  const [one, other] = [await createEditorFixture(server), await createEditorFixture(server)];
  other.editor.edit(setBox('m1', 5, 20));
  await other.editor.settled();
  one.editor.edit(setBox('m2', 60, 20));
  await one.editor.settled();
  await other.editor.undo();
  assert.match(other.toasts.at(-1) ?? '', /You have made other changes in another page since/);
  assert.deepEqual(Object.keys(other.review().docs.m1.keys), ['5'], 'as the server has it');
  await other.editor.undo();
  assert.deepEqual([server.log, server.docs.m2.keys], [['set_box', 'set_box', 'undo'], {}]);
});

test('moves by keys without a pause are one operation with the final box', async () => {
  const { editor, server, review, outbox } = await createEditorFixture();
  for (let k = 1; k <= 20; k++) editor.edit(setBox('m1', 5, 20 + k), RUN, 'move');
  assert.deepEqual([review().docs.m1.keys[5].box?.[0], review().unsaved.length], [40, 1]);
  assert.deepEqual(
    (await outbox.load(RUN)).map(({ command }) => Reflect.get(command, 'box')[0]),
    [40],
    'none of it is lost with the page',
  );
  for (let k = 1; k <= 5; k++) editor.edit(setBox('m1', 5, 40 + k), RUN, 'resize');
  editor.edit(setBox('m1', 6, 0), RUN, 'resize');
  await editor.settled();
  assert.deepEqual(server.log, ['set_box', 'set_box', 'set_box']);
  await editor.undo();
  await editor.undo();
  assert.deepEqual(server.docs.m1.keys[5].box?.[0], 40);
  for (const at of [50, 51]) editor.edit(setBox('m1', 5, at), RUN, 'move');
  const undone = editor.undo();
  assert.equal(review().docs.m1.keys[5].box?.[0], 40, 'what is moved is taken back whole');
  await undone;
  for (const at of [60, 61]) editor.edit(setBox('m1', 5, at), RUN, 'move');
  await new Promise((resolve) => setTimeout(resolve, 1100));
  await editor.settled();
  editor.edit(setBox('m1', 5, 62), RUN, 'move');
  await editor.settled();
  await editor.undo();
  assert.equal(server.docs.m1.keys[5].box?.[0], 61, 'after a pause it is another step');
});

test('an answer between two key presses does not split their operation', async () => {
  const { editor, server } = await createEditorFixture();
  const answer = deferred();
  const { edit } = server;
  server.edit = async (...given) => {
    await answer.promise;
    return edit(...given);
  };
  editor.edit({ name: 'set_review', key: 'm1', frame: 5, review: 'accepted' });
  editor.edit(setBox('m1', 5, 20), RUN, 'move');
  answer.resolve();
  await new Promise((resolve) => setTimeout(resolve, 5));
  editor.edit(setBox('m1', 5, 21), RUN, 'move');
  await editor.settled();
  assert.deepEqual([server.log, server.docs.m1.keys[5].box?.[0]], [['set_review', 'set_box'], 21]);
});
