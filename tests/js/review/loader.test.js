// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { ApiError } from '../../../static/js/api/errors.js';
import { changeReview, seek, select } from '../../../static/js/store/actions/review.js';
import { tick, waitUntil } from '../wait_until.js';
import { deferred } from '../deferred.js';
import { FRAME_TABLE } from '../server_data.js';
import { createLoaderFixture } from './loader_fixture.js';
import { pluck } from '../pluck.js';

test("the cursor's overlays are requested first, those of its neighbours after their arrival", async () => {
  const { overlayRequests: asked, moveTo: go } = await createLoaderFixture();
  assert.deepEqual(pluck(asked, 'first'), [0]);
  asked[0].answer();
  await tick();
  assert.deepEqual(pluck(asked, 'first'), [0, 128]);
  await go(5); // nothing new is needed there
  assert.equal(asked.length, 2);
});

test('scrubbing makes one request at a time, and the next one is for the cursor of that moment', async () => {
  const { overlayRequests: asked, store, moveTo: go } = await createLoaderFixture();
  asked[0].answer();
  await tick();
  const before = asked.length;
  for (const frame of [1000, 2000, 3000, 4000]) await go(frame);
  assert.deepEqual(pluck(asked.slice(before), 'first'), [896]);
  asked[before].answer();
  await tick();
  assert.deepEqual(pluck(asked.slice(before), 'first'), [896, 3968]);
  assert.ok(store.get().review?.overlays[896]); // late overlays are kept
});

test('evicted overlays are requested again', async () => {
  const { overlayRequests: asked, store, moveTo: go } = await createLoaderFixture();
  asked[0].answer();
  await tick();
  await go(2000);
  asked.at(-1)?.answer();
  await tick();
  store.dispatch(changeReview, { overlays: {} });
  await tick();
  assert.equal(asked.filter(({ first }) => first === 1920).length, 2);
});

test('evicted lanes are requested again', async () => {
  const { store, requestedLanes: lanes } = await createLoaderFixture();
  const tracks = Array.from({ length: 43 }, (_, i) => i + 1);
  for (const track of [...tracks, 1]) {
    store.dispatch(select, `m${track}`);
    await tick();
    assert.equal(store.get().review?.laneOf[track]?.id, track);
  }
  assert.ok(Object.keys(store.get().review?.laneOf ?? {}).length <= 40);
  assert.deepEqual(lanes, [...tracks, 1], 'each once, and the first again');
});

test('all lanes of a merged track are loaded, each with one request', async () => {
  const { store, requestedLanes: lanes } = await createLoaderFixture();
  const tracks = Array.from({ length: 45 }, (_, i) => i + 1);
  const doc = /** @type {any} */ ({ key: 'm1', segments: tracks.map((track) => ({ track, first: track, last: track })), keys: {} });
  store.dispatch((state) => select(changeReview(state, { docs: { m1: doc } }), 'm1'));
  for (let i = 0; i < 5; i += 1) await tick();
  assert.equal(Object.keys(store.get().review?.laneOf ?? {}).length, 45);
  assert.deepEqual(
    [...lanes].sort((a, b) => a - b),
    tracks,
  );
});

test('a running run reloads the lane of the selected track at once, others when they are selected', async () => {
  const { store, requestedLanes: lanes, loader } = await createLoaderFixture();
  for (const track of [1, 2]) {
    store.dispatch(select, `m${track}`);
    await tick();
  }
  await loader.refresh();
  await tick();
  assert.deepEqual(lanes, [1, 2, 2]);
  assert.deepEqual(store.get().review?.laneOf, { 2: { id: 2, frame: [3] } });
  store.dispatch(select, 'm1');
  await tick();
  assert.deepEqual(lanes, [1, 2, 2, 1]);
});

test('a failed request waits before it is repeated, and a missing thing is not requested again', async () => {
  const { store, requestedLanes: lanes, failure } = await createLoaderFixture();
  failure.thrown = new ApiError(0, 'offline', 'No answer.');
  store.dispatch(select, 'm7');
  await tick();
  for (let i = 0; i < 20; i++) store.dispatch(seek, i); // each change asks for what is missing
  await tick();
  assert.deepEqual(lanes, [7]);
  failure.thrown = null;
  await waitUntil(() => lanes.length === 2);
  await tick();
  assert.ok(store.get().review?.laneOf[7]);

  failure.thrown = new ApiError(404, 'not_found', 'There is no such run.');
  store.dispatch(select, 'm8');
  await new Promise((resolve) => setTimeout(resolve, 650));
  for (let i = 0; i < 20; i++) store.dispatch(seek, i);
  assert.deepEqual(lanes, [7, 7, 8]);
});

test('a ground truth that was replaced by another of its name is looked up again, without an error', async () => {
  const { store, loader, groundTruths, overlayRequests: asked } = await createLoaderFixture();
  const settle = async () => {
    for (let i = 0; i < 8; i++) {
      for (const { answer: come } of asked.splice(0)) come();
      await tick();
    }
  };
  groundTruths.list = [{ id: 'old' }];
  loader.showTruth('old');
  await settle();
  assert.equal(groundTruths.requested[0], 'old/0');
  groundTruths.list = [{ id: 'new', name: 'second pass' }];
  groundTruths.deleted.add('old');
  store.dispatch(seek, 1000);
  await settle();
  assert.ok(
    groundTruths.requested.some((name) => name.startsWith('new/')),
    groundTruths.requested.join(),
  );
  assert.equal(store.get().review?.truthName, 'second pass'); // what the layer's button says
  assert.deepEqual(store.get().banners, []);
});

test('a second run loads its tracks, and its corrections if selected', async () => {
  const { store, loader } = await createLoaderFixture();
  loader.showSecond('q', true);
  await tick();
  assert.deepEqual(Object.keys(store.get().review?.secondDocs ?? {}), ['m1']);
  loader.showSecond('q');
  await tick();
  assert.deepEqual(store.get().review?.secondDocs, {});
});

test('the track in the address is selected when the tracks arrive; a later selection stays', async () => {
  const groundTruths = deferred();
  const tracks = deferred();
  const { store } = await createLoaderFixture({
    track: 'm1',
    answers: { groundTruths: () => groundTruths.promise, tracks: () => tracks.promise },
  });
  assert.equal(store.get().review?.selected, null, 'the tracks have not arrived');
  tracks.resolve({ id: [1, 2] });
  await tick();
  assert.equal(store.get().review?.selected, 'm1');
  store.dispatch(select, 'm2');
  groundTruths.resolve([]);
  await tick();
  assert.equal(store.get().review?.selected, 'm2');
});

test('the first undecided track is opened once the corrections are loaded', async () => {
  const corrections = deferred();
  let first = 0;
  const hooks = { onOpened: () => corrections.promise, openFirst: () => void (first += 1) };
  const { store } = await createLoaderFixture({ track: 'next', answers: { tracks: async () => ({ id: [1] }) } }, hooks);
  assert.deepEqual([store.get().review?.tracks?.id, store.get().review?.selected, first], [[1], null, 0]);
  corrections.resolve();
  await tick();
  assert.equal(first, 1);
});

test('an address that changes while its review is loading is followed', async () => {
  const table = deferred();
  const { store } = await createLoaderFixture({ answers: { frameTable: () => table.promise, tracks: async () => ({ id: [1, 2] }) } });
  store.dispatch((state) => ({ ...state, route: { screen: 'review', video: 'v', run: 'r', frame: 70, track: 'm2' } }));
  table.resolve(FRAME_TABLE);
  await tick();
  assert.equal(store.get().review?.frame, 70);
  assert.equal(store.get().review?.selected, 'm2');
});

test('progress of a run does not restart the opening of its review', async () => {
  const table = deferred();
  let requests = 0;
  const { store, loader } = await createLoaderFixture({ answers: { frameTable: () => (requests++, table.promise) } });
  for (const frames_done of [10, 20, 30]) loader.onProgress(/** @type {any} */ ({ id: 'r', video_id: 'v', state: 'running', frames_done }));
  table.resolve(FRAME_TABLE);
  for (let i = 0; i < 5; i++) await tick();
  assert.equal(requests, 1);
  assert.equal(store.get().review?.run?.id, 'r');
});

test('tracks of an earlier request that arrive later are not shown', async () => {
  /** @type {ReturnType<typeof deferred>[]} */
  const answers = [];
  const { store, loader } = await createLoaderFixture({
    answers: { tracks: () => (answers.push(deferred()), answers[answers.length - 1].promise) },
  });
  void loader.refresh();
  await tick();
  assert.equal(answers.length, 2);
  answers[1].resolve({ id: [1, 2, 3] });
  await tick();
  answers[0].resolve({ id: [1] });
  await tick();
  assert.deepEqual(store.get().review?.tracks?.id, [1, 2, 3]);
});
