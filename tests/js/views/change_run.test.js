// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ApiError } from '../../../static/js/api/errors.js';
import { createCatchUp } from '../../../static/js/store/catch_up.js';
import { changeRun } from '../../../static/js/views/change_run.js';
import { TOAST } from '../../../static/js/core/toast.js';

const BEFORE = /** @type {any} */ ({ id: 'r', video_id: 'v', state: 'failed' });
const AFTER = /** @type {any} */ ({ ...BEFORE, state: 'queued' });
const rejectRequest = () => Promise.reject(new ApiError(409, 'not_resumable', 'Run 1 is complete.'));

/**
 * @param {() => Promise<any>} call
 * @param {AbortSignal} [signal]
 * @param {any[]} [eventData]   runs that the event stream brings before the answer
 * @returns {Promise<{runs: any[], reported: string[]}>} what the page shows afterwards
 */
async function runChange(call, signal, eventData = []) {
  /** @type {any} */
  let state = { runs: { v: [BEFORE] }, review: null };
  /** @type {string[]} */
  const toasts = [];
  const page = new EventTarget();
  page.addEventListener(TOAST, (event) => toasts.push(/** @type {CustomEvent} */ (event).detail.text));
  Object.assign(globalThis, { document: page });
  const app = createCatchUp(
    /** @type {any} */ ({
      get: () => state,
      dispatch: (/** @type {any} */ action, /** @type {any[]} */ ...args) => {
        state = action(state, ...args);
      },
    }),
  );
  await changeRun(
    app,
    async () => {
      const run = await call();
      for (const data of eventData) app.receive(/** @type {any} */ ({ kind: 'run', subject: 'r', data }));
      return run;
    },
    signal,
  );
  return { runs: state.runs.v, reported: toasts };
}

test('the server’s answer is shown', async () => {
  assert.deepEqual(await runChange(async () => AFTER), { runs: [AFTER], reported: [] });
  assert.deepEqual(await runChange(async () => AFTER, AbortSignal.abort()), { runs: [AFTER], reported: [] });
});

test('an answer that is older than an event does not replace it', async () => {
  const newer = { ...AFTER, state: 'running' };
  assert.deepEqual((await runChange(async () => AFTER, undefined, [newer])).runs, [newer]);
});

test('a refusal is shown, unless it comes after the dialog has closed', async () => {
  const toasts = ['Run 1 is complete.'];
  assert.deepEqual(await runChange(rejectRequest), { runs: [BEFORE], reported: toasts });
  assert.deepEqual(await runChange(rejectRequest, new AbortController().signal), { runs: [BEFORE], reported: toasts });
  assert.deepEqual(await runChange(rejectRequest, AbortSignal.abort()), { runs: [BEFORE], reported: [] });
});
