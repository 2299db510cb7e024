// @ts-check
/** Edits that meet a change of somebody else: what is asked, what "Keep mine" makes of it. */
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { withTrackNames } from '../../../static/js/editing/command_names.js';
import { select } from '../../../static/js/store/actions/review.js';
import { describeConflict } from '../../../static/js/views/dialogs/conflict.js';
import { createEditorFixture, setBox } from './editor_fixture.js';
import { pluck } from '../pluck.js';

/** @typedef {import('../../../static/js/types.js').Command} Command */

/** @param {string} key @param {number} frame @param {string} text @returns {any} */
const note = (key, frame, text) => ({ name: 'add_note', key, frame, note_id: text.padEnd(32, 'x'), text });

/**
 * One page edits what another has changed without this one hearing of it.
 * @param {Command[]} theirs
 * @param {Command[]} mine
 */
async function editBoth(theirs, mine) {
  const fixture = await createEditorFixture();
  for (const command of theirs) fixture.server.editAsOther(command);
  for (const command of mine) fixture.editor.edit(command);
  await fixture.editor.settled();
  const { dialog } = fixture.store.get();
  return {
    ...fixture,
    plan: /** @type {import('../../../static/js/dialog-types.js').DialogData['conflict']} */ (
      dialog?.kind === 'conflict' ? dialog.data : null
    ),
  };
}

test('a deleted track is restored with the edit, and both versions show it', async () => {
  const { plan, editor, server, review, toasts } = await editBoth(
    [{ name: 'delete_track', key: 'm1', frame: 0 }],
    [setBox('m1', 5, 20), setBox('m1', 9, 30)],
  );
  assert.deepEqual(
    [plan.saved.map((/** @type {any} */ doc) => doc.gone), plan.mine.map((/** @type {any} */ doc) => doc.gone)],
    [[true], [false]],
  );
  assert.deepEqual(Object.keys(plan.mine[0].keys), ['5', '9']);
  assert.deepEqual(
    describeConflict(
      plan,
      { m1: { author: 'Ann', time: '', name: 'delete_track', frame: 0 } },
      (key) => `#${key.slice(1)}`,
      () => 'Monday',
    ),
    ['Ann changed track #1 on Monday: track deleted.', 'Track #1 was deleted: “Keep mine” restores it.'],
  );
  plan.keepMine();
  await editor.settled();
  assert.deepEqual([server.docs.m1.gone, Object.keys(server.docs.m1.keys)], [false, ['5', '9']]);
  assert.deepEqual([review().unsaved, toasts, server.log], [[], [], ['restore_track', 'set_box', 'set_box']]);
});

test('edits of a merged track go to the track that it is part of', async () => {
  const { plan, editor, server, review, toasts } = await editBoth(
    [{ name: 'merge', key: 'm1', frame: 0, others: ['m2'] }],
    [setBox('m2', 120, 20)],
  );
  assert.deepEqual([plan.moved, plan.mine.map((/** @type {any} */ doc) => doc.key)], [[{ key: 'm2', into: 'm1' }], ['m1']]);
  assert.match(describeConflict(plan, {}, (key) => `#${key.slice(1)}`)[0], /#2 was merged into #1/);
  plan.keepMine();
  await editor.settled();
  assert.deepEqual([Object.keys(server.docs.m1.keys), server.docs.m2.merged_into, toasts], [['120'], 'm1', []]);
  assert.deepEqual([review().selected, review().frame], ['m1', 120], 'what became of it is to be seen');
});

test('the saved version of a deleted track can be kept too', async () => {
  const { plan, editor, server, review, store } = await editBoth([{ name: 'delete_track', key: 'm1', frame: 0 }], [setBox('m1', 5, 20)]);
  store.dispatch(select, 'm1');
  plan.takeTheirs();
  await editor.settled();
  assert.deepEqual([server.docs.m1.gone, review().docs.m1.gone, review().unsaved, review().selected], [true, true, [], null]);
});

for (const [name, command] of /** @type {[string, Command][]} */ ([
  ['deleting', { name: 'delete_track', key: 'm1', frame: 3 }],
  ['accepting', { name: 'set_review', key: 'm1', frame: 3, review: 'accepted' }],
])) {
  test(`two who do the same are not asked: ${name}`, async () => {
    const { plan, review, toasts } = await editBoth([command], [{ ...command, frame: 40 }]);
    assert.deepEqual([plan, review().unsaved, toasts], [null, [], []]);
  });
}

test('merging two tracks that somebody else has merged asks nothing', async () => {
  const { plan, review } = await editBoth(
    [{ name: 'merge', key: 'm1', frame: 0, others: ['m2'] }],
    [{ name: 'merge', key: 'm2', frame: 0, others: ['m1'] }],
  );
  assert.deepEqual([plan, review().unsaved], [null, []]);
});

test('what makes no sense any more is reported with its reason and is not made', async () => {
  const { plan } = await editBoth(
    [{ name: 'delete_from', key: 'm1', frame: 30 }],
    [{ name: 'split', key: 'm1', frame: 50, new_key: 'h00000001' }],
  );
  assert.deepEqual([plan.commands, plan.mine, plan.lost.length], [[], [], 1]);
  assert.match(
    withTrackNames(describeConflict(plan, {}, (key) => key)[0], {}),
    /cannot be kept\. Track #1 has nothing on one side of frame 50/,
  );
});

test('a note is repeated on top of other changes without a question', async () => {
  const { plan, server, review, toasts } = await editBoth([note('m1', 3, 'theirs')], [note('m1', 5, 'mine')]);
  assert.deepEqual([plan, toasts, review().unsaved], [null, [], []]);
  assert.deepEqual(pluck(server.docs.m1.notes, 'text'), ['theirs', 'mine']);
});

test('a note is not rebased if other edits of the track wait, or if the track is deleted', async () => {
  const waiting = await editBoth([setBox('m1', 3, 9)], [note('m1', 5, 'mine'), setBox('m1', 3, 50)]);
  assert.equal(waiting.plan.mine[0].notes.length, 1);
  assert.equal(waiting.server.docs.m1.keys[3].box?.[0], 9);
  const gone = await editBoth([{ name: 'delete_track', key: 'm1', frame: 0 }], [note('m1', 5, 'mine')]);
  assert.equal(gone.plan.mine[0].gone, false);
});

test('what cannot be done to a deleted track does not restore it either', async () => {
  const { plan } = await editBoth([{ name: 'delete_track', key: 'm1', frame: 0 }], [{ name: 'remove_key', key: 'm1', frame: 5 }]);
  assert.equal(plan, null, 'the page itself refuses to remove what is not there');
  const later = await editBoth(
    [
      { name: 'delete_from', key: 'm1', frame: 30 },
      { name: 'delete_track', key: 'm1', frame: 0 },
    ],
    [{ name: 'split', key: 'm1', frame: 50, new_key: 'h00000001' }],
  );
  assert.deepEqual([later.plan.commands, later.plan.mine, later.plan.lost.length], [[], [], 1]);
});

/** @param {...string} others @returns {Command} */
const accepted = (...others) => ({ name: 'review_tracks', key: 'm1', frame: 3, others, review: 'accepted' });

test('one verdict on many leaves out what somebody else has changed, and asks nobody', async () => {
  const { plan, server, review, toasts } = await editBoth([setBox('m1', 3, 9)], [accepted('m2')]);
  assert.deepEqual([plan, review().unsaved, server.docs.m1.review, server.docs.m2.review], [null, [], 'open', 'accepted']);
  assert.deepEqual(toasts, ['No verdict on track #1: changed by somebody else first.']);
  const none = await editBoth([{ name: 'delete_track', key: 'm1', frame: 0 }], [accepted()]);
  assert.deepEqual([none.plan, none.review().unsaved, none.server.docs.m1.review, none.server.docs.m1.gone], [null, [], 'open', true]);
  assert.deepEqual(none.toasts, toasts, 'also where nothing is left of it');
});

test('a verdict on many that waits behind a question brings back no deleted track', async () => {
  const { plan, editor, server } = await editBoth(
    [{ name: 'delete_track', key: 'm1', frame: 0 }],
    [{ name: 'set_not_a_sign', key: 'm2', frame: 60, value: true }, accepted('m2')],
  );
  assert.equal(plan, null);
  await editor.settled();
  assert.deepEqual([server.docs.m1.gone, server.docs.m2.review, server.docs.m2.not_a_sign], [true, 'accepted', true]);
  const asked = await editBoth([{ name: 'delete_track', key: 'm1', frame: 0 }], [setBox('m1', 5, 20), accepted('m2')]);
  assert.deepEqual(
    asked.plan.commands.map((/** @type {Command} */ { name }) => name),
    ['restore_track', 'set_box', 'review_tracks'],
  );
  const behind = await editBoth(
    [setBox('m2', 60, 1), { name: 'delete_track', key: 'm1', frame: 0 }],
    [setBox('m2', 60, 20), accepted('m2')],
  );
  assert.deepEqual(behind.plan.commands, [
    { name: 'set_box', key: 'm2', frame: 60, box: [20, 20, 30, 30] },
    { ...accepted(), key: 'm2' },
  ]);
  assert.deepEqual(behind.plan.moved, []);
});
