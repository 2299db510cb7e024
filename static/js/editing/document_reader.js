// @ts-check
/** Reads the documents of the open run from the server. */

import { changeReview } from '../store/actions/review.js';
import { reconcile, UNKNOWN_HISTORY } from './undo_history.js';
import { isRetryableEdit, retryDelay } from './sending.js';

/**
 * @param {object} parts
 * @param {import('../state-types.js').Store} parts.store
 * @param {Pick<import('../api/client.js').Api, 'annotation'>} parts.api
 * @param {import('./editor_state.js').EditorState} parts.edits
 * @param {() => string} parts.author
 * @param {(ms: number) => Promise<void>} parts.sleep
 * @param {AbortSignal} parts.signal
 */
export function createDocumentReader({ store, api, edits, author, sleep, signal }) {
  let isRefreshing = false;
  let needsRefresh = false;
  /** The run whose documents are about to be read again, because the last reading failed. @type {string|null} */
  let retryingRun = null;

  /** Read the documents again after missed events. If the server does not answer, they are read later: no event repeats what was missed. */
  async function refresh(attempts = 0) {
    const run = edits.run;
    if (!edits.ready) edits.isOutdated = true; // the current reading may be older
    if (run === null || !edits.ready) return;
    const annotation = await api.annotation(run, author(), { signal }).catch((thrown) => {
      if (isRetryableEdit(thrown)) void retryLater(run, attempts);
      return null;
    });
    if (annotation === null || edits.run !== run) return;
    edits.confirm(annotation.docs);
    // an answer to an edit may be newer than this one
    if (annotation.seq >= (store.get().review?.seq ?? 0)) {
      edits.history = reconcile(edits.history, annotation);
      store.dispatch(changeReview, { seq: annotation.seq });
    }
    edits.show();
  }

  /** @param {string} run @param {number} attempts */
  async function retryLater(run, attempts) {
    if (retryingRun === run || signal.aborted) return;
    retryingRun = run;
    await sleep(retryDelay(attempts));
    if (retryingRun === run) retryingRun = null;
    if (edits.run === run && !signal.aborted) await refresh(attempts + 1);
  }

  /**
   * Ask the server what can be undone, because it differs from what this page knows. One request, however many events
   * have come.
   */
  async function refreshHistory() {
    edits.history = UNKNOWN_HISTORY;
    needsRefresh = true;
    if (isRefreshing) return;
    isRefreshing = true;
    while (needsRefresh && edits.run !== null && !signal.aborted) {
      needsRefresh = false;
      await refresh();
    }
    isRefreshing = false;
  }

  /** Read a run's documents when it is opened. Repeats until the server answers; null: another run was opened meanwhile. @param {string} run */
  async function read(run) {
    for (let attempts = 0; ; attempts += 1) {
      try {
        return await api.annotation(run, author(), { signal });
      } catch (thrown) {
        if (signal.aborted || edits.run !== run) return null;
        if (!isRetryableEdit(thrown)) throw thrown;
        await sleep(retryDelay(attempts));
      }
    }
  }

  return { read, refresh: () => refresh(), refreshHistory };
}
