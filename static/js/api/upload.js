// @ts-check
/** Sending a file with progress. Only XMLHttpRequest tells how much has left. */

import { ApiError, errorOfAnswer } from './errors.js';

/** A connection on which nothing moves for this long is given up, ms. */
const STALL = 60_000;
/** Reading what was sent may take this long, ms: longer than any import may (`TSR_IMPORT_SECONDS`, four times). */
const ANSWER = 30 * 60_000;

/**
 * Send a file as it is.
 *
 * @param {string} url
 * @param {Blob} file
 * @param {{onProgress?: (sent: number, total: number) => void, signal?: AbortSignal, method?: 'PUT'|'POST', request?: XMLHttpRequest}} options
 * @returns {Promise<any>} the JSON of the answer
 * @throws {ApiError}
 */
export function upload(url, file, { onProgress, signal, method = 'PUT', request = new XMLHttpRequest() }) {
  return new Promise((resolve, reject) => {
    /** @type {ReturnType<typeof setTimeout>|undefined} */
    let timer;
    const stop = () => request.abort();
    /** @param {ApiError} error */
    const fail = (error) => {
      clearTimeout(timer);
      signal?.removeEventListener('abort', stop);
      reject(error);
    };
    /** @param {number} patience @param {string} sentence */
    const wait = (patience, sentence) => {
      clearTimeout(timer);
      timer = setTimeout(() => {
        fail(new ApiError(0, 'timeout', sentence));
        request.abort();
      }, patience);
    };
    const moved = () => wait(STALL, 'The upload has not moved for a minute. Try again, or add the file by its path.');
    if (signal?.aborted) {
      fail(new ApiError(0, 'aborted', 'The upload was cancelled.'));
      return;
    }
    signal?.addEventListener('abort', stop, { once: true });
    request.open(method, url);
    request.setRequestHeader('Content-Type', 'application/octet-stream');
    request.upload.addEventListener('progress', (event) => {
      moved();
      onProgress?.(event.loaded, file.size);
    });
    request.upload.addEventListener('load', () =>
      wait(ANSWER, 'The server has not answered for half an hour. Reload the page to see what has arrived.'),
    );
    request.addEventListener('load', () => {
      if (request.status < 200 || request.status >= 300) {
        fail(errorOfAnswer(request.status, request.responseText));
        return;
      }
      clearTimeout(timer);
      signal?.removeEventListener('abort', stop);
      try {
        resolve(JSON.parse(request.responseText));
      } catch (cause) {
        reject(new ApiError(0, 'bad_answer', 'The server took the upload and sent no valid answer. Reload the page.', { cause }));
      }
    });
    request.addEventListener('error', () => fail(new ApiError(0, 'offline', 'The upload broke off: the server cannot be reached.')));
    request.addEventListener('abort', () => fail(new ApiError(0, 'aborted', 'The upload was cancelled.')));
    moved();
    request.send(file);
  });
}
