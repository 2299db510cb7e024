// @ts-check
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {setRuns, setVideos} from '../../../static/js/store/actions/page.js';
import {createCatchUp} from '../../../static/js/store/catch_up.js';
import {initialState} from '../../../static/js/store/initial.js';
import {createStore} from '../../../static/js/store/store.js';

/** @typedef {import('../../../static/js/types.js').ServerEvent} ServerEvent */

/** @param {string|null} latest_run @returns {any} */
const video = (latest_run) => ({id: 'v', name: 'drive.mp4', state: 'ready', latest_run});
/** @param {string} state @returns {any} */
const run = (state) => ({id: 'r', video_id: 'v', state, frames_done: 0});
/** @param {number} seq @param {string} kind @param {any} data @returns {ServerEvent} */
const event = (seq, kind, data) => ({seq, kind: /** @type {any} */ (kind), subject: data.id, data});

/** An answer that comes when it is told to. @template T */
function later() {
  /** @type {(answer: T) => void} */
  let give = () => {};
  /** @type {(why: Error) => void} */
  let refuse = () => {};
  /** @type {Promise<T>} */
  const answer = new Promise((resolve, reject) => {
    give = resolve;
    refuse = reject;
  });
  return {ask: () => answer, give, refuse};
}

test('an answer older than an event does not hide it', async () => {
  const store = createStore(initialState());
  const {hear, load} = createCatchUp(store);
  const videos = later();
  const done = load(videos.ask, setVideos);
  hear(event(1, 'video', video('r')));
  videos.give([video(null)]);
  assert.deepEqual(await done, [video(null)], 'the caller gets the answer as it was');
  assert.equal(store.get().videos?.[0]?.latest_run, 'r');
});

test('a run that ended while its list was on its way has ended, and no state in between is shown', async () => {
  const store = createStore(initialState());
  const {hear, load} = createCatchUp(store);
  const runs = later();
  /** @type {(string|undefined)[]} */
  const shown = [];
  store.subscribe((state) => shown.push(state.runs['v']?.[0]?.state));
  const done = load(runs.ask, (state, found) => setRuns(state, 'v', found));
  hear(event(1, 'run', run('complete')));
  runs.give([run('running')]);
  await done;
  assert.deepEqual(shown.filter(Boolean), ['complete']);
});

test('what was heard before the question is in the answer and is not heard again', async () => {
  const store = createStore(initialState());
  const {hear, load} = createCatchUp(store);
  hear(event(1, 'run', run('running')));
  await load(async () => [run('complete')], (state, found) => setRuns(state, 'v', found));
  assert.equal(store.get().runs['v']?.[0]?.state, 'complete');
});

test('a video removed while the list was on its way stays removed', async () => {
  const store = createStore(initialState());
  const {hear, load} = createCatchUp(store);
  const videos = later();
  const done = load(videos.ask, setVideos);
  hear({seq: 1, kind: 'removed', subject: 'v', data: {}});
  videos.give([video(null)]);
  await done;
  assert.deepEqual(store.get().videos, []);
});

test('a question that fails leaves the store alone and says so', async () => {
  const store = createStore(initialState());
  const {load} = createCatchUp(store);
  const videos = later();
  const before = store.get();
  const done = load(videos.ask, setVideos);
  videos.refuse(new Error('gone'));
  await assert.rejects(done, /gone/);
  assert.equal(store.get(), before);
});
