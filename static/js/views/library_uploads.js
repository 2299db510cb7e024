// @ts-check
/** Current uploads, sent one after the other, with progress, cancel button and errors. */

import { ApiError, sentence } from '../api/errors.js';
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
  const known = store.get().videos ?? [];
  const video = await load(() => api.uploadVideo(file, options), putVideo);
  const there = known.find(({ id }) => id === video.id);
  return there ? `${file.name} is already in the library${there.name === file.name ? '' : `, as ${there.name}`}.` : null;
}

/**
 * @param {import('../page-types.js').App} app
 * @param {AbortSignal} signal
 * @returns {{element: HTMLElement, add: (files: File[]) => void}}
 */
export function createUploads(app, signal) {
  const element = h('ul.uploads', { 'aria-label': 'Uploads', hidden: true });
  let queue = Promise.resolve();

  /** @param {File[]} files */
  function add(files) {
    for (const file of files) queue = begin(file, queue);
  }

  /**
   * @param {File} file
   * @param {Promise<void>} before
   */
  function begin(file, before) {
    const stop = new AbortController();
    let begun = false;
    const words = h('span.muted.small.upload-words', 'Waits');
    const bar = createProgressBar(`Upload of ${file.name}`);
    const button = h(
      'button.btn.btn-small',
      {
        onclick: () => {
          stop.abort();
          if (!begun) close(); // it was never sent, so nothing has to end first
        },
      },
      'Cancel',
    );
    const item = h('li.upload', icon('upload'), h('span.truncate.upload-name', file.name), bar, words, button);
    element.append(item);
    element.hidden = false;
    const close = () => {
      item.remove();
      element.hidden = element.childElementCount === 0;
    };

    /** @param {string} text */
    function fail(text) {
      item.classList.add('upload-failed');
      item.setAttribute('role', 'alert');
      bar.hidden = true;
      setText(words, text);
      fill(button, 'Close');
      button.addEventListener('click', close);
    }

    async function send() {
      await before;
      const most = app.store.get().session?.upload_bytes;
      if (stop.signal.aborted) return;
      begun = true;
      if (most !== undefined && file.size > most) {
        fail(`The file has ${bytes(file.size)}; uploads may have at most ${bytes(most)}. Add it from its folder instead.`);
        return;
      }
      try {
        const there = await uploadVideo(app, file, {
          signal: AbortSignal.any([stop.signal, signal]),
          onProgress: (sent, total) => {
            setProgress(bar, total ? sent / total : 1);
            setText(words, sent === total ? 'The server is checking the file …' : `${bytes(sent)} of ${bytes(total)}`);
          },
        });
        if (there) toast(there);
        close();
      } catch (thrown) {
        if (thrown instanceof ApiError && thrown.code === 'aborted') close();
        else fail(sentence(thrown));
      }
    }
    return send();
  }

  return { element, add };
}
