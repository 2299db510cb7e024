// @ts-check
/** The requests of a review: none is made twice, and a failed one waits before it is repeated. */

import { ApiError } from '../api/errors.js';
import { createRests } from './rests.js';

/** @typedef {ReturnType<typeof createRequests>} Requests */

/**
 * @param {() => void} again                                        called when a wait is over
 * @param {(thrown: unknown, signal: AbortSignal) => void} fail     reports a failed request
 * @param {() => void} recovered                                    called when all failed requests have been answered or are no longer needed
 */
export function createRequests(again, fail, recovered) {
  /** Requests that were made. For overlays, the first frame that arrived: if it was evicted from the store, it is requested again. @type {Map<string, number|null>} */
  const asked = new Map();
  const resting = createRests();
  /** Failed requests that are repeated. @type {Set<string>} */
  const failing = new Set();
  /** Whether a failure was reported since everything was well, and whether the latest answer was no failure. */
  let reported = false;
  let answered = true;

  function settle() {
    if (!reported || !answered || failing.size > 0) return;
    reported = false;
    recovered();
  }

  return {
    clear() {
      asked.clear();
      failing.clear();
      [reported, answered] = [false, true];
      resting.clear();
    },

    /** Forget requests whose name begins with a text, or all others, so that they are made again. @param {string} beginning @param {boolean} [others] */
    forget(beginning, others = false) {
      for (const name of [...asked.keys()]) if (name.startsWith(beginning) !== others) asked.delete(name);
    },

    /** Allow failed requests to be repeated at once. */
    wake: () => resting.clear(),

    /** Whether a request is on its way, was answered, or failed a moment ago. @param {string} name */
    isAskedFor: (name) => asked.has(name) || resting.has(name),

    /**
     * The same, for answers that may have been evicted.
     * @param {string} name
     * @param {(first: number) => boolean} isThere
     */
    holds(name, isThere) {
      const came = asked.get(name);
      return came === null || resting.has(name) || (came !== undefined && isThere(came));
    },

    /** Note an answer. @param {string} name @param {number} first   frame */
    came: (name, first) => void asked.set(name, first),

    /** Forget a request whose answer may be evicted, so that it can be made again. @param {string} name */
    passed: (name) => void asked.delete(name),

    /**
     * @template T
     * @param {string} name
     * @param {AbortSignal} signal
     * @param {() => Promise<T>} ask
     * @param {(found: T) => void} take
     * @param {() => void} [gone]   called when the server no longer has it
     */
    async fetched(name, signal, ask, take, gone) {
      asked.set(name, null);
      try {
        const found = await ask();
        resting.done(name);
        failing.delete(name);
        answered = true;
        settle();
        take(found);
      } catch (thrown) {
        asked.delete(name);
        if (signal.aborted) return;
        if (thrown instanceof ApiError && thrown.status === 404) {
          resting.absent(name);
          if (gone) return gone();
        } else {
          failing.add(name);
          [reported, answered] = [true, false];
          resting.failed(name, () => {
            if (signal.aborted) return;
            again();
            if (asked.has(name)) return;
            failing.delete(name); // the person has gone elsewhere meanwhile
            settle();
          });
        }
        fail(thrown, signal);
      }
    },
  };
}
