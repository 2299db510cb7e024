// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { ApiError } from '../../../static/js/api/errors.js';
import { select } from '../../../static/js/store/actions/review.js';
import { eventually } from '../eventually.js';
import { create, turn } from './loader_desk.js';

test('tracks that could not be read because the server was away are read when it is back', async () => {
  let away = false;
  let id = [1];
  const { store, loader } = await create({
    answers: {
      tracks: async () => {
        if (away) throw new ApiError(0, 'offline', 'No answer.');
        return { id };
      },
    },
  });
  away = true;
  id = [1, 2];
  await loader.refresh();
  away = false;
  assert.deepEqual(store.get().review?.tracks?.id, [1]);
  await eventually(() => store.get().review?.tracks?.id.length === 2);
});

test('what came too late is requested again, and the banner about it goes', async () => {
  const slow = () => new ApiError(0, 'timeout', 'The server did not answer in time.');
  let late = true;
  const { store, lanes, failure, loader } = await create({
    answers: {
      frameTable: async () => {
        if (late) throw slow();
        return { frames: 5000, time_base: [1, 25], first_pts: 0, steps: [[1, 4999]], keys: [0], corrupt: [] };
      },
      tracks: async () => {
        if (late) throw slow();
        return { id: [7] };
      },
    },
  });
  const shown = () => store.get().banners.map(({ text }) => text);
  assert.deepEqual(shown(), ['The server did not answer in time.']);
  late = false;
  await eventually(() => store.get().review?.tracks?.id[0] === 7);
  assert.deepEqual(shown(), []);

  failure.thrown = slow();
  store.dispatch(select, 'm7');
  await turn();
  assert.deepEqual(shown(), ['The server did not answer in time.']);
  failure.thrown = null;
  await eventually(() => lanes.length === 2);
  await turn();
  assert.deepEqual(shown(), []);

  late = true;
  await loader.refresh();
  assert.deepEqual(shown(), ['The server did not answer in time.']);
  late = false;
  await eventually(() => shown().length === 0);
});

test('the banner goes when what failed is no longer needed', async () => {
  const { store, failure } = await create();
  const shown = () => store.get().banners.map(({ text }) => text);
  failure.thrown = new ApiError(0, 'timeout', 'The server did not answer in time.');
  for (const track of ['m7', 'm8']) {
    store.dispatch(select, track);
    await turn();
  }
  assert.deepEqual(shown(), ['The server did not answer in time.']);
  failure.thrown = null;
  await eventually(() => store.get().review?.laneOf[8] !== undefined);
  await eventually(() => shown().length === 0);
  assert.ok(!store.get().review?.laneOf[7], 'nobody needs it');
});

test('a clock that is set back an hour delays nothing', async (context) => {
  const noon = Date.UTC(2026, 9, 25, 12);
  context.mock.timers.enable({ apis: ['Date'], now: noon });
  let loads = 0;
  const { store, lanes, failure, loader } = await create({ answers: { tracks: async () => ({ id: [(loads += 1)] }) } });
  failure.thrown = new ApiError(0, 'offline', 'No answer.');
  store.dispatch(select, 'm7');
  await turn();
  const run = /** @type {any} */ ({ id: 'r', video_id: 'v', state: 'running', first: 0, frames_done: 10 });
  loader.follow(run);
  await turn();
  const before = loads;
  context.mock.timers.setTime(noon - 3_600_000);
  failure.thrown = null;
  for (let i = 0; i < 20; i += 1) {
    loader.follow(run); // progress comes more often than the tracks are read
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
  assert.ok(loads > before, 'the tracks of the run are read while it goes on');
  assert.equal(lanes.at(-1), 7);
  assert.ok(store.get().review?.laneOf[7], 'the failed request was repeated');
});
