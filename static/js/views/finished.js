// @ts-check
/** Waits for a file that the server is making. */

import { isRetryable } from '../api/errors.js';
import { isActive } from './output-words.js';

/**
 * Ask about a file until it is made, has failed or was cancelled. The server makes it whether or not a request arrives,
 * so one that may succeed later is repeated.
 *
 * @template {{id: string, state: string}} T
 * @param {T} file
 * @param {(id: string) => Promise<T>} ask
 * @param {{pause: number, left: () => boolean}} options   pause: between requests, ms; left: whether nobody waits any more
 * @returns {Promise<T|null>} null: nobody waits any more
 * @throws {import('../api/errors.js').ApiError}
 */
export async function finished(file, ask, { pause, left }) {
  let now = file;
  while (isActive(now)) {
    await new Promise((resolve) => setTimeout(resolve, pause));
    if (left()) return null;
    try {
      now = await ask(now.id);
    } catch (thrown) {
      if (!isRetryable(thrown)) throw thrown;
    }
    if (left()) return null;
  }
  return now;
}
