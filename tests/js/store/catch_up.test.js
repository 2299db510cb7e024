// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { setRuns, setVideos } from '../../../static/js/store/actions/page.js';
import { createCatchUp } from '../../../static/js/store/catch_up.js';
import { initialState } from '../../../static/js/store/initial.js';
import { createStore } from '../../../static/js/store/store.js';
import { deferred } from '../deferred.js';

/** @typedef {import('../../../static/js/types.js').ServerEvent} ServerEvent */

/** @param {string|null} latest_run @returns {any} */
const video = (latest_run) => ({ id: 'v', name: 'drive.mp4', state: 'ready', latest_run });
/** @param {string} state @returns {any} */
const run = (state) => ({ id: 'r', video_id: 'v', state, frames_done: 0 });
/** @param {number} seq @param {string} kind @param {any} data @returns {ServerEvent} */
const event = (seq, kind, data) => ({ seq, kind: /** @type {any} */ (kind), subject: data.id, data });

test('an answer older than an event does not hide it', async () => {
  const store = createStore(initialState());
  const { receive, load } = createCatchUp(store);
  const videos = deferred();
  const done = load(() => videos.promise, setVideos);
  receive(event(1, 'video', video('r')));
  videos.resolve([video(null)]);
  assert.deepEqual(await done, [video(null)], 'the caller gets the answer as it was');
  assert.equal(store.get().videos?.[0]?.latest_run, 'r');
});

test('a run that ended while its list was on its way has ended, and no state in between is shown', async () => {
  const store = createStore(initialState());
  const { receive, load } = createCatchUp(store);
  const runs = deferred();
  /** @type {(string|undefined)[]} */
  const shown = [];
  store.subscribe((state) => shown.push(state.runs['v']?.[0]?.state));
  const done = load(
    () => runs.promise,
    (state, found) => setRuns(state, 'v', found),
  );
  receive(event(1, 'run', run('complete')));
  runs.resolve([run('running')]);
  await done;
  assert.deepEqual(shown.filter(Boolean), ['complete']);
});

test('what was heard before the question is in the answer and is not heard again', async () => {
  const store = createStore(initialState());
  const { receive, load } = createCatchUp(store);
  receive(event(1, 'run', run('running')));
  await load(
    async () => [run('complete')],
    (state, found) => setRuns(state, 'v', found),
  );
  assert.equal(store.get().runs['v']?.[0]?.state, 'complete');
});

test('a video removed while the list was on its way stays removed', async () => {
  const store = createStore(initialState());
  const { receive, load } = createCatchUp(store);
  const videos = deferred();
  const done = load(() => videos.promise, setVideos);
  receive({ seq: 1, kind: 'removed', subject: 'v', data: {} });
  videos.resolve([video(null)]);
  await done;
  assert.deepEqual(store.get().videos, []);
});

test('a question that fails leaves the store alone and says so', async () => {
  const store = createStore(initialState());
  const { load } = createCatchUp(store);
  const videos = deferred();
  const before = store.get();
  const done = load(() => videos.promise, setVideos);
  videos.reject(new Error('gone'));
  await assert.rejects(done, /gone/);
  assert.equal(store.get(), before);
});
