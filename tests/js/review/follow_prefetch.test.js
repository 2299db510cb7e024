// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { createFollowPrefetch } from '../../../static/js/review/follow_prefetch.js';
import { changeReview, openReview } from '../../../static/js/store/actions/review.js';
import { initialState } from '../../../static/js/store/initial.js';
import { createStore } from '../../../static/js/store/store.js';

test('the server is told the frame of a box when the cursor stays there', (context) => {
  context.mock.timers.enable({ apis: ['setTimeout'] });
  const store = createStore(initialState(), (run) => run());
  /** @type {[string, number][]} */ const announced = [];
  const ended = new AbortController();
  const api = { expectFollow: async (/** @type {string} */ run, /** @type {number} */ frame) => void announced.push([run, frame]) };
  const prefetch = createFollowPrefetch({ store, api: /** @type {any} */ (api), signal: ended.signal });
  store.subscribe(prefetch.sync);
  /** @param {any} change */
  const change = (change) => store.dispatch(changeReview, change);
  store.dispatch(openReview, /** @type {any} */ ({ id: 'v', frames: 100, width: 640, height: 360 }));
  change({ run: { id: 'r' }, frame: 5, shown: 5 });
  context.mock.timers.tick(1000);
  assert.deepEqual(announced, []); // nothing is selected, and nothing is drawn
  change({ mode: 'draw' });
  context.mock.timers.tick(100);
  change({ frame: 6, shown: 6 });
  context.mock.timers.tick(100);
  assert.deepEqual(announced, []);
  context.mock.timers.tick(100);
  change({ hovered: 'm1' });
  context.mock.timers.tick(1000);
  assert.deepEqual(announced, [['r', 6]]);
  change({ frame: 7 }); // whose picture has not come yet
  context.mock.timers.tick(1000);
  change({ shown: 7, playing: true });
  context.mock.timers.tick(1000);
  change({ playing: false, following: /** @type {any} */ ({}) });
  context.mock.timers.tick(1000);
  assert.deepEqual(announced, [['r', 6]]);
  change({ following: null }); // dropped: from here it may be followed once more
  context.mock.timers.tick(1000);
  assert.deepEqual(announced, [
    ['r', 6],
    ['r', 7],
  ]);
  change({ frame: 8, shown: 8 });
  ended.abort();
  context.mock.timers.tick(1000);
  assert.equal(announced.length, 2);
});
