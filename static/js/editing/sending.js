// @ts-check
/**
 * Functions that the editor and the background sender share.
 *
 * @typedef {import('./outbox.js').Pending} Pending
 * @typedef {import('./outbox.js').Outbox} Outbox
 */
import { ApiError } from '../api/errors.js';
import { sleep } from '../api/sleep.js';
import { asCommand, rebase } from './pending.js';

/** Pauses between attempts, ms. */
const RETRY_DELAYS_MS = [500, 1000, 2000, 4000, 8000, 15000];
/** Status codes after which the same operation can never succeed. After any other it is sent again. */
const FINAL_STATUSES = new Set([400, 404, 409, 413, 415, 422, 428]);

/** Code of the only 409 that is temporary: another file is in the video's place, until the video is put back. */
export const FILE_CHANGED = 'file_changed';

/** Code of a 503: another server of the same database has the run's files. */
export const FILES_ELSEWHERE = 'elsewhere';

/** Whether the same operation may succeed later. @param {unknown} thrown @returns {thrown is ApiError} */
export const isRetryableEdit = (thrown) =>
  thrown instanceof ApiError && (!FINAL_STATUSES.has(thrown.status) || thrown.code === FILE_CHANGED);

/**
 * A new track whose label no longer exists, without that label, so that the drawn box is saved; null: another kind of
 * refusal.
 * @param {Pending} next
 * @param {unknown} thrown
 * @returns {Pending|null}
 */
export function withoutMissingLabel(next, thrown) {
  const edit = asCommand(next.command);
  if (edit?.name !== 'create_track' || edit.class_id === null || !(thrown instanceof ApiError) || thrown.code !== 'no_such_label')
    return null;
  const { label_key: _, ...command } = edit;
  return { ...next, command: { ...command, class_id: null } };
}

/** @param {number} attempts   so far @returns {number} ms until the next one */
export const retryDelay = (attempts) => RETRY_DELAYS_MS[Math.min(attempts, RETRY_DELAYS_MS.length - 1)];

/** Pauses that can be ended early, all at once. @returns {{sleep: (ms: number) => Promise<void>, wake: () => void}} */
export function createWakeableSleep() {
  let waking = new AbortController();
  return {
    sleep: (ms) => sleep(ms, waking.signal),
    wake() {
      waking.abort();
      waking = new AbortController();
    },
  };
}

/**
 * Remove a stored operation from the outbox, and rebase the later ones of its run onto the revisions that it produced.
 * @param {Outbox} outbox
 * @param {Pending} stored
 * @param {readonly import('../types.js').TrackDoc[]} docs   as the operation left them
 * @param {readonly Pending[]} later
 */
export async function removeStored(outbox, stored, docs, later) {
  // first those that build on it: after a crash in between, it is sent again and gets the same answer
  await Promise.all(rebase(later, docs).changed.map((one) => outbox.put(one)));
  await outbox.remove(stored.op_id);
}
