// @ts-check
/** Polls a file that the server is making. */

import { isRetryable } from '../api/errors.js';
import { isActive } from './output_text.js';

/**
 * Poll a file until it is made, has failed or was cancelled. The server makes it whether or not a request arrives, so a
 * request that may succeed later is repeated.
 *
 * @template {{id: string, state: string}} T
 * @param {T} file
 * @param {(id: string) => Promise<T>} fetchFile
 * @param {{intervalMs: number, isAbandoned: () => boolean}} options   isAbandoned: whether nobody waits any more
 * @returns {Promise<T|null>} null: nobody waits any more
 * @throws {import('../api/errors.js').ApiError}
 */
export async function pollUntilFinished(file, fetchFile, { intervalMs, isAbandoned }) {
  let current = file;
  while (isActive(current)) {
    await new Promise((resolve) => setTimeout(resolve, intervalMs));
    if (isAbandoned()) return null;
    try {
      current = await fetchFile(current.id);
    } catch (thrown) {
      if (!isRetryable(thrown)) throw thrown;
    }
    if (isAbandoned()) return null;
  }
  return current;
}
