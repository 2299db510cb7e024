// @ts-check
/** Current uploads, sent one after the other, with progress, cancel button and errors. */

import { ApiError, errorMessage } from '../api/errors.js';
import { putVideo } from '../store/actions/page.js';
import { fill, h, setText } from './dom.js';
import { bytes } from '../model/format.js';
import { icon } from './icons.js';
import { createProgressBar, setProgress } from './progress_bar.js';
import { toast } from '../core/toast.js';

/**
 * Upload one file, and put its video into the store.
 *
 * @param {Pick<import('../page-types.js').App, 'store'|'api'|'load'>} app
 * @param {File} file
 * @param {Parameters<import('../page-types.js').App['api']['uploadVideo']>[1]} [options]
 * @returns {Promise<string|null>} a message if the video is already in the library; null: it is new
 */
export async function uploadVideo({ store, api, load }, file, options) {
  // read now: the server announces a new video to every page, including this one, before it answers the upload
  const knownVideos = store.get().videos ?? [];
  const video = await load(() => api.uploadVideo(file, options), putVideo);
  const existing = knownVideos.find(({ id }) => id === video.id);
  return existing ? `${file.name} is already in the library${existing.name === file.name ? '' : `, as ${existing.name}`}.` : null;
}

/**
 * Uploads go on while another screen is open; a notice then tells how each ends.
 *
 * @param {import('../page-types.js').App} app
 * @returns {{element: HTMLElement, add: (files: File[]) => void}} element: the list, for the library
 */
export function createUploads(app) {
  const element = h('ul.uploads', { 'aria-label': 'Uploads', hidden: true });
  let queue = Promise.resolve();
  let unfinished = 0;
  // the browser asks before it closes the page
  addEventListener('beforeunload', (event) => unfinished > 0 && event.preventDefault(), { signal: app.signal });

  /** @param {File[]} files */
  function add(files) {
    for (const file of files) queue = startUpload(file, queue);
  }

  /** @param {File} file @param {Promise<void>} previous */
  function startUpload(file, previous) {
    const controller = new AbortController();
    let isStarted = false;
    const statusText = h('span.muted.small.upload-words', 'Waits');
    const bar = createProgressBar(`Upload of ${file.name}`);
    const button = h(
      'button.btn.btn-small',
      {
        onclick: () => {
          controller.abort();
          if (!isStarted) removeItem(); // it was never sent, so nothing has to end first
        },
      },
      'Cancel',
    );
    const item = h('li.upload', icon('upload'), h('span.truncate.upload-name', file.name), bar, statusText, button);
    element.append(item);
    element.hidden = false;
    const removeItem = () => {
      item.remove();
      element.hidden = element.childElementCount === 0;
    };

    /** @param {string} text */
    function fail(text) {
      item.classList.add('upload-failed');
      item.setAttribute('role', 'alert');
      bar.hidden = true;
      setText(statusText, text);
      fill(button, 'Close');
      button.addEventListener('click', removeItem);
      if (!element.isConnected) toast(`${file.name} is not in the library. ${text}`, { tone: 'bad' });
    }

    async function send() {
      await previous;
      const maxBytes = app.store.get().session?.upload_bytes;
      if (controller.signal.aborted) return;
      isStarted = true;
      if (maxBytes !== undefined && file.size > maxBytes) {
        fail(`The file has ${bytes(file.size)}; uploads may have at most ${bytes(maxBytes)}. Add it from its folder instead.`);
        return;
      }
      try {
        const existingMessage = await uploadVideo(app, file, {
          signal: AbortSignal.any([controller.signal, app.signal]),
          onProgress: (sent, total) => {
            setProgress(bar, total ? sent / total : 1);
            setText(statusText, sent === total ? 'The server is checking the file …' : `${bytes(sent)} of ${bytes(total)}`);
          },
        });
        if (existingMessage) toast(existingMessage);
        else if (!element.isConnected) toast(`${file.name} is in the library.`, { tone: 'good' });
        removeItem();
      } catch (thrown) {
        if (thrown instanceof ApiError && thrown.code === 'aborted') removeItem();
        else fail(errorMessage(thrown));
      }
    }
    unfinished += 1;
    return send().finally(() => {
      unfinished -= 1;
    });
  }

  return { element, add };
}
