// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { ApiError } from '../../../static/js/api/errors.js';
import { correctedKeys } from '../../../static/js/review/shown_tracks.js';
import { closeDialog, openDialog } from '../../../static/js/store/actions/page.js';
import { select } from '../../../static/js/store/actions/review.js';
import { RUN, failOffline, createServer, createEditorFixture, setBox } from './editor_fixture.js';

test('an edit shows at once and counts as unsaved until the server has answered', async () => {
  const { editor, review, server, outbox } = await createEditorFixture();
  assert.equal(editor.edit(setBox('m1', 5, 20)), true);
  assert.deepEqual(review().docs.m1.keys[5].box, [20, 20, 30, 30]);
  assert.equal(review().unsaved.length, 1);
  assert.equal(server.log.length, 0);
  await editor.settled();
  assert.equal(review().unsaved.length, 0);
  assert.equal(review().docs.m1.revision, 1);
  assert.deepEqual(await outbox.load(RUN), []);
});

test('corrected tracks are distinguished from uncorrected ones', async () => {
  const { editor, review } = await createEditorFixture();
  assert.deepEqual(correctedKeys(review()), []);
  assert.ok(editor.edit({ name: 'add_note', key: 'm1', note_id: 'n'.repeat(32), frame: 5, text: 'Odd.' }));
  assert.ok(editor.edit({ name: 'set_review', key: 'm1', frame: 0, review: 'needs_work' }));
  assert.deepEqual(correctedKeys(review()), []);
  editor.edit(setBox('m1', 5, 20));
  assert.deepEqual(correctedKeys(review()), ['m1']);
  editor.edit({ name: 'set_review', key: 'm2', frame: 60, review: 'accepted' });
  assert.deepEqual(correctedKeys(review()).sort(), ['m1', 'm2']);
  await editor.settled();
});

test('a split is a correction of the half that stays, too', async () => {
  const { editor, review } = await createEditorFixture();
  editor.edit({ name: 'split', key: 'm2', frame: 100, new_key: `h${'0'.repeat(31)}1` });
  assert.equal(correctedKeys(review()).length, 2);
  await editor.settled();
});

test('many edits of one track in a row are all stored, each on what the one before left', async () => {
  const { editor, server, review } = await createEditorFixture();
  for (let k = 0; k < 12; k++) editor.edit(setBox('m1', k, k));
  await editor.settled();
  assert.equal(server.docs.m1.revision, 12);
  assert.equal(Object.keys(review().docs.m1.keys).length, 12);
});

test('an impossible edit is refused with its reason and nothing is sent', async () => {
  const { editor, server, toasts, review } = await createEditorFixture();
  assert.equal(editor.edit({ name: 'remove_key', key: 'm1', frame: 3 }), false);
  assert.match(toasts[0], /no key frame/);
  assert.deepEqual([server.log, review().unsaved], [[], []]);
});

test('an edit for another run than the open one is refused with a message, also for equal track keys', async () => {
  const { editor, server, toasts, review } = await createEditorFixture();
  assert.equal(editor.edit(setBox('m1', 3, 20), 's'.repeat(32)), false);
  assert.equal(toasts[0], 'Box corrected was not possible: it was meant for the run that was open before.');
  assert.deepEqual([server.log, review().unsaved], [[], []]);
  assert.equal(editor.edit(setBox('m1', 3, 20), RUN), true);
  await editor.settled();
  assert.deepEqual(server.log, ['set_box']);
});

for (const status of [0, 401, 403, 500, 503, 507]) {
  test(`after ${status || 'silence'} the edit is kept and sent again under the same name`, async () => {
    const { editor, server, review, outbox } = await createEditorFixture();
    /** @type {string[]} */
    const names = [];
    server.before = (op_id) => {
      names.push(op_id);
      if (names.length < 3) throw new ApiError(status, status ? 'busy' : 'offline', 'Not now.');
    };
    editor.edit(setBox('m1', 5, 20));
    assert.equal((await outbox.load(RUN)).length, 1);
    await editor.settled();
    assert.equal(new Set(names).size, 1);
    assert.deepEqual(server.log, ['set_box']);
    assert.equal(review().unsaved.length, 0);
  });
}

for (const { what, status, code, reason } of [
  {
    what: 'another file lies in the place of the video',
    status: 409,
    code: 'file_changed',
    reason: 'drive.mp4 has changed since it was added. Put it back as it was, or add it as another video.',
  },
  {
    what: 'another server holds the files of the run',
    status: 503,
    code: 'elsewhere',
    reason: 'The files of Run 1 lie with another server (desk:/data). Ask that one.',
  },
  {
    what: 'the database restarts',
    status: 503,
    code: 'database_busy',
    reason: 'The database is away for a moment. The request can be repeated.',
  },
])
  test(`while ${what}, edits stay in sight and in the outbox, with the reason`, async () => {
    const { editor, server, store, review, outbox, toasts } = await createEditorFixture();
    let tries = 0;
    server.before = () => {
      if (++tries < 3) throw new ApiError(status, code, reason);
      const reported = store.get().banners.find(({ id }) => id === 'saving')?.text ?? '';
      assert.ok(reported.startsWith(reason), reported);
      assert.match(reported, /Your changes are kept in this page/);
      assert.deepEqual(review().docs.m1.keys[5].box, [20, 20, 30, 30]);
      assert.equal(review().unsaved.length, 1);
    };
    editor.edit(setBox('m1', 5, 20));
    assert.equal((await outbox.load(RUN)).length, 1);
    await editor.settled(); // the file is back
    assert.deepEqual([server.log, toasts, review().unsaved, store.get().banners], [['set_box'], [], [], []]);
  });

test('banners and unsent edits of a run with a changed file are removed with the run', async () => {
  const { editor, server, store, outbox, end } = await createEditorFixture();
  const refusal = new Promise((resolve) => {
    server.before = () => {
      resolve(undefined);
      throw new ApiError(409, 'file_changed', 'drive.mp4 has changed since it was added.');
    };
  });
  editor.edit(setBox('m1', 5, 20));
  await refusal;
  await new Promise((resolve) => setTimeout(resolve, 5));
  assert.equal(store.get().banners.length, 1);
  editor.close();
  assert.deepEqual(store.get().banners, []);
  assert.equal((await outbox.load(RUN)).length, 1);
  end(); // or it is tried again for ever
});

test('an answer that is lost does not store the edit twice', async () => {
  const { editor, server } = await createEditorFixture();
  let lost = 0;
  server.after = () => {
    if (lost++ === 0) failOffline();
  };
  editor.edit(setBox('m1', 5, 20));
  await editor.settled();
  assert.deepEqual(server.log, ['set_box']);
});

test('an edit made before another person saved is never applied on top without a question, even if the page knows of the save', async () => {
  const { editor, server, review, store, outbox } = await createEditorFixture();
  let down = true;
  server.before = () => {
    if (down) failOffline();
  };
  editor.edit(setBox('m1', 5, 20));
  editor.edit(setBox('m1', 6, 30));
  editor.edit(setBox('m2', 60, 5));
  editor.receive(server.editAsOther({ name: 'set_review', key: 'm1', frame: 0, review: 'accepted' }), 'theirs');
  down = false;
  await editor.settled();
  const { dialog } = store.get();
  assert.equal(dialog?.kind, 'conflict');
  assert.deepEqual(server.log, ['set_box'], 'only the edit of the other track went through');
  assert.equal(review().unsaved.length, 2, 'both are still there');
  assert.equal((await outbox.load(RUN)).length, 2);
  assert.equal(dialog?.data.saved[0].review, 'accepted');
  assert.deepEqual(Object.keys(dialog?.data.mine[0].keys), ['5', '6']);

  dialog?.data.keepMine();
  await editor.settled();
  assert.deepEqual(Object.keys(server.docs.m1.keys), ['5', '6']);
  assert.equal(server.docs.m1.review, 'accepted');
  assert.equal(review().unsaved.length, 0);
});

test('the saved version can be taken instead', async () => {
  const { editor, server, review, store, outbox } = await createEditorFixture();
  server.editAsOther({ name: 'set_review', key: 'm1', frame: 0, review: 'accepted' });
  editor.edit(setBox('m1', 5, 20));
  await editor.settled();
  const { dialog } = store.get();
  if (dialog?.kind !== 'conflict') assert.fail('nobody is asked');
  dialog.data.takeTheirs();
  assert.deepEqual([review().docs.m1.keys, review().docs.m1.review, review().unsaved], [{}, 'accepted', []]);
  assert.deepEqual(await outbox.load(RUN), []);
});

test('a conflict leaves another open dialog alone, and its banner leads to the decision', async () => {
  const { editor, server, store } = await createEditorFixture();
  const label = /** @type {any} */ ({ kind: 'label', data: {} });
  store.dispatch(openDialog, label);
  server.editAsOther({ name: 'set_review', key: 'm1', frame: 0, review: 'accepted' });
  editor.edit(setBox('m1', 5, 20));
  await editor.settled();
  assert.equal(store.get().dialog, label);
  assert.deepEqual(
    store.get().banners.map(({ action }) => action?.operation),
    ['decide-conflict'],
  );
  store.dispatch(closeDialog);
  editor.decide();
  assert.equal(store.get().dialog?.kind, 'conflict');
});

test('undo of a command on a whole track names the track, not a frame', async () => {
  const { editor, toasts } = await createEditorFixture();
  editor.edit({ name: 'set_review', key: 'm2', frame: 60, review: 'accepted' });
  await editor.undo();
  assert.deepEqual(toasts, ['Undone: verdict, track #2']);
});

test('undo goes to its frame, selects its track and says what it was; fast keys undo one after the other', async () => {
  const { editor, server, review, toasts } = await createEditorFixture();
  editor.edit(setBox('m1', 5, 20));
  editor.edit(setBox('m2', 60, 20));
  await Promise.all([editor.undo(), editor.undo(), editor.undo()]);
  assert.deepEqual(server.log, ['set_box', 'set_box', 'undo', 'undo']);
  assert.deepEqual([review().frame, review().selected], [5, 'm1']);
  assert.deepEqual(toasts, ['Undone: box corrected in frame 60', 'Undone: box corrected in frame 5', 'There is nothing to undo.']);
  assert.deepEqual(review().docs.m1.keys, {});
});

test('between two reviews a correction and an undo say that nothing was changed', async () => {
  const { editor, server, toasts } = await createEditorFixture();
  editor.close();
  assert.equal(editor.edit({ name: 'set_review', key: 'm2', frame: 60, review: 'accepted' }), false);
  await editor.undo();
  assert.deepEqual(toasts, [
    'Verdict was not possible: the review is still being opened. Try again in a moment.',
    'Undo was not possible: the review is still being opened. Try again in a moment.',
  ]);
  assert.deepEqual(server.log, []);
});

test("going to another run while a request is under way sends the new run's edits", async () => {
  const { editor, server } = await createEditorFixture(createServer());
  editor.edit(setBox('m1', 5, 20));
  editor.close();
  await editor.open('s'.repeat(32));
  editor.edit(setBox('m2', 60, 20));
  await editor.settled();
  assert.ok(server.docs.m2);
});

test('a selected track that somebody else takes away is no longer selected', async () => {
  const { editor, server, review, store, toasts } = await createEditorFixture();
  store.dispatch(select, 'm1');
  editor.receive(server.editAsOther({ name: 'delete_track', key: 'm2', frame: 60 }), 'x1');
  assert.equal(review().selected, 'm1');
  editor.receive(server.editAsOther({ name: 'delete_track', key: 'm1', frame: 5 }), 'x2');
  assert.equal(review().selected, null);
  assert.deepEqual(toasts, ['Track #1 was deleted in another page.']);
});

test('after a merge by another person, the resulting track is selected', async () => {
  const { editor, server, review, store, toasts } = await createEditorFixture();
  store.dispatch(select, 'm2');
  editor.receive(server.editAsOther({ name: 'merge', key: 'm1', others: ['m2'], frame: 60 }), 'x1');
  assert.equal(review().selected, 'm1');
  assert.match(toasts[0], /#2 was merged into #1/);
});
