// @ts-check
/** Makes each request of a review once, and repeats failed ones after a delay. */

import { ApiError } from '../api/errors.js';
import { createRetryDelays } from './retry_delays.js';

/** @typedef {ReturnType<typeof createRequests>} Requests */

/**
 * @param {() => void} onRetry                                      called when the delay of a failed request is over
 * @param {(thrown: unknown, signal: AbortSignal) => void} onError  reports a failed request
 * @param {() => void} onRecovered                                  called when all failed requests have been answered or are no longer needed
 */
export function createRequests(onRetry, onError, onRecovered) {
  /** Requests that were made. For overlays, the first frame that arrived: if it was evicted from the store, it is requested again. @type {Map<string, number|null>} */
  const requested = new Map();
  const delays = createRetryDelays();
  /** Failed requests that are repeated. @type {Set<string>} */
  const failing = new Set();
  /** Whether a failure is reported, and whether the latest request succeeded. */
  let isErrorShown = false;
  let lastSucceeded = true;

  function reportRecovery() {
    if (!isErrorShown || !lastSucceeded || failing.size > 0) return;
    isErrorShown = false;
    onRecovered();
  }

  return {
    clear() {
      requested.clear();
      failing.clear();
      [isErrorShown, lastSucceeded] = [false, true];
      delays.clear();
    },

    /** Forget requests whose name begins with a text, or all others, so that they are made again. @param {string} prefix @param {boolean} [allOthers] */
    forgetPrefix(prefix, allOthers = false) {
      for (const name of [...requested.keys()]) if (name.startsWith(prefix) !== allOthers) requested.delete(name);
    },

    /** Allow failed requests to be repeated at once. */
    retryNow: () => delays.clear(),

    /** Whether a request is pending, was answered, or waits for its retry. @param {string} name */
    isRequested: (name) => requested.has(name) || delays.isWaiting(name),

    /**
     * The same, for answers that may have been evicted.
     * @param {string} name
     * @param {(first: number) => boolean} isStored
     */
    isRequestedOrStored(name, isStored) {
      const firstFrame = requested.get(name);
      return firstFrame === null || delays.isWaiting(name) || (firstFrame !== undefined && isStored(firstFrame));
    },

    /** Record the first frame of an answer. @param {string} name @param {number} first */
    setFirstFrame: (name, first) => void requested.set(name, first),

    /** Forget a request whose answer may be evicted, so that it can be made again. @param {string} name */
    forget: (name) => void requested.delete(name),

    /**
     * @template T
     * @param {string} name
     * @param {AbortSignal} signal
     * @param {() => Promise<T>} request
     * @param {(found: T) => void} onAnswer
     * @param {() => void} [onMissing]   called when the server answers 404
     */
    async load(name, signal, request, onAnswer, onMissing) {
      requested.set(name, null);
      try {
        const answer = await request();
        delays.succeeded(name);
        failing.delete(name);
        lastSucceeded = true;
        reportRecovery();
        onAnswer(answer);
      } catch (thrown) {
        requested.delete(name);
        if (signal.aborted) return;
        if (thrown instanceof ApiError && thrown.status === 404) {
          delays.missing(name);
          if (onMissing) return onMissing();
        } else {
          failing.add(name);
          [isErrorShown, lastSucceeded] = [true, false];
          delays.failed(name, () => {
            if (signal.aborted) return;
            onRetry();
            if (requested.has(name)) return;
            failing.delete(name); // the page no longer needs it
            reportRecovery();
          });
        }
        onError(thrown, signal);
      }
    },
  };
}
