// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { groupRuns, listRuns } from '../../../static/js/model/run_groups.js';

/** @param {string} id @param {string|null} [parent] */
const run = (id, parent = null) => /** @type {any} */ ({ id, parent_id: parent, kind: parent === null ? 'engine' : 'whatif' });

test('each what-if stands under the run that it replays, in the order of the list', () => {
  const runs = [run('w3', 'a'), run('b'), run('w2', 'b'), run('w1', 'a'), run('a')];
  assert.deepEqual(
    groupRuns(runs).map((group) => [group.run.id, group.whatifs.map(({ id }) => id)]),
    [
      ['b', ['w2']],
      ['a', ['w3', 'w1']],
    ],
  );
  assert.deepEqual(
    listRuns(runs).map((one) => [one.run.id, one.isWhatIf, one.whatifs]),
    [
      ['b', false, 1],
      ['w2', true, 0],
      ['a', false, 2],
      ['w3', true, 0],
      ['w1', true, 0],
    ],
  );
});

test('a what-if whose run is not in the list is not lost', () => {
  assert.deepEqual(
    listRuns([run('w', 'gone'), run('a')]).map((one) => [one.run.id, one.isWhatIf]),
    [
      ['w', false],
      ['a', false],
    ],
  );
});
