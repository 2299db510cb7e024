// @ts-check
/** Loads overlays and ground truth around the cursor, a chunk of frames at a time. */

import { putOverlays, putTruth } from '../store/actions/review.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../state-types.js').State} State */

/** Frames of one request. */
const CHUNK_FRAMES = 128;
/** The longest time that a pending chunk delays the chunk at the cursor, ms. */
const MAX_CHUNK_DELAY_MS = 1000;

/**
 * @param {Pick<App, 'store'|'api'>} app
 * @param {import('./requests.js').Requests} requests
 * @param {object} parts
 * @param {() => string|null} parts.truthId   id of the shown ground truth
 * @param {(id: string, signal: AbortSignal) => void} parts.onTruthMissing   called when it was removed, or replaced by another of its name
 * @param {() => void} parts.onLoaded          called when a chunk has arrived, because the cursor may have moved
 */
export function createChunks({ store, api }, requests, { truthId, onTruthMissing, onLoaded }) {
  /** The pending request for the cursor's chunk. @type {{owner: object, since: number}|null} */
  let current = null;

  /**
   * Request the missing chunks around the cursor: the cursor's own first, and one at a time, because a scrubbing user
   * has left it before it arrives.
   * @param {NonNullable<State['review']>} review
   * @param {AbortSignal} signal
   * @param {object} owner   the open review; a request of another one delays nothing
   */
  function loadAround(review, signal, owner) {
    const cursorChunk = Math.floor(review.frame / CHUNK_FRAMES);
    if (current !== null && current.owner === owner && performance.now() - current.since <= MAX_CHUNK_DELAY_MS) return;
    const missing = missingLoads(review, cursorChunk, signal);
    if (missing.length === 0) {
      for (const neighbour of [cursorChunk + 1, cursorChunk - 1]) for (const load of missingLoads(review, neighbour, signal)) void load();
      return;
    }
    const request = (current = { owner, since: performance.now() });
    void Promise.all(missing.map((load) => load())).finally(() => {
      if (current === request) current = null;
      if (!signal.aborted) onLoaded(); // the cursor has moved, or other chunks are needed now
    });
  }

  /**
   * The requests that a chunk of frames still needs, as functions.
   * @param {NonNullable<State['review']>} review
   * @param {number} index
   * @param {AbortSignal} signal
   * @returns {(() => Promise<void>)[]}
   */
  function missingLoads(review, index, signal) {
    const last = (review.timebase?.frames ?? 1) - 1;
    const first = index * CHUNK_FRAMES;
    if (first < 0 || first > last) return [];
    const end = Math.min(last, first + CHUNK_FRAMES - 1);
    const loads = [];
    for (const [slot, run] of /** @type {const} */ ([
      ['overlays', review.run?.id],
      ['secondOverlays', review.second],
    ])) {
      // evicted ones are requested again
      if (run && !requests.isRequestedOrStored(`${slot}/${run}/${first}`, (frame) => Boolean(review[slot][frame])))
        loads.push(() => loadOverlays(run, slot, first, end, signal));
    }
    const id = truthId();
    if (id !== null && review.layers.truth && !requests.isRequested(`truth/${id}/${first}`))
      loads.push(() => loadTruthBoxes(id, first, end, signal));
    return loads;
  }

  /**
   * @param {string} run
   * @param {'overlays'|'secondOverlays'} slot
   * @param {number} first
   * @param {number} last
   * @param {AbortSignal} signal
   */
  function loadOverlays(run, slot, first, last, signal) {
    const name = `${slot}/${run}/${first}`;
    return requests.load(
      name,
      signal,
      () => api.overlays(run, first, last, { signal }),
      (found) => {
        store.dispatch(putOverlays, slot, found);
        // frames that the run has not reached are requested again by `refresh`
        if (found.length) requests.setFirstFrame(name, found[0].frame);
      },
    );
  }

  /** @param {string} id @param {number} first @param {number} last @param {AbortSignal} signal */
  function loadTruthBoxes(id, first, last, signal) {
    return requests.load(
      `truth/${id}/${first}`,
      signal,
      () => api.truthBoxes(id, first, last, { signal }),
      (found) => store.dispatch(putTruth, found, first, last),
      () => onTruthMissing(id, signal),
    );
  }

  return loadAround;
}
