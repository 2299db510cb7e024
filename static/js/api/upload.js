// @ts-check
/** Uploads with progress. Only XMLHttpRequest reports how much was sent. */

import { ApiError, errorFromResponse } from './errors.js';

/** An upload without progress for this long fails, ms. */
const STALL_TIMEOUT_MS = 60_000;
/**
 * The longest wait for an answer after the upload, ms: longer than any import may take (four times
 * `TSR_IMPORT_SECONDS`).
 */
const ANSWER_TIMEOUT_MS = 30 * 60_000;

/**
 * Send a file unchanged.
 *
 * @param {string} url
 * @param {Blob} file
 * @param {{onProgress?: (sent: number, total: number) => void, signal?: AbortSignal, method?: 'PUT'|'POST', request?: XMLHttpRequest}} options
 * @returns {Promise<any>} the parsed JSON of the answer
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
    /** @param {number} timeoutMs @param {string} message */
    const startTimer = (timeoutMs, message) => {
      clearTimeout(timer);
      timer = setTimeout(() => {
        fail(new ApiError(0, 'timeout', message));
        request.abort();
      }, timeoutMs);
    };
    const restartStallTimer = () =>
      startTimer(STALL_TIMEOUT_MS, 'The upload made no progress for a minute. Try again, or add the file by its path.');
    if (signal?.aborted) {
      fail(new ApiError(0, 'aborted', 'The upload was cancelled.'));
      return;
    }
    signal?.addEventListener('abort', stop, { once: true });
    request.open(method, url);
    request.setRequestHeader('Content-Type', 'application/octet-stream');
    request.upload.addEventListener('progress', (event) => {
      restartStallTimer();
      onProgress?.(event.loaded, file.size);
    });
    request.upload.addEventListener('load', () =>
      startTimer(ANSWER_TIMEOUT_MS, 'The server has not answered for half an hour. Reload the page to see whether the file has arrived.'),
    );
    request.addEventListener('load', () => {
      if (request.status < 200 || request.status >= 300) {
        fail(errorFromResponse(request.status, request.responseText));
        return;
      }
      clearTimeout(timer);
      signal?.removeEventListener('abort', stop);
      try {
        resolve(JSON.parse(request.responseText));
      } catch (cause) {
        reject(new ApiError(0, 'bad_answer', 'The server received the upload, but its answer is not valid. Reload the page.', { cause }));
      }
    });
    request.addEventListener('error', () => fail(new ApiError(0, 'offline', 'The upload failed: the server cannot be reached.')));
    request.addEventListener('abort', () => fail(new ApiError(0, 'aborted', 'The upload was cancelled.')));
    restartStallTimer();
    request.send(file);
  });
}
