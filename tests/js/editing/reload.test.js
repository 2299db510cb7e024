// @ts-check
/** Edits over the end of a page, and before its corrections are loaded. */
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ApiError } from '../../../static/js/api/errors.js';
import { createMemoryOutbox } from '../../../static/js/editing/outbox.js';
import { waitUntil, runTimers } from '../wait_until.js';
import { RUN, failOffline, createServer, createEditorFixture, setBox } from './editor_fixture.js';

/** End a page and open the next one on a server that answers again. @param {Awaited<ReturnType<typeof createEditorFixture>>} first */
async function nextVisit(first) {
  await runTimers(10);
  first.end();
  first.server.before = () => {};
  return createEditorFixture(first.server, first.outbox);
}

test('a page that crashes loses no edit: the next page sends the rest', async () => {
  const first = await createEditorFixture();
  first.server.before = failOffline;
  first.editor.edit(setBox('m1', 5, 20));
  first.editor.edit(setBox('m1', 6, 30));
  const second = await nextVisit(first);
  assert.equal(Object.keys(second.review().docs.m1.keys).length, 2);
  await second.editor.settled();
  assert.deepEqual(first.server.log, ['set_box', 'set_box']);
  assert.match(second.toasts[0], /2 changes of an earlier visit/);
});

test('edits are sent in the order in which they were made, also when the clock was set back in between', async (context) => {
  const first = await createEditorFixture();
  first.server.before = failOffline;
  context.mock.timers.enable({ apis: ['Date'], now: Date.UTC(2026, 10, 25) });
  first.editor.edit(setBox('m1', 5, 20));
  context.mock.timers.setTime(Date.UTC(2026, 10, 24));
  first.editor.edit(setBox('m1', 5, 30));
  first.editor.edit({ name: 'relabel_track', key: 'm1', frame: 5, class_id: 14 });
  context.mock.timers.reset();
  const second = await nextVisit(first);
  await second.editor.settled();
  assert.deepEqual(first.server.log, ['set_box', 'set_box', 'relabel_track']);
  assert.deepEqual(first.server.docs.m1.keys[5].box, [30, 30, 40, 40]);
});

test('a crash between two edits of a track causes no conflict', async () => {
  const first = await createEditorFixture();
  let calls = 0;
  first.server.before = () => {
    if (++calls > 1) failOffline();
  };
  first.editor.edit(setBox('m1', 5, 20));
  first.editor.edit(setBox('m1', 6, 30));
  const second = await nextVisit(first);
  await second.editor.settled();
  assert.equal(first.server.docs.m1.revision, 2);
  assert.equal(second.store.get().dialog, null);
});

test('an edit made before the documents arrive is shown as unsaved and sent after their arrival', async () => {
  const { editor, server, review, toasts } = await createEditorFixture();
  editor.close();
  const opened = editor.open('r'.repeat(32));
  assert.equal(editor.edit(setBox('m1', 5, 20)), true);
  assert.equal(review().unsaved.length, 1);
  assert.deepEqual(review().docs.m1.keys[5].box, [20, 20, 30, 30]); // the next press of an arrow goes on from here
  assert.deepEqual(server.log, []);
  await opened;
  await editor.settled();
  assert.deepEqual(server.log, ['set_box']);
  assert.deepEqual([review().unsaved.length, toasts.length], [0, 0]);
  assert.deepEqual(review().docs.m1.keys[5].box, [20, 20, 30, 30]);
});

test('an edit made before the documents arrive survives a reload and is sent once', async () => {
  const outbox = createMemoryOutbox();
  const { editor, server, review, toasts } = await createEditorFixture(createServer(), outbox, null);
  const read = server.annotation;
  let stored = /** @type {import('../../../static/js/editing/outbox.js').Pending[]} */ ([]);
  server.annotation = async () => {
    stored = await outbox.load(RUN);
    return read();
  };
  const opened = editor.open(RUN);
  editor.edit(setBox('m1', 5, 20));
  editor.edit(setBox('m2', 60, 30));
  editor.edit(setBox('m7', 60, 30)); // makes no sense, as the documents tell; what takes it back takes back nothing else
  void editor.undo();
  await opened;
  await editor.settled();
  assert.deepEqual(
    stored.map(({ command, seen }) => [command.name, seen]),
    [
      ['set_box', { m1: 0 }],
      ['set_box', { m2: 0 }],
      ['set_box', { m7: 0 }],
      ['undo', {}],
    ],
  );
  assert.deepEqual(server.log, ['set_box', 'set_box']);
  assert.deepEqual([review().unsaved.length, await outbox.all()], [0, []]);
  assert.deepEqual(
    toasts.filter((text) => text.includes('earlier visit')),
    [],
  );
});

test('changes by others during loading are shown together with unsent edits of an earlier visit', async () => {
  const outbox = createMemoryOutbox();
  const { editor, server, review, store } = await createEditorFixture(createServer(), outbox, null);
  // the first of two has been sent out of the outbox; word of it comes while the documents are read, and of other work, too
  const { docs } = await server.edit(RUN, { op_id: 'one', command: setBox('m1', 5, 20) }, { m1: 0 });
  await outbox.put({ op_id: 'two', run: RUN, author: 'a', command: setBox('m1', 6, 30), seen: { m1: 1 } });
  const read = server.annotation;
  let asked = 0;
  server.annotation = async () => {
    const answer = structuredClone(await read());
    if (asked++ === 0) {
      editor.receive(docs, 'one', 'a');
      editor.receive(server.editAsOther({ name: 'set_review', key: 'm2', frame: 60, review: 'accepted' }), 'theirs', 'b');
    }
    return answer;
  };
  /** @type {string[][]} */
  const seen = [];
  store.subscribe(() => {
    const m1 = review().docs.m1;
    if (m1) seen.push(Object.keys(m1.keys));
  });
  await editor.open(RUN);
  await editor.settled();
  assert.ok(seen.length > 0);
  for (const frames of seen) assert.deepEqual(frames, ['5', '6']);
  assert.equal(review().docs.m2.review, 'accepted', 'the answer was older than what came before it');
  assert.deepEqual(Object.keys(server.docs.m1.keys), ['5', '6']);
  assert.ok(asked > 1, 'what can be taken back was asked anew');
});

test("others' changes that could not be read after missed events are read when the server answers", async () => {
  const { editor, server, review, end } = await createEditorFixture();
  const { annotation } = server;
  server.annotation = () => Promise.reject(new ApiError(0, 'offline', 'Gone.'));
  server.editAsOther(setBox('m1', 5, 20));
  await editor.refresh();
  assert.equal(review().docs.m1, undefined);
  await editor.refresh();
  server.annotation = annotation;
  await waitUntil(() => review().docs.m1?.keys[5]);
  end();
});
