// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { createRests } from '../../../static/js/review/rests.js';

test('a rest doubles with each failure up to half a minute, and begins anew after an answer', () => {
  let time = 1e6;
  const rests = createRests(() => time);
  assert.equal(rests.has('a'), false);
  const pauses = [];
  for (let i = 0; i < 8; i += 1) {
    pauses.push(rests.failed('a'));
    assert.ok(rests.has('a'));
    assert.ok(!rests.has('b'));
    time += pauses[i];
    assert.ok(!rests.has('a'));
  }
  assert.deepEqual(pauses, [500, 1000, 2000, 4000, 8000, 16000, 30000, 30000]);
  rests.done('a');
  assert.equal(rests.failed('a'), 500);
});

test('a missing thing is not requested until everything is requested again', () => {
  let time = 0;
  const rests = createRests(() => time);
  rests.absent('a');
  time = 1e12;
  assert.ok(rests.has('a'));
  rests.clear();
  assert.ok(!rests.has('a'));
});
