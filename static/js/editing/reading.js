// @ts-check
/** Reads the documents of the open run from the server. */

import { changeReview } from '../store/actions/review.js';
import { agreed, UNASKED } from './line.js';
import { isPassing, pauseAfter } from './sending.js';

/**
 * @param {object} parts
 * @param {import('../state-types.js').Store} parts.store
 * @param {Pick<import('../api/client.js').Api, 'annotation'>} parts.api
 * @param {import('./work.js').Work} parts.work
 * @param {() => string} parts.author
 * @param {(ms: number) => Promise<void>} parts.rest
 * @param {AbortSignal} parts.signal
 */
export function createReading({ store, api, work, author, rest, signal }) {
  let asking = false;
  let missed = false;
  /** The run whose documents are about to be read again, because the last reading failed. @type {string|null} */
  let late = null;

  /** Read the documents again after missed events. If the server does not answer, they are read later: no event repeats what was missed. */
  async function refresh(tries = 0) {
    const here = work.run;
    if (!work.ready) work.overtaken = true; // the current reading may be older
    if (here === null || !work.ready) return;
    const annotation = await api.annotation(here, author(), { signal }).catch((thrown) => {
      if (isPassing(thrown)) void again(here, tries);
      return null;
    });
    if (annotation === null || work.run !== here) return;
    work.confirm(annotation.docs);
    // an answer to an edit may be newer than this one
    if (annotation.seq >= (store.get().review?.seq ?? 0)) {
      work.line = agreed(work.line, annotation);
      store.dispatch(changeReview, { seq: annotation.seq });
    }
    work.show();
  }

  /** @param {string} run @param {number} tries */
  async function again(run, tries) {
    if (late === run || signal.aborted) return;
    late = run;
    await rest(pauseAfter(tries));
    if (late === run) late = null;
    if (work.run === run && !signal.aborted) await refresh(tries + 1);
  }

  /**
   * Ask the server what can be undone, because it differs from what this page knows. One request, however many events
   * have come.
   */
  async function askAnew() {
    work.line = UNASKED;
    missed = true;
    if (asking) return;
    asking = true;
    while (missed && work.run !== null && !signal.aborted) {
      missed = false;
      await refresh();
    }
    asking = false;
  }

  /** Read a run's documents when it is opened. Repeats until the server answers; null: another run was opened meanwhile. @param {string} wanted */
  async function read(wanted) {
    for (let tries = 0; ; tries += 1) {
      try {
        return await api.annotation(wanted, author(), { signal });
      } catch (thrown) {
        if (signal.aborted || work.run !== wanted) return null;
        if (!isPassing(thrown)) throw thrown;
        await rest(pauseAfter(tries));
      }
    }
  }

  return { read, refresh: () => refresh(), askAnew };
}
