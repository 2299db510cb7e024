// @ts-check
/** What was asked for of a review: nothing is asked for twice, and a request that fails rests. */

import { ApiError } from '../api/errors.js';
import { createRests } from './rests.js';

/** @typedef {ReturnType<typeof createRequests>} Requests */

/**
 * @param {() => void} again                                        a rest is over
 * @param {(thrown: unknown, signal: AbortSignal) => void} fail     says that a request has failed
 */
export function createRequests(again, fail) {
  /** What was asked for; with overlays, the first frame that came: gone from the store, it is asked for again. @type {Map<string, number|null>} */
  const asked = new Map();
  const resting = createRests();
  return {
    clear() {
      asked.clear();
      resting.clear();
    },

    /** Forget what begins so, or does not; it is asked for anew. @param {string} beginning @param {boolean} [others] */
    forget(beginning, others = false) {
      for (const name of [...asked.keys()]) if (name.startsWith(beginning) !== others) asked.delete(name);
    },

    /** What has failed may be asked for at once. */
    wake: () => resting.clear(),

    /** On its way, there, or failed a moment ago. @param {string} name */
    isAskedFor: (name) => asked.has(name) || resting.has(name),

    /**
     * The same, where what came may have had to make room.
     * @param {string} name
     * @param {(first: number) => boolean} isThere
     */
    holds(name, isThere) {
      const came = asked.get(name);
      return came === null || resting.has(name) || (came !== undefined && isThere(came));
    },

    /** It has come. @param {string} name @param {number} first   frame */
    came: (name, first) => void asked.set(name, first),

    /** It may have to make room later, and is then asked for again. @param {string} name */
    passed: (name) => void asked.delete(name),

    /**
     * @template T
     * @param {string} name
     * @param {AbortSignal} signal
     * @param {() => Promise<T>} ask
     * @param {(found: T) => void} take
     * @param {() => void} [gone]   there is no such thing any more
     */
    async fetched(name, signal, ask, take, gone) {
      asked.set(name, null);
      try {
        const found = await ask();
        resting.done(name);
        take(found);
      } catch (thrown) {
        asked.delete(name);
        if (signal.aborted) return;
        if (thrown instanceof ApiError && thrown.status === 404) {
          resting.absent(name);
          if (gone) return gone();
        } else setTimeout(() => signal.aborted || again(), resting.failed(name));
        fail(thrown, signal);
      }
    },
  };
}
