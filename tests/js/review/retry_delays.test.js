// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { createRetryDelays } from '../../../static/js/review/retry_delays.js';

test('a delay doubles with each failure up to half a minute, and is reset by an answer', (context) => {
  context.mock.timers.enable({ apis: ['setTimeout'] });
  const delays = createRetryDelays();
  assert.equal(delays.isWaiting('a'), false);
  /** @type {boolean[]} */
  const waitingAtRetry = [];
  const retry = () => waitingAtRetry.push(delays.isWaiting('a'));
  for (const [i, delay] of [500, 1000, 2000, 4000, 8000, 16000, 30000, 30000].entries()) {
    delays.failed('a', retry);
    assert.ok(!delays.isWaiting('b'));
    context.mock.timers.tick(delay - 1);
    assert.ok(delays.isWaiting('a'));
    assert.equal(waitingAtRetry.length, i);
    context.mock.timers.tick(1);
    assert.equal(waitingAtRetry.length, i + 1);
  }
  assert.ok(!waitingAtRetry.includes(true), 'the wait is over when the request is made again');
  delays.succeeded('a');
  delays.failed('a', retry);
  context.mock.timers.tick(500);
  assert.equal(waitingAtRetry.length, 9);
});

test('the end of an earlier delay does not end a later one', (context) => {
  context.mock.timers.enable({ apis: ['setTimeout'] });
  const delays = createRetryDelays();
  delays.failed('a', () => {});
  context.mock.timers.tick(400);
  delays.failed('a', () => {});
  context.mock.timers.tick(100);
  assert.ok(delays.isWaiting('a'));
});

test('a missing thing is not requested until everything is requested again', (context) => {
  context.mock.timers.enable({ apis: ['setTimeout'] });
  const delays = createRetryDelays();
  delays.missing('a');
  context.mock.timers.tick(1e9);
  assert.ok(delays.isWaiting('a'));
  delays.clear();
  assert.ok(!delays.isWaiting('a'));
});
