// @ts-check
/** Overlays and ground truth around the cursor, a chunk of frames at a time. */

import { putOverlays, putTruth } from '../store/actions/review.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../state-types.js').State} State */

/** Frames of one request. */
const CHUNK = 128;
/** After this a chunk that is on its way no longer holds up the one of where the cursor is by now, ms. */
const PATIENCE = 1000;

/**
 * @param {Pick<App, 'store'|'api'>} app
 * @param {import('./requests.js').Requests} requests
 * @param {object} parts
 * @param {() => string|null} parts.truth   the ground truth that is shown
 * @param {(id: string, signal: AbortSignal) => void} parts.truthGone   another one of its name has taken its place, or it was removed
 * @param {() => void} parts.again          a chunk has come: the cursor may have gone on
 */
export function createChunks({ store, api }, requests, { truth, truthGone, again }) {
  /** The request for the cursor's chunk that is on its way: for what was open, and since when. @type {{of: object, since: number}|null} */
  let fetching = null;

  /**
   * Ask for the chunks around the cursor that are not there yet: the cursor's own first, and one at a time, since who
   * scrubs has left it before it comes.
   * @param {NonNullable<State['review']>} review
   * @param {AbortSignal} signal
   * @param {object} of   what is open: a request for something else holds nothing up
   */
  function around(review, signal, of) {
    const middle = Math.floor(review.frame / CHUNK);
    if (fetching !== null && fetching.of === of && Date.now() - fetching.since <= PATIENCE) return;
    const missing = chunk(review, middle, signal);
    if (missing.length === 0) {
      for (const side of [middle + 1, middle - 1]) for (const ask of chunk(review, side, signal)) void ask();
      return;
    }
    const mine = (fetching = { of, since: Date.now() });
    void Promise.all(missing.map((ask) => ask())).finally(() => {
      if (fetching === mine) fetching = null;
      if (!signal.aborted) again(); // the cursor has gone on, or something else is wanted by now
    });
  }

  /**
   * The requests that a chunk of frames still needs.
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
   * Whether overlays are there or on their way; those that had to make room are asked for again.
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
        // where the run has not got to yet is asked again by `refresh`
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
