// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { createFollower } from '../../../static/js/views/follower.js';
import { deferred } from '../deferred.js';

const turn = () => new Promise((resolve) => setImmediate(resolve));

test('while one value is on its way only the newest of those behind it is kept', async () => {
  /** @type {number[]} */
  const sent = [];
  const first = deferred();
  const follower = createFollower(
    (/** @type {number} */ value) => {
      sent.push(value);
      return value === 1 ? first.promise : Promise.resolve();
    },
    { wait: () => Promise.resolve() },
  );
  for (const value of [1, 2, 3, 4]) follower.push(value);
  await turn();
  assert.deepEqual(sent, [1]);
  first.resolve();
  await turn();
  assert.deepEqual(sent, [1, 4]);
});

test('there is a pause between two values', async () => {
  /** @type {number[]} */
  const sent = [];
  const pause = deferred();
  const follower = createFollower(
    async (/** @type {number} */ value) => {
      sent.push(value);
    },
    { wait: () => pause.promise },
  );
  follower.push(1);
  await turn();
  follower.push(2);
  await turn();
  assert.deepEqual(sent, [1]);
  pause.resolve();
  await turn();
  assert.deepEqual(sent, [1, 2]);
});

test('a failure is reported and does not end the following', async () => {
  /** @type {unknown[]} */
  const reported = [];
  /** @type {number[]} */
  const sent = [];
  const follower = createFollower(
    async (/** @type {number} */ value) => {
      sent.push(value);
      if (value === 1) throw new Error('gone');
    },
    { wait: () => Promise.resolve(), failed: (thrown) => reported.push(thrown) },
  );
  follower.push(1);
  await turn();
  follower.push(2);
  await turn();
  assert.deepEqual(sent, [1, 2]);
  assert.equal(reported.length, 1);
});

test('a stopped one sends nothing any more', async () => {
  /** @type {number[]} */
  const sent = [];
  const follower = createFollower(
    async (/** @type {number} */ value) => {
      sent.push(value);
    },
    { wait: () => Promise.resolve() },
  );
  follower.stop();
  follower.push(1);
  await turn();
  assert.deepEqual(sent, []);
});
