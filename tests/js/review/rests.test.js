// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { createRests } from '../../../static/js/review/rests.js';

test('a rest doubles with each failure up to half a minute, and begins anew after an answer', (context) => {
  context.mock.timers.enable({ apis: ['setTimeout'] });
  const rests = createRests();
  assert.equal(rests.has('a'), false);
  /** @type {boolean[]} */
  const resting = [];
  const again = () => resting.push(rests.has('a'));
  for (const [i, pause] of [500, 1000, 2000, 4000, 8000, 16000, 30000, 30000].entries()) {
    rests.failed('a', again);
    assert.ok(!rests.has('b'));
    context.mock.timers.tick(pause - 1);
    assert.ok(rests.has('a'));
    assert.equal(resting.length, i);
    context.mock.timers.tick(1);
    assert.equal(resting.length, i + 1);
  }
  assert.ok(!resting.includes(true), 'the wait is over when the request is made again');
  rests.done('a');
  rests.failed('a', again);
  context.mock.timers.tick(500);
  assert.equal(resting.length, 9);
});

test('the end of an earlier wait leaves a later one', (context) => {
  context.mock.timers.enable({ apis: ['setTimeout'] });
  const rests = createRests();
  rests.failed('a', () => {});
  context.mock.timers.tick(400);
  rests.failed('a', () => {});
  context.mock.timers.tick(100);
  assert.ok(rests.has('a'));
});

test('a missing thing is not requested until everything is requested again', (context) => {
  context.mock.timers.enable({ apis: ['setTimeout'] });
  const rests = createRests();
  rests.absent('a');
  context.mock.timers.tick(1e9);
  assert.ok(rests.has('a'));
  rests.clear();
  assert.ok(!rests.has('a'));
});
