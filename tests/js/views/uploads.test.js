// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { putVideo, setVideos } from '../../../static/js/store/actions/page.js';
import { initialState } from '../../../static/js/store/initial.js';
import { createStore } from '../../../static/js/store/store.js';
import { createCatchUp } from '../../../static/js/store/catch_up.js';
import { uploadVideo } from '../../../static/js/views/library_uploads.js';
import { pluck } from '../pluck.js';

test('a new video is not reported as known, even if its event arrives before the answer to the upload', async () => {
  const store = createStore(setVideos(initialState(), []));
  const video = /** @type {any} */ ({ id: 'a', name: 'drive.mp4' });
  const app = /** @type {any} */ ({
    store,
    load: createCatchUp(/** @type {any} */ (store)).load,
    api: {
      uploadVideo: async () => {
        store.dispatch(putVideo, video);
        return video;
      },
    },
  });
  const file = /** @type {any} */ ({ name: 'drive.mp4' });
  assert.equal(await uploadVideo(app, file), null);
  assert.equal(await uploadVideo(app, file), 'drive.mp4 is already in the library.');
  assert.equal(await uploadVideo(app, /** @type {any} */ ({ name: 'copy.mp4' })), 'copy.mp4 is already in the library, as drive.mp4.');
  assert.deepEqual(pluck(store.get().videos, 'id'), ['a']);
});
