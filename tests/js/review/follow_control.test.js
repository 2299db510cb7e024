// @ts-check
import assert from 'node:assert/strict';
import { getEventListeners } from 'node:events';
import { test } from 'node:test';

import { ApiError } from '../../../static/js/api/errors.js';
import { blankDoc } from '../../../static/js/model/documents.js';
import { sleep } from '../../../static/js/api/sleep.js';
import { createFollowControl } from '../../../static/js/review/follow_control.js';
import { changeReview, openReview } from '../../../static/js/store/actions/review.js';
import { initialState } from '../../../static/js/store/initial.js';
import { createStore } from '../../../static/js/store/store.js';

/** @typedef {import('../../../static/js/types.js').Box} Box */
const BOX = /** @type {Box} */ ([10, 10, 30, 30]);
const WANTED = { key: 'm1', anchors: [{ frame: 5, box: BOX }], only: null, first: 0, last: null };
const BLANK = { run_id: 'r', key: 'm1', anchors: WANTED.anchors, only: null, first: 0, last: null, error: null, endings: [] };

/** Short waits end at once, long ones with the request. @param {number} ms @param {AbortSignal} signal @returns {Promise<void>} */
const shortSleep = (ms, signal) =>
  ms > 1000 ? new Promise((resolve) => signal.addEventListener('abort', () => resolve())) : Promise.resolve();

/** A control with an open run and a scripted server. @param {object} [api] @param {boolean} [acceptsEdits] @param {typeof shortSleep} [sleep] */
function createFixture(api = {}, acceptsEdits = true, sleep = shortSleep) {
  const store = createStore(initialState());
  store.dispatch(openReview, /** @type {any} */ ({ id: 'v', frames: 100, width: 640, height: 360 }));
  store.dispatch(changeReview, { run: /** @type {any} */ ({ id: 'r' }) });
  /** @type {any[]} */ const log = [];
  /** @type {any[]} */ const commands = [];
  /** @type {string[]} */ const messages = [];
  let followCount = 0;
  const server = {
    startFollow: async (/** @type {string} */ _run, /** @type {any} */ wanted) => {
      log.push(['start', wanted.anchors.map((/** @type {any} */ one) => one.frame)]);
      return { ...BLANK, id: `f${++followCount}`, anchors: wanted.anchors, state: 'queued', proposals: [], next: 0 };
    },
    follow: async (/** @type {string} */ id, /** @type {number} */ after) => {
      log.push(['ask', id, after]);
      return after > 0
        ? { ...BLANK, id, state: 'complete', proposals: [], next: after }
        : { ...BLANK, id, state: 'running', proposals: [[6, 11, 10, 31, 30, 0.9, 'matched']], next: 1 };
    },
    findFollow: async () => null,
    dropFollow: async (/** @type {string} */ id) => void log.push(['drop', id]),
    ...api,
  };
  const ended = new AbortController();
  const control = createFollowControl({
    store,
    api: /** @type {any} */ (server),
    signal: ended.signal,
    author: () => 'ann',
    toast: (text) => messages.push(text),
    edit: (command) => acceptsEdits && commands.push(command) > 0,
    sleep,
  });
  const now = () => store.get().review?.following ?? null;
  return { control, store, log, commands, messages, now, end: () => ended.abort() };
}
const settle = async () => {
  for (let i = 0; i < 60; i += 1) await Promise.resolve();
};

test('the proposals of a track that is deleted, or whose drawing is undone, are dropped', async () => {
  const { control, store, log, now } = createFixture();
  control.start(WANTED);
  await settle();
  store.dispatch(changeReview, { docs: { m2: { ...blankDoc('m2'), gone: true } } });
  await settle();
  assert.notEqual(now(), null);
  store.dispatch(changeReview, { docs: { m1: { ...blankDoc('m1'), gone: true } } });
  await settle();
  assert.equal(now(), null);
  assert.deepEqual(log.at(-1), ['drop', 'f1']);
});

test('proposals arrive and are accepted by one operation', async () => {
  const { control, log, commands, now, end } = createFixture();
  control.start(WANTED);
  assert.equal(now()?.state, 'queued');
  await settle();
  assert.equal(now()?.state, 'complete');
  assert.deepEqual(now()?.proposals[6], { box: [11, 10, 31, 30], confidence: 0.9, source: 'matched' });
  assert.ok(control.accept());
  assert.deepEqual(
    commands.map(({ name, boxes }) => [name, boxes.map((/** @type {any} */ one) => [one.frame, one.anchor])]),
    [
      [
        'follow',
        [
          [5, true],
          [6, false],
        ],
      ],
    ],
  );
  assert.equal(now(), null);
  await settle();
  assert.deepEqual(log.at(-1), ['drop', 'f1']);
  end();
});

test('proposals stay if the page refuses the edit', async () => {
  const { control, now, end } = createFixture({}, false);
  control.start(WANTED);
  await settle();
  assert.equal(control.accept(), false);
  assert.ok(now());
  end();
});

test('Escape drops, here and on the server; leaving the run too', async () => {
  const { control, log, now, end } = createFixture();
  control.start(WANTED);
  await settle();
  control.drop();
  await settle();
  assert.deepEqual([now(), log.at(-1)], [null, ['drop', 'f1']]);
  control.start(WANTED);
  await settle();
  control.close();
  await settle();
  assert.deepEqual(log.at(-1), ['drop', 'f2']);
  end();
});

test('a correction is another anchor, and cut-off frames stay cut off', async () => {
  const { control, store, log, now, end } = createFixture();
  control.start(WANTED);
  await settle();
  store.dispatch(changeReview, ({ following }) => ({ following: following && { ...following, to: 20 } }));
  control.correct({ frame: 9, box: BOX });
  await settle();
  assert.deepEqual(
    log.filter(([what]) => what === 'start'),
    [
      ['start', [5]],
      ['start', [5, 9]],
    ],
  );
  assert.deepEqual([now()?.id, now()?.to, now()?.anchors.length], ['f2', 20, 2]);
  end();
});

test('a failed follow is reported and removed from the page', async () => {
  const startFollow = () => Promise.reject(new ApiError(422, 'no_such_frame', 'The video has frames 0 to 9. Got 50.'));
  const { control, messages: said, now, end } = createFixture({ startFollow });
  control.start(WANTED);
  await settle();
  assert.deepEqual([now(), said], [null, ['The video has frames 0 to 9. Got 50.']]);
  end();
});

test('waiting proposals are shown again after a reload', async () => {
  const { control, now, end } = createFixture({
    findFollow: async () => ({ ...BLANK, id: 'f9', state: 'complete', proposals: [[6, 11, 10, 31, 30, 0.9, 'matched']], next: 3 }),
  });
  control.open('r');
  await settle();
  assert.deepEqual([now()?.id, now()?.proposals[6]?.confidence], ['f9', 0.9]);
  end();
});

test('proposals that wait for days leave nothing behind with each request', async (context) => {
  context.mock.timers.enable({ apis: ['setTimeout'] });
  const waiting = { ...BLANK, id: 'f1', state: 'complete', proposals: [], next: 1 };
  /** @type {number[]} */
  const listeners = [];
  const follow = async (/** @type {[string, number, number, {signal: AbortSignal}]} */ ...[, , , { signal }]) => {
    listeners.push(getEventListeners(signal, 'abort').length);
    return waiting;
  };
  const { control, end } = createFixture({ findFollow: async () => waiting, follow }, true, sleep);
  control.open('r');
  for (let i = 0; i < 50; i += 1) {
    await settle();
    context.mock.timers.tick(5000);
  }
  await settle();
  assert.equal(listeners.length, 50);
  assert.equal(listeners.at(-1), listeners[0]);
  end();
});
