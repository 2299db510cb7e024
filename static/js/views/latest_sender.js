// @ts-check
/** Sends the newest of many values: one at a time, with a pause in between, skipping outdated ones. */

import { isRetryable } from '../api/errors.js';

/** Pause before a value is sent again, ms. */
const RETRY_DELAY_MS = 2000;

/**
 * @template T
 * @param {(value: T) => Promise<void>} send   a failure is reported to `onError`; if it may be temporary, this value or a newer one is sent later
 * @param {{pauseMs?: number, wait?: (ms: number) => Promise<void>, onError?: (thrown: unknown) => void}} [options]
 * @returns {{push: (value: T) => void, stop: () => void}}
 */
export function createLatestSender(send, { pauseMs = 80, wait = sleep, onError = () => {} } = {}) {
  /** @type {{value: T}|null} */ let next = null;
  let busy = false;
  let stopped = false;

  async function run() {
    busy = true;
    while (next && !stopped) {
      const { value } = next;
      let pause = pauseMs;
      next = null;
      try {
        await send(value);
      } catch (thrown) {
        onError(thrown);
        if (isRetryable(thrown)) {
          next ??= { value };
          pause = RETRY_DELAY_MS;
        }
      }
      await wait(pause);
    }
    busy = false;
  }

  return {
    push(value) {
      next = { value };
      if (!busy && !stopped) void run();
    },
    stop() {
      stopped = true;
      next = null;
    },
  };
}

/** @param {number} ms @returns {Promise<void>} */
function sleep(ms) {
  return new Promise((resolve) => setTimeout(resolve, ms));
}
