// @ts-check
import assert from 'node:assert/strict';
import { afterEach, test } from 'node:test';

import { ApiError } from '../../../static/js/api/errors.js';
import { createPlayer } from '../../../static/js/frames/player.js';
import { createTimebase } from '../../../static/js/model/timebase.js';
import { changeReview, openReview, seek, setPlaying } from '../../../static/js/store/actions/review.js';
import { initialState } from '../../../static/js/store/initial.js';
import { createStore } from '../../../static/js/store/store.js';
import { waitUntil } from '../wait_until.js';

const turn = () => new Promise((resolve) => setTimeout(resolve, 2));

/** @type {(() => void)[]} */
const endings = [];
afterEach(() => endings.splice(0).forEach((end) => end()));

/** A player over a cache whose pictures come when the test says so. @param {(run: () => void) => number} [tick] */
function create(tick = () => 1) {
  const table = { frames: 5000, time_base: [1, 25], first_pts: 0, steps: [[1, 4999]], keys: [0], corrupt: [] };
  const video = /** @type {any} */ ({ id: 'v', width: 1280, height: 720, frames: 5000 });
  const store = createStore(changeReview(openReview(initialState(), video), { timebase: createTimebase(/** @type {any} */ (table)) }));
  /** @type {{kind: string, frame: number, come: () => void, fail: (why: Error) => void}[]} */
  const asked = [];
  /** @type {[number, boolean][]} */
  const painted = [];
  const ask = (/** @type {string} */ kind) => (/** @type {number} */ frame) =>
    new Promise((resolve, fail) => {
      asked.push({ kind, frame, come: () => resolve({ frame, width: kind === 'preview' ? 0 : 1280, bitmap: {} }), fail });
    });
  const cache = /** @type {any} */ ({
    peek: () => null,
    load: ask('load'),
    preview: ask('preview'),
    want: () => {},
    setWidth: () => {},
    clear: () => {},
  });
  let clock = 0;
  const player = createPlayer(store, cache, { now: () => clock, tick, untick: () => {}, again: 1 });
  player.onShot((shot, passing) => painted.push([shot.frame, passing]));
  store.subscribe(() => player.sync());
  endings.push(() => player.destroy());
  player.sync();
  asked[0].come();
  const go = async (/** @type {number} */ frame) => {
    store.dispatch(seek, frame);
    await turn();
  };
  return { store, asked, painted, wait: (/** @type {number} */ ms) => (clock += ms), go };
}

test('the first leap of all asks for what comes soonest', async () => {
  const { asked, go } = create();
  await turn();
  await go(4000);
  assert.deepEqual(
    asked.map(({ kind, frame }) => [kind, frame]),
    [
      ['load', 0],
      ['preview', 4000],
    ],
  );
});

test('scrubbing shows pictures on the way: one request at a time, and none is cancelled', async () => {
  const { asked, painted, store, go } = create();
  await turn();
  for (const frame of [1000, 2000, 3000]) await go(frame);
  assert.deepEqual(
    asked.slice(1).map(({ frame }) => frame),
    [1000],
  );
  asked[1].come();
  await turn();
  assert.deepEqual(painted.at(-1), [1000, true]);
  assert.equal(store.get().review?.shown, 1000); // nobody draws the boxes of 3000 on it
  assert.deepEqual(
    asked.slice(2).map(({ kind, frame }) => [kind, frame]),
    [['preview', 3000]],
  );
  asked[2].come();
  await turn();
  assert.deepEqual(painted.at(-1), [3000, true]);
  assert.equal(asked.length, 3);
});

test('a picture that the server could not send for being away comes by itself when it is back', async () => {
  const { asked, painted, store, go } = create();
  await turn();
  await go(1);
  const gone = new ApiError(0, 'offline', 'The server cannot be reached.');
  asked[1].fail(gone);
  await turn();
  await turn();
  assert.match(store.get().banners[0].text, /Frame 1 cannot be shown. The server cannot be reached/);
  assert.deepEqual(
    asked.slice(2).map(({ kind, frame }) => [kind, frame]),
    [['load', 1]],
  );
  asked[2].fail(new ApiError(0, 'timeout', 'The server did not answer in time.')); // it is waking up
  await turn();
  await turn();
  asked[3].come();
  await turn();
  assert.deepEqual([painted.at(-1), store.get().banners], [[1, false], []]);
  await go(2);
  asked[4].fail(new ApiError(404, 'missing', 'The file is not there.'));
  await turn();
  await turn();
  assert.equal(asked.length, 5); // what else goes wrong is not asked for again and again
});

test('the banner about the next picture of a playing video goes when that picture is there', async () => {
  /** @type {() => void} */
  let beat = () => {};
  const { asked, store, wait } = create((run) => ((beat = run), 1));
  await turn();
  store.dispatch(setPlaying, true);
  await turn();
  for (let i = 0; i < 12; i++) {
    wait(500);
    beat();
  }
  assert.deepEqual(
    asked.slice(1).map(({ kind, frame }) => [kind, frame]),
    [['load', 1]],
  );
  for (const [i, code] of ['offline', 'timeout'].entries()) {
    asked[1 + i].fail(new ApiError(0, code, 'The server cannot be reached.'));
    await turn();
    await turn();
    assert.match(store.get().banners[0].text, /Frame 1 cannot be shown/);
    assert.equal(store.get().review?.playing, false);
  }
  asked[3].come();
  await turn();
  assert.deepEqual(store.get().banners, []);
});

test('a picture that takes too long does not hold up the next', async () => {
  const { asked, painted, wait, go } = create();
  await turn();
  await go(1000);
  wait(500);
  await go(2000);
  assert.deepEqual(
    asked.slice(1).map(({ frame }) => frame),
    [1000, 2000],
  );
  asked[2].come();
  await turn();
  asked[1].come();
  await turn();
  assert.deepEqual(painted.at(-1), [2000, true]); // the late one is not put over it
});

test('at rest the sharp picture replaces the soft one', async () => {
  const { asked, painted, go } = create();
  await turn();
  await go(1000);
  asked[1].come();
  const sharp = await waitUntil(() => asked.find(({ kind, frame }) => kind === 'load' && frame === 1000));
  sharp.come();
  await turn();
  assert.deepEqual(painted.at(-1), [1000, false]);
});
