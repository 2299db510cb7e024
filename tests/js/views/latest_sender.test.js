// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { ApiError } from '../../../static/js/api/errors.js';
import { createLatestSender } from '../../../static/js/views/latest_sender.js';
import { deferred } from '../deferred.js';

/** A sender that notes what it sends, and what was sent. @param {Parameters<typeof createLatestSender>[1]} [options] @param {(value: number) => unknown} [send]   sends a value, or throws */
function createFixture(options = { wait: () => Promise.resolve() }, send = () => {}) {
  /** @type {number[]} */
  const sent = [];
  const sender = createLatestSender(async (/** @type {number} */ value) => {
    sent.push(value);
    await send(value);
  }, options);
  return { sender, sent };
}

const nextTurn = () => new Promise((resolve) => setImmediate(resolve));

test('while one value is being sent, only the newest waiting value is kept', async () => {
  const first = deferred();
  const { sender, sent } = createFixture(undefined, (value) => (value === 1 ? first.promise : undefined));
  for (const value of [1, 2, 3, 4]) sender.push(value);
  await nextTurn();
  assert.deepEqual(sent, [1]);
  first.resolve();
  await nextTurn();
  assert.deepEqual(sent, [1, 4]);
});

test('there is a pause between two values', async () => {
  const pause = deferred();
  const { sender, sent } = createFixture({ wait: () => pause.promise });
  sender.push(1);
  await nextTurn();
  sender.push(2);
  await nextTurn();
  assert.deepEqual(sent, [1]);
  pause.resolve();
  await nextTurn();
  assert.deepEqual(sent, [1, 2]);
});

test('a failure is reported, and the next value is sent', async () => {
  /** @type {unknown[]} */
  const errors = [];
  const { sender, sent } = createFixture({ wait: () => Promise.resolve(), onError: (thrown) => errors.push(thrown) }, (value) => {
    if (value === 1) throw new Error('gone');
  });
  sender.push(1);
  await nextTurn();
  sender.push(2);
  await nextTurn();
  assert.deepEqual(sent, [1, 2]);
  assert.equal(errors.length, 1);
});

test('the newest value is sent again after a temporary failure', async () => {
  /** @type {number[]} */
  const pauses = [];
  let pause = deferred();
  const wait = (/** @type {number} */ ms) => {
    pauses.push(ms);
    pause = deferred();
    return pause.promise;
  };
  const { sender, sent } = createFixture({ wait }, () => {
    if (sent.length < 3) throw new ApiError(0, 'offline', 'The server cannot be reached.');
  });
  sender.push(1);
  await nextTurn();
  pause.resolve();
  await nextTurn();
  assert.deepEqual(sent, [1, 1]);
  sender.push(2);
  pause.resolve();
  await nextTurn();
  assert.deepEqual(sent, [1, 1, 2]);
  pause.resolve();
  await nextTurn();
  assert.deepEqual([sent.length, pauses], [3, [2000, 2000, 80]], 'what has arrived is not sent again');
});

test('a stopped sender sends nothing', async () => {
  const { sender, sent } = createFixture();
  sender.stop();
  sender.push(1);
  await nextTurn();
  assert.deepEqual(sent, []);
});
