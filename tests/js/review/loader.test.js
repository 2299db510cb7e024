// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { ApiError } from '../../../static/js/api/errors.js';
import { changeReview, seek, select } from '../../../static/js/store/actions/review.js';
import { eventually } from '../eventually.js';
import { held } from '../held.js';
import { create, turn } from './loader_desk.js';

test("the cursor's own overlays come first, its neighbours when they are there", async () => {
  const { asked, go } = await create();
  assert.deepEqual(
    asked.map(({ first }) => first),
    [0],
  );
  asked[0].come();
  await turn();
  assert.deepEqual(
    asked.map(({ first }) => first),
    [0, 128],
  );
  await go(5); // nothing new is needed there
  assert.equal(asked.length, 2);
});

test('who scrubs has one request on its way, and the next is for where the cursor is then', async () => {
  const { asked, store, go } = await create();
  asked[0].come();
  await turn();
  const before = asked.length;
  for (const frame of [1000, 2000, 3000, 4000]) await go(frame);
  assert.deepEqual(
    asked.slice(before).map(({ first }) => first),
    [896],
  );
  asked[before].come();
  await turn();
  assert.deepEqual(
    asked.slice(before).map(({ first }) => first),
    [896, 3968],
  );
  assert.ok(store.get().review?.overlays[896]); // what came late is kept
});

test('evicted overlays are requested again', async () => {
  const { asked, store, go } = await create();
  asked[0].come();
  await turn();
  await go(2000);
  asked.at(-1)?.come();
  await turn();
  store.dispatch(changeReview, { overlays: {} });
  await turn();
  assert.equal(asked.filter(({ first }) => first === 1920).length, 2);
});

test('evicted lanes are requested again', async () => {
  const { store, lanes } = await create();
  const tracks = Array.from({ length: 43 }, (_, i) => i + 1);
  for (const track of [...tracks, 1]) {
    store.dispatch(select, `m${track}`);
    await turn();
    assert.equal(store.get().review?.laneOf[track]?.id, track);
  }
  assert.ok(Object.keys(store.get().review?.laneOf ?? {}).length <= 40);
  assert.deepEqual(lanes, [...tracks, 1], 'each once, and the first again');
});

test('all lanes of a merged track are loaded, each with one request', async () => {
  const { store, lanes } = await create();
  const tracks = Array.from({ length: 45 }, (_, i) => i + 1);
  const doc = /** @type {any} */ ({ key: 'm1', segments: tracks.map((track) => ({ track, first: track, last: track })), keys: {} });
  store.dispatch((state) => select(changeReview(state, { docs: { m1: doc } }), 'm1'));
  for (let i = 0; i < 5; i += 1) await turn();
  assert.equal(Object.keys(store.get().review?.laneOf ?? {}).length, 45);
  assert.deepEqual(
    [...lanes].sort((a, b) => a - b),
    tracks,
  );
});

test('a running run reloads the lane of the selected track at once, others when they are selected', async () => {
  const { store, lanes, loader } = await create();
  for (const track of [1, 2]) {
    store.dispatch(select, `m${track}`);
    await turn();
  }
  await loader.refresh();
  await turn();
  assert.deepEqual(lanes, [1, 2, 2]);
  assert.deepEqual(store.get().review?.laneOf, { 2: { id: 2, frame: [3] } });
  store.dispatch(select, 'm1');
  await turn();
  assert.deepEqual(lanes, [1, 2, 2, 1]);
});

test('a failed request waits before it is repeated, and a missing thing is not requested again', async () => {
  const { store, lanes, failure } = await create();
  failure.thrown = new ApiError(0, 'offline', 'No answer.');
  store.dispatch(select, 'm7');
  await turn();
  for (let i = 0; i < 20; i++) store.dispatch(seek, i); // each change asks for what is missing
  await turn();
  assert.deepEqual(lanes, [7]);
  failure.thrown = null;
  await eventually(() => lanes.length === 2);
  await turn();
  assert.ok(store.get().review?.laneOf[7]);

  failure.thrown = new ApiError(404, 'not_found', 'There is no such run.');
  store.dispatch(select, 'm8');
  await new Promise((resolve) => setTimeout(resolve, 650));
  for (let i = 0; i < 20; i++) store.dispatch(seek, i);
  assert.deepEqual(lanes, [7, 7, 8]);
});

test('a ground truth that another of its name has replaced is looked up anew, without a word of complaint', async () => {
  const { store, loader, groundTruths, asked } = await create();
  const settle = async () => {
    for (let i = 0; i < 8; i++) {
      for (const { come } of asked.splice(0)) come();
      await turn();
    }
  };
  groundTruths.list = [{ id: 'old' }];
  loader.showTruth('old');
  await settle();
  assert.equal(groundTruths.asked[0], 'old/0');
  groundTruths.list = [{ id: 'new', name: 'second pass' }];
  groundTruths.gone.add('old');
  store.dispatch(seek, 1000);
  await settle();
  assert.ok(
    groundTruths.asked.some((name) => name.startsWith('new/')),
    groundTruths.asked.join(),
  );
  assert.equal(store.get().review?.truthName, 'second pass'); // what the layer's button says
  assert.deepEqual(store.get().banners, []);
});

test('a second run loads its tracks, and its corrections if selected', async () => {
  const { store, loader } = await create();
  loader.showSecond('q', true);
  await turn();
  assert.deepEqual(Object.keys(store.get().review?.secondDocs ?? {}), ['m1']);
  loader.showSecond('q');
  await turn();
  assert.deepEqual(store.get().review?.secondDocs, {});
});

test('the track that the address names is selected with the tracks, and what is selected then stays', async () => {
  const groundTruths = held();
  const tracks = held();
  const { store } = await create({ track: 'm1', answers: { groundTruths: () => groundTruths.promise, tracks: () => tracks.promise } });
  assert.equal(store.get().review?.selected, null, 'without its tracks it could not be judged');
  tracks.release({ id: [1, 2] });
  await turn();
  assert.equal(store.get().review?.selected, 'm1');
  store.dispatch(select, 'm2');
  groundTruths.release([]);
  await turn();
  assert.equal(store.get().review?.selected, 'm2');
});

test('where the address asks for the first track that is left, what people have corrected is waited for', async () => {
  const corrected = held();
  let first = 0;
  const hooks = { opened: () => corrected.promise, first: () => void (first += 1) };
  const { store } = await create({ track: 'next', answers: { tracks: async () => ({ id: [1] }) } }, hooks);
  assert.deepEqual([store.get().review?.tracks?.id, store.get().review?.selected, first], [[1], null, 0]);
  corrected.release();
  await turn();
  assert.equal(first, 1);
});

test('an address that changes while its review is loading is followed', async () => {
  const table = held();
  const { store } = await create({ answers: { frameTable: () => table.promise, tracks: async () => ({ id: [1, 2] }) } });
  store.dispatch((state) => ({ ...state, route: { screen: 'review', video: 'v', run: 'r', frame: 70, track: 'm2' } }));
  table.release({ frames: 5000, time_base: [1, 25], first_pts: 0, steps: [[1, 4999]], keys: [0], corrupt: [] });
  await turn();
  assert.equal(store.get().review?.frame, 70);
  assert.equal(store.get().review?.selected, 'm2');
});

test('progress of a run does not restart the opening of its review', async () => {
  const table = held();
  let asked = 0;
  const { store, loader } = await create({ answers: { frameTable: () => (asked++, table.promise) } });
  for (const frames_done of [10, 20, 30]) loader.follow(/** @type {any} */ ({ id: 'r', video_id: 'v', state: 'running', frames_done }));
  table.release({ frames: 5000, time_base: [1, 25], first_pts: 0, steps: [[1, 4999]], keys: [0], corrupt: [] });
  for (let i = 0; i < 5; i++) await turn();
  assert.equal(asked, 1);
  assert.equal(store.get().review?.run?.id, 'r');
});

test('tracks of an earlier request that arrive later are not shown', async () => {
  /** @type {ReturnType<typeof held>[]} */
  const answers = [];
  const { store, loader } = await create({ answers: { tracks: () => (answers.push(held()), answers[answers.length - 1].promise) } });
  void loader.refresh();
  await turn();
  assert.equal(answers.length, 2);
  answers[1].release({ id: [1, 2, 3] });
  await turn();
  answers[0].release({ id: [1] });
  await turn();
  assert.deepEqual(store.get().review?.tracks?.id, [1, 2, 3]);
});
