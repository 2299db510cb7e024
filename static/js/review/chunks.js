// @ts-check
/** Loads overlays and ground truth around the cursor, a chunk of frames at a time. */

import { putOverlays, putTruth } from '../store/actions/review.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../state-types.js').State} State */

/** Frames of one request. */
const CHUNK = 128;
/** The longest time that a chunk on its way delays the chunk at the present cursor, ms. */
const PATIENCE = 1000;

/**
 * @param {Pick<App, 'store'|'api'>} app
 * @param {import('./requests.js').Requests} requests
 * @param {object} parts
 * @param {() => string|null} parts.truth   id of the shown ground truth
 * @param {(id: string, signal: AbortSignal) => void} parts.truthGone   called when it was removed, or replaced by another of its name
 * @param {() => void} parts.again          called when a chunk has arrived, because the cursor may have moved
 */
export function createChunks({ store, api }, requests, { truth, truthGone, again }) {
  /** The current request for the cursor's chunk: what was open, and its start time. @type {{of: object, since: number}|null} */
  let fetching = null;

  /**
   * Request the missing chunks around the cursor: the cursor's own first, and one at a time, because a scrubbing user
   * has left it before it arrives.
   * @param {NonNullable<State['review']>} review
   * @param {AbortSignal} signal
   * @param {object} of   what is open; a request for something else delays nothing
   */
  function around(review, signal, of) {
    const middle = Math.floor(review.frame / CHUNK);
    if (fetching !== null && fetching.of === of && performance.now() - fetching.since <= PATIENCE) return;
    const missing = chunk(review, middle, signal);
    if (missing.length === 0) {
      for (const side of [middle + 1, middle - 1]) for (const ask of chunk(review, side, signal)) void ask();
      return;
    }
    const mine = (fetching = { of, since: performance.now() });
    void Promise.all(missing.map((ask) => ask())).finally(() => {
      if (fetching === mine) fetching = null;
      if (!signal.aborted) again(); // the cursor has moved, or other chunks are needed now
    });
  }

  /**
   * Make the requests that a chunk of frames still needs.
   * @param {NonNullable<State['review']>} review
   * @param {number} number
   * @param {AbortSignal} signal
   * @returns {(() => Promise<void>)[]}
   */
  function chunk(review, number, signal) {
    const last = (review.timebase?.frames ?? 1) - 1;
    const first = number * CHUNK;
    if (first < 0 || first > last) return [];
    const end = Math.min(last, first + CHUNK - 1);
    const asks = [];
    for (const [slot, run] of /** @type {const} */ ([
      ['overlays', review.run?.id],
      ['secondOverlays', review.second],
    ])) {
      if (run && !held(review, slot, run, first)) asks.push(() => overlays(run, slot, first, end, signal));
    }
    const id = truth();
    if (id !== null && review.layers.truth && !requests.isAskedFor(`truth/${id}/${first}`)) asks.push(() => boxes(id, first, end, signal));
    return asks;
  }

  /**
   * Whether overlays are loaded or on their way. Evicted ones are requested again.
   * @param {NonNullable<State['review']>} review
   * @param {'overlays'|'secondOverlays'} slot
   * @param {string} run
   * @param {number} first
   */
  function held(review, slot, run, first) {
    return requests.holds(`${slot}/${run}/${first}`, (came) => Boolean(review[slot][came]));
  }

  /**
   * @param {string} run
   * @param {'overlays'|'secondOverlays'} slot
   * @param {number} first
   * @param {number} last
   * @param {AbortSignal} signal
   */
  function overlays(run, slot, first, last, signal) {
    const name = `${slot}/${run}/${first}`;
    return requests.fetched(
      name,
      signal,
      () => api.overlays(run, first, last, { signal }),
      (found) => {
        store.dispatch(putOverlays, slot, found);
        // frames that the run has not reached are requested again by `refresh`
        if (found.length) requests.came(name, found[0].frame);
      },
    );
  }

  /** @param {string} id @param {number} first @param {number} last @param {AbortSignal} signal */
  function boxes(id, first, last, signal) {
    return requests.fetched(
      `truth/${id}/${first}`,
      signal,
      () => api.truthBoxes(id, first, last, { signal }),
      (found) => {
        store.dispatch(putTruth, found, first, last);
      },
      () => truthGone(id, signal),
    );
  }

  return around;
}
