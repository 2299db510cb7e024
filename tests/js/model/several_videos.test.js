// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { addedMessage, videosWithoutRun, processAll, togglePath } from '../../../static/js/model/several_videos.js';

/** @param {string} name @param {string} [state] */
const video = (name, state = 'importing') => /** @type {any} */ ({ id: name, name, state });

test('a click chooses a video, another one lets it go', () => {
  assert.deepEqual(togglePath([], 'a'), ['a']);
  assert.deepEqual(togglePath(['a'], 'b'), ['a', 'b']);
  assert.deepEqual(togglePath(['a', 'b'], 'a'), ['b']);
});

test('one that fails keeps no other back, and is named', async () => {
  const found = await processAll(
    ['a', 'b', 'c'],
    async (path) => {
      if (path === 'b') throw new Error('b is no video.');
      return video(path);
    },
    (thrown) => /** @type {Error} */ (thrown).message,
  );
  assert.deepEqual(found, { done: [video('a'), video('c')], left: ['b'], errors: ['b is no video.'] });
});

test('the message about added videos is one sentence', () => {
  assert.equal(addedMessage([video('a.mp4')]), 'a.mp4 is being imported.');
  assert.equal(addedMessage([video('a.mp4', 'ready')]), 'a.mp4 is in the library.');
  assert.equal(addedMessage([video('a'), video('b')]), '2 videos are being imported.');
  assert.equal(addedMessage([video('a'), video('b', 'ready')]), '1 of 2 videos are being imported, the rest are in the library.');
  assert.equal(addedMessage([video('a', 'ready'), video('b', 'ready')]), '2 videos are in the library.');
});

test('the engine can run on videos that are ready and there, and has not yet', () => {
  const ready = { ...video('a', 'ready'), missing: false, runs: 0 };
  assert.deepEqual(
    videosWithoutRun([ready, { ...ready, id: 'b', runs: 1 }, { ...ready, id: 'c', missing: true }, { ...ready, id: 'd', state: 'failed' }]),
    [ready],
  );
});
