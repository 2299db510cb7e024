// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { judge } from '../../../static/js/operations/verdicts.js';
import { changeReview } from '../../../static/js/store/actions/review.js';
import { createWorld } from '../editing/world.js';
import { drive } from '../harness/synthetic.js';

test('a verdict goes on to the next track that is left; given twice it stays and nothing is stored', async () => {
  const { store, editor, server, review, end } = await createWorld();
  const app = { store, edit: editor.edit };
  /** @type {string[]} */ const said = [];
  const say = (/** @type {string} */ text) => void said.push(text);
  const ids = [1, 2];
  const tracks = { ...drive(200, 2).tracks, id: ids, first: [0, 50], last: [99, 150], clearest: [90, 140], rank: [0.9, 0.5] };
  store.dispatch((state) => changeReview(state, { tracks }));
  store.dispatch((state) => changeReview(state, { selected: `m${ids[0]}` }));
  judge(app, 'accepted', say);
  await editor.settled();
  assert.equal(review().docs[`m${ids[0]}`].review, 'accepted');
  assert.deepEqual([review().selected, review().frame], ['m2', 140], 'where it is clearest');
  store.dispatch((state) => changeReview(state, { selected: `m${ids[0]}` }));
  judge(app, 'accepted', say);
  await editor.settled();
  assert.equal(review().docs[`m${ids[0]}`].review, 'accepted', 'not taken back');
  assert.deepEqual(server.log, ['set_review']);
  for (const id of ids.slice(1)) {
    store.dispatch((state) => changeReview(state, { selected: `m${id}` }));
    judge(app, 'rejected', say);
  }
  await editor.settled();
  assert.equal(said.at(-1), 'Nothing in the queue is left to be decided.');
  assert.equal(review().selected, `m${ids.at(-1)}`, 'it does not go on to what has been judged');
  assert.equal(server.log.length, ids.length);
  end();
});
