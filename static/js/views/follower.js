// @ts-check
/** Sends the newest of many values: one at a time, with a pause in between, skipping outdated ones. */

/**
 * @template T
 * @param {(value: T) => Promise<void>} send   a failure is reported to `failed`, and the next value is sent anyway
 * @param {{pause?: number, wait?: (ms: number) => Promise<void>, failed?: (thrown: unknown) => void}} [options]   pause: ms
 * @returns {{push: (value: T) => void, stop: () => void}}
 */
export function createFollower(send, { pause = 80, wait = sleep, failed = () => {} } = {}) {
  /** @type {{value: T}|null} */
  let next = null;
  let busy = false;
  let stopped = false;

  async function run() {
    busy = true;
    while (next && !stopped) {
      const { value } = next;
      next = null;
      try {
        await send(value);
      } catch (thrown) {
        failed(thrown);
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
