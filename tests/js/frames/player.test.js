// @ts-check
import assert from 'node:assert/strict';
import { afterEach, test } from 'node:test';

import { ApiError } from '../../../static/js/api/errors.js';
import { createPlayer } from '../../../static/js/frames/player.js';
import { createTimebase } from '../../../static/js/model/timebase.js';
import { changeReview, openReview, seek, setPlaying } from '../../../static/js/store/actions/review.js';
import { initialState } from '../../../static/js/store/initial.js';
import { createStore } from '../../../static/js/store/store.js';
import { FRAME_TABLE } from '../server_data.js';
import { tick, waitUntil } from '../wait_until.js';
import { pluck, rowsOf } from '../pluck.js';

/** @type {(() => void)[]} */
const endings = [];
afterEach(() => endings.splice(0).forEach((end) => end()));

/** A player over a cache whose pictures come when the test says so. @param {(run: () => void) => number} [frame]   requests an animation frame @param {typeof FRAME_TABLE} [table] @param {boolean} [isCached]   whether every picture is there */
function createPlayerFixture(frame = () => 1, table = FRAME_TABLE, isCached = false) {
  const video = /** @type {any} */ ({ id: 'v', width: 1280, height: 720, frames: 5000 });
  const store = createStore(changeReview(openReview(initialState(), video), { timebase: createTimebase(table) }));
  /** @type {{kind: string, frame: number, answer: () => void, fail: (why: Error) => void}[]} */
  const requests = [];
  /** @type {[number, boolean][]} */
  const painted = [];
  const ask = (/** @type {string} */ kind) => (/** @type {number} */ frame) =>
    new Promise((resolve, fail) => {
      requests.push({ kind, frame, answer: () => resolve({ frame, width: kind === 'preview' ? 0 : 1280, bitmap: {} }), fail });
    });
  const cache = /** @type {any} */ ({
    peek: (/** @type {number} */ frame) => (isCached ? { frame, width: 1280, bitmap: {} } : null),
    load: ask('load'),
    preview: ask('preview'),
    prefetch: () => {},
    setWidth: () => {},
    clear: () => {},
  });
  let clock = 0;
  const player = createPlayer(store, cache, { now: () => clock, tick: frame, cancelTick: () => {}, retryDelayMs: 1 });
  player.setPainter((picture, isBrief) => painted.push([picture.frame, isBrief]));
  store.subscribe(() => player.sync());
  endings.push(() => player.destroy());
  player.sync();
  requests[0].answer();
  const moveTo = async (/** @type {number} */ frame) => {
    store.dispatch(seek, frame);
    await tick();
  };
  return { store, asked: requests, painted, wait: (/** @type {number} */ ms) => (clock += ms), go: moveTo };
}

test('the first jump requests a preview', async () => {
  const { asked, go } = createPlayerFixture();
  await tick();
  await go(4000);
  assert.deepEqual(rowsOf(asked, 'kind', 'frame'), [
    ['load', 0],
    ['preview', 4000],
  ]);
});

test('scrubbing shows pictures on the way: one request at a time, and none is cancelled', async () => {
  const { asked, painted, store, go } = createPlayerFixture();
  await tick();
  for (const frame of [1000, 2000, 3000]) await go(frame);
  assert.deepEqual(pluck(asked.slice(1), 'frame'), [1000]);
  asked[1].answer();
  await tick();
  assert.deepEqual(painted.at(-1), [1000, true]);
  assert.equal(store.get().review?.shown, 1000); // nobody draws the boxes of 3000 on it
  assert.deepEqual(rowsOf(asked.slice(2), 'kind', 'frame'), [['preview', 3000]]);
  asked[2].answer();
  await tick();
  assert.deepEqual(painted.at(-1), [3000, true]);
  assert.equal(asked.length, 3);
});

test('a picture that failed during an outage is requested again after it', async () => {
  const { asked, painted, store, go } = createPlayerFixture();
  await tick();
  await go(1);
  const offline = new ApiError(0, 'offline', 'The server cannot be reached.');
  asked[1].fail(offline);
  await tick();
  await tick();
  assert.match(store.get().banners[0].text, /Frame 1 cannot be shown. The server cannot be reached/);
  assert.deepEqual(rowsOf(asked.slice(2), 'kind', 'frame'), [['load', 1]]);
  asked[2].fail(new ApiError(0, 'timeout', 'The server did not answer in time.')); // it is waking up
  await tick();
  await tick();
  asked[3].answer();
  await tick();
  assert.deepEqual([painted.at(-1), store.get().banners], [[1, false], []]);
  await go(2);
  asked[4].fail(new ApiError(404, 'missing', 'The file is not there.'));
  await tick();
  await tick();
  assert.equal(asked.length, 5); // what else goes wrong is not asked for again and again
});

test('the banner about the next picture is removed when the picture arrives', async () => {
  /** @type {() => void} */
  let beat = () => {};
  const { asked, store, wait } = createPlayerFixture((run) => ((beat = run), 1));
  await tick();
  store.dispatch(setPlaying, true);
  await tick();
  for (let i = 0; i < 12; i++) {
    wait(500);
    beat();
  }
  assert.deepEqual(rowsOf(asked.slice(1), 'kind', 'frame'), [['load', 1]]);
  for (const [i, code] of ['offline', 'timeout'].entries()) {
    asked[1 + i].fail(new ApiError(0, code, 'The server cannot be reached.'));
    await tick();
    await tick();
    assert.match(store.get().banners[0].text, /Frame 1 cannot be shown/);
    assert.equal(store.get().review?.playing, false);
  }
  asked[3].answer();
  await tick();
  assert.deepEqual(store.get().banners, []);
});

test('a video of two frames a second plays at its own speed', async () => {
  /** @type {() => void} */
  let beat = () => {};
  const { store, wait } = createPlayerFixture((run) => ((beat = run), 1), { ...FRAME_TABLE, time_base: [1, 2] }, true);
  store.dispatch(setPlaying, true);
  await tick();
  for (let i = 0; i <= 30; i++) {
    beat();
    wait(100);
  }
  assert.equal(store.get().review?.frame, 6);
});

test('a jump during playback plays on from there', async () => {
  /** @type {() => void} */
  let beat = () => {};
  const { store, wait, go } = createPlayerFixture((run) => ((beat = run), 1), { ...FRAME_TABLE, time_base: [1, 2] }, true);
  const play = () => {
    for (let i = 0; i < 10; i++) {
      beat();
      wait(100);
    }
    return store.get().review?.frame;
  };
  store.dispatch(setPlaying, true);
  await tick();
  assert.equal(play(), 1);
  for (const place of [1000, 50]) {
    await go(place);
    assert.equal(play(), place + 1);
  }
});

test('playback that waits after a jump requests the picture that it waits for', async () => {
  /** @type {() => void} */
  let beat = () => {};
  const { asked, store, wait, go } = createPlayerFixture((run) => ((beat = run), 1));
  const waitLong = () => {
    for (let i = 0; i < 12; i++) {
      wait(500);
      beat();
    }
  };
  await tick();
  store.dispatch(setPlaying, true);
  await tick();
  waitLong();
  await go(1000);
  waitLong();
  assert.deepEqual(pluck(asked, 'frame'), [0, 1, 1000, 1001]);
});

test('a picture that takes too long does not hold up the next', async () => {
  const { asked, painted, wait, go } = createPlayerFixture();
  await tick();
  await go(1000);
  wait(500);
  await go(2000);
  assert.deepEqual(pluck(asked.slice(1), 'frame'), [1000, 2000]);
  asked[2].answer();
  await tick();
  asked[1].answer();
  await tick();
  assert.deepEqual(painted.at(-1), [2000, true]); // the late one is not put over it
});

test('at rest the sharp picture replaces the soft one', async () => {
  const { asked, painted, go } = createPlayerFixture();
  await tick();
  await go(1000);
  asked[1].answer();
  const sharp = await waitUntil(() => asked.find(({ kind, frame }) => kind === 'load' && frame === 1000));
  sharp.answer();
  await tick();
  assert.deepEqual(painted.at(-1), [1000, false]);
});
