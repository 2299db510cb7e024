// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { ApiError } from '../../../static/js/api/errors.js';
import { select } from '../../../static/js/store/actions/review.js';
import { tick, waitUntil } from '../wait_until.js';
import { FRAME_TABLE } from '../server_data.js';
import { createLoaderFixture } from './loader_fixture.js';

test('tracks that could not be loaded during an outage are loaded after it', async () => {
  let isOffline = false;
  let id = [1];
  const { store, loader } = await createLoaderFixture({
    answers: {
      tracks: async () => {
        if (isOffline) throw new ApiError(0, 'offline', 'No answer.');
        return { id };
      },
    },
  });
  isOffline = true;
  id = [1, 2];
  await loader.refresh();
  isOffline = false;
  assert.deepEqual(store.get().review?.tracks?.id, [1]);
  await waitUntil(() => store.get().review?.tracks?.id.length === 2);
});

test('a request that timed out is repeated, and its banner is removed', async () => {
  const timeout = () => new ApiError(0, 'timeout', 'The server did not answer in time.');
  let isSlow = true;
  const {
    store,
    requestedLanes: lanes,
    failure,
    loader,
  } = await createLoaderFixture({
    answers: {
      frameTable: async () => {
        if (isSlow) throw timeout();
        return FRAME_TABLE;
      },
      tracks: async () => {
        if (isSlow) throw timeout();
        return { id: [7] };
      },
    },
  });
  const shown = () => store.get().banners.map(({ text }) => text);
  assert.deepEqual(shown(), ['The server did not answer in time.']);
  isSlow = false;
  await waitUntil(() => store.get().review?.tracks?.id[0] === 7);
  assert.deepEqual(shown(), []);

  failure.thrown = timeout();
  store.dispatch(select, 'm7');
  await tick();
  assert.deepEqual(shown(), ['The server did not answer in time.']);
  failure.thrown = null;
  await waitUntil(() => lanes.length === 2);
  await tick();
  assert.deepEqual(shown(), []);

  isSlow = true;
  await loader.refresh();
  assert.deepEqual(shown(), ['The server did not answer in time.']);
  isSlow = false;
  await waitUntil(() => shown().length === 0);
});

test('the banner goes when what failed is no longer needed', async () => {
  const { store, failure } = await createLoaderFixture();
  const shown = () => store.get().banners.map(({ text }) => text);
  failure.thrown = new ApiError(0, 'timeout', 'The server did not answer in time.');
  for (const track of ['m7', 'm8']) {
    store.dispatch(select, track);
    await tick();
  }
  assert.deepEqual(shown(), ['The server did not answer in time.']);
  failure.thrown = null;
  await waitUntil(() => store.get().review?.laneOf[8] !== undefined);
  await waitUntil(() => shown().length === 0);
  assert.ok(!store.get().review?.laneOf[7], 'nobody needs it');
});

test('a clock that is set back an hour delays nothing', async (context) => {
  const noon = Date.UTC(2026, 9, 25, 12);
  context.mock.timers.enable({ apis: ['Date'], now: noon });
  let loads = 0;
  const fixture = await createLoaderFixture({ answers: { tracks: async () => ({ id: [(loads += 1)] }) } });
  const { store, requestedLanes: lanes, failure, loader } = fixture;
  failure.thrown = new ApiError(0, 'offline', 'No answer.');
  store.dispatch(select, 'm7');
  await tick();
  const run = /** @type {any} */ ({ id: 'r', video_id: 'v', state: 'running', first: 0, frames_done: 10 });
  loader.onProgress(run);
  await tick();
  const before = loads;
  context.mock.timers.setTime(noon - 3_600_000);
  failure.thrown = null;
  for (let i = 0; i < 20; i += 1) {
    loader.onProgress(run); // progress comes more often than the tracks are read
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
  assert.ok(loads > before, 'the tracks of the run are read while it goes on');
  assert.equal(lanes.at(-1), 7);
  assert.ok(store.get().review?.laneOf[7], 'the failed request was repeated');
});
