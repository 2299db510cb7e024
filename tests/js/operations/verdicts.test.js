// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { setVerdict, setPinnedLabel, judge } from '../../../static/js/operations/verdicts.js';
import { changeReview } from '../../../static/js/store/actions/review.js';
import { createEditorFixture } from '../editing/editor_fixture.js';
import { syntheticRun } from '../harness/synthetic_run.js';
import { setLabels } from '../../../static/js/store/actions/page.js';
import { label } from '../labels.js';

test('a verdict goes on to the next track that is left; given twice it stays and nothing is stored', async () => {
  const { store, editor, server, review, end } = await createEditorFixture();
  const app = { store, edit: editor.edit };
  /** @type {string[]} */ const said = [];
  const say = (/** @type {string} */ text) => void said.push(text);
  const ids = [1, 2];
  const tracks = { ...syntheticRun(200, 2).tracks, id: ids, first: [0, 50], last: [99, 150], clearest: [90, 140], rank: [0.9, 0.5] };
  store.dispatch(changeReview, { tracks });
  store.dispatch(changeReview, { selected: `m${ids[0]}` });
  judge(app, 'accepted', say);
  await editor.settled();
  assert.equal(review().docs[`m${ids[0]}`].review, 'accepted');
  assert.deepEqual([review().selected, review().frame], ['m2', 140], 'where it is clearest');
  store.dispatch(changeReview, { selected: `m${ids[0]}` });
  judge(app, 'accepted', say);
  await editor.settled();
  assert.equal(review().docs[`m${ids[0]}`].review, 'accepted', 'not taken back');
  assert.deepEqual(server.log, ['set_review']);
  for (const id of ids.slice(1)) {
    store.dispatch(changeReview, { selected: `m${id}` });
    judge(app, 'rejected', say);
  }
  await editor.settled();
  assert.equal(said.at(-1), 'All tracks of this video are reviewed. No other video has an open track.');
  assert.equal(review().selected, `m${ids.at(-1)}`, 'it does not go on to what has been judged');
  assert.equal(server.log.length, ids.length);
  end();
});

test('a digit gives the label that is pinned to it, once; no hidden one, and none that is not pinned', async () => {
  const { store, editor, server, review, end } = await createEditorFixture();
  /** @type {string[]} */ const said = [];
  const app = { store, edit: editor.edit };
  const give = (/** @type {string} */ digit) => setPinnedLabel(app, digit, (text) => void said.push(text));
  store.dispatch((state) =>
    setLabels(changeReview(state, { selected: 'm1' }), [
      label({ id: 7, name: 'stop', pinned: 3 }),
      label({ id: 8, name: 'old', pinned: 4, hidden: true }),
    ]),
  );
  for (const digit of ['3', '3', '4', '5']) give(digit);
  await editor.settled();
  assert.equal(review().docs.m1.class_id, 7);
  assert.deepEqual(server.log, ['relabel_track']);
  assert.deepEqual(said, [
    'Track #1: stop',
    'Track #1 is stop already.',
    'No label is pinned to 4. Pin one on the Labels page.',
    'No label is pinned to 5. Pin one on the Labels page.',
  ]);
  end();
});

test('another verdict takes back what an older version marked as no sign', async () => {
  const { store, editor, server, review, end } = await createEditorFixture();
  const app = { store, edit: editor.edit };
  editor.edit({ name: 'set_not_a_sign', key: 'm1', frame: 0, value: true });
  setVerdict(app, review(), 'm1', 'rejected');
  setVerdict(app, review(), 'm1', 'accepted');
  await editor.settled();
  assert.deepEqual([review().docs.m1.not_a_sign, review().docs.m1.review], [false, 'accepted']);
  assert.deepEqual(server.log, ['set_not_a_sign', 'set_review', 'set_not_a_sign', 'set_review']);
  end();
});
