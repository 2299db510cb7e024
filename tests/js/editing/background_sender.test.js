// @ts-check
/** Edits of a run that is not open. */
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { ApiError } from '../../../static/js/api/errors.js';
import { unsavedOf } from '../../../static/js/store/unsaved.js';
import { runTimers } from '../wait_until.js';
import { RUN, failOffline, createEditorFixture, setBox } from './editor_fixture.js';
import { pluck } from '../pluck.js';

test('edits of a closed review are still sent, and unsent ones counted', async () => {
  const { editor, server, store, outbox } = await createEditorFixture();
  server.before = failOffline;
  for (const frame of [5, 6]) editor.edit(setBox('m1', frame, 20));
  editor.edit(setBox('m2', 60, 20), RUN, 'move');
  editor.close();
  store.dispatch((state) => ({ ...state, review: null }));
  await runTimers();
  assert.deepEqual([store.get().elsewhere, unsavedOf(store.get())], [[{ run: RUN, unsaved: 3, held: false }], { unsaved: 3, held: 0 }]);
  server.before = () => {};
  await runTimers();
  await runTimers();
  assert.deepEqual([server.log, store.get().elsewhere, await outbox.all()], [['set_box', 'set_box', 'set_box'], [], []]);
});

test('unsent edits and undos of an earlier visit are sent although their run is not open', async () => {
  const first = await createEditorFixture();
  first.editor.edit(setBox('m1', 5, 20));
  await first.editor.settled();
  first.server.before = failOffline;
  first.editor.edit(setBox('m1', 6, 20));
  for (let k = 0; k < 2; k++) void first.editor.undo();
  await runTimers();
  first.end();
  first.server.before = () => {};
  const second = await createEditorFixture(first.server, first.outbox, null);
  await second.backgroundSender.flush();
  assert.deepEqual(first.server.log, ['set_box', 'set_box', 'undo', 'undo']);
  assert.deepEqual([first.server.docs.m1.keys, await first.outbox.all()], [{}, []]);
});

test('an answer that arrives after its review was closed rebases the later edits', async () => {
  const { editor, server, outbox } = await createEditorFixture();
  /** @type {() => void} */
  let answer = () => {};
  const { edit } = server;
  let first = true;
  server.edit = async (...given) => {
    if (first) {
      first = false;
      await new Promise((resolve) => (answer = () => resolve(undefined)));
    }
    return edit(...given);
  };
  for (const frame of [5, 6]) editor.edit(setBox('m1', frame, 20));
  await runTimers();
  editor.close();
  answer();
  await runTimers();
  assert.deepEqual([server.log, server.docs.m1.revision, await outbox.all()], [['set_box', 'set_box'], 2, []]);
});

test('an edit in conflict waits for a decision; other runs are sent', async () => {
  const { editor, server, store, outbox } = await createEditorFixture();
  server.before = failOffline;
  editor.edit(setBox('m1', 5, 20));
  server.editAsOther({ name: 'set_review', key: 'm1', frame: 0, review: 'accepted' });
  await outbox.put({ op_id: 'elsewhere', run: 's'.repeat(32), author: 'a', command: setBox('m2', 60, 20), seen: { m2: 0 } });
  editor.close();
  server.before = () => {};
  await runTimers();
  assert.deepEqual(server.log, ['set_box']);
  assert.deepEqual(store.get().elsewhere, [{ run: RUN, unsaved: 1, held: true }]);
  assert.match(store.get().banners.find(({ id }) => id === 'elsewhere')?.text ?? '', /A change of another run is not saved/);
  await editor.open(RUN);
  await editor.settled();
  assert.deepEqual([store.get().elsewhere, store.get().banners.map(({ id }) => id)], [[], ['conflict']]);
  assert.equal(store.get().dialog?.kind, 'conflict');
});

test('edits of a deleted run are dropped with a message', async () => {
  const { editor, server, outbox, toasts } = await createEditorFixture();
  server.before = failOffline;
  for (const frame of [5, 6]) editor.edit(setBox('m1', frame, 20));
  editor.close();
  server.before = () => {
    throw new ApiError(404, 'not_found', 'There is no run.');
  };
  await runTimers();
  assert.deepEqual([await outbox.all(), toasts], [[], ['2 unsaved changes are given up: the run was removed.']]);
});

test('edits before the corrections have loaded are kept when the review is closed', async () => {
  const { editor, server, outbox } = await createEditorFixture();
  editor.close();
  void editor.open(RUN);
  editor.edit(setBox('m1', 5, 20));
  editor.close();
  await runTimers();
  assert.deepEqual([server.log, await outbox.all()], [['set_box'], []]);
});

for (const { what, status, code } of [
  { what: 'whose video has become another file', status: 409, code: 'file_changed' },
  { what: 'that lies with another server', status: 503, code: 'elsewhere' },
])
  test(`a run ${what} holds up no other`, async () => {
    const { editor, server, outbox } = await createEditorFixture();
    const { edit } = server;
    let isBack = false;
    server.edit = async (...given) => {
      if (given[0] === RUN && !isBack) throw new ApiError(status, code, 'Not now.');
      return edit(...given);
    };
    editor.edit(setBox('m1', 5, 20));
    await outbox.put({ op_id: 'elsewhere', run: 's'.repeat(32), author: 'a', command: setBox('m2', 60, 20), seen: { m2: 0 } });
    editor.close();
    await runTimers();
    assert.deepEqual(pluck(await outbox.all(), 'run'), [RUN]);
    isBack = true;
    await runTimers();
    assert.deepEqual([server.log, await outbox.all()], [['set_box', 'set_box'], []]);
  });
