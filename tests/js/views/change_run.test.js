// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ApiError } from '../../../static/js/api/errors.js';
import { createCatchUp } from '../../../static/js/store/catch_up.js';
import { changeRun } from '../../../static/js/views/change_run.js';
import { TOAST } from '../../../static/js/core/toast.js';

const BEFORE = /** @type {any} */ ({ id: 'r', video_id: 'v', state: 'failed' });
const AFTER = /** @type {any} */ ({ ...BEFORE, state: 'queued' });
const refuse = () => Promise.reject(new ApiError(409, 'not_resumable', 'Run 1 is complete.'));

/**
 * @param {() => Promise<any>} call
 * @param {AbortSignal} [signal]
 * @param {any[]} [received]   runs that the event stream brings before the answer
 * @returns {Promise<{runs: any[], reported: string[]}>} what the page shows afterwards
 */
async function changed(call, signal, received = []) {
  /** @type {any} */
  let state = { runs: { v: [BEFORE] }, review: null };
  /** @type {string[]} */
  const reported = [];
  const page = new EventTarget();
  page.addEventListener(TOAST, (event) => reported.push(/** @type {CustomEvent} */ (event).detail.text));
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
      for (const data of received) app.receive(/** @type {any} */ ({ kind: 'run', subject: 'r', data }));
      return run;
    },
    signal,
  );
  return { runs: state.runs.v, reported };
}

test('what the server answers is shown', async () => {
  assert.deepEqual(await changed(async () => AFTER), { runs: [AFTER], reported: [] });
  assert.deepEqual(await changed(async () => AFTER, AbortSignal.abort()), { runs: [AFTER], reported: [] });
});

test('an answer that is older than an event does not replace it', async () => {
  const later = { ...AFTER, state: 'running' };
  assert.deepEqual((await changed(async () => AFTER, undefined, [later])).runs, [later]);
});

test('a refusal is shown, unless it comes after the dialog has closed', async () => {
  const reported = ['Run 1 is complete.'];
  assert.deepEqual(await changed(refuse), { runs: [BEFORE], reported });
  assert.deepEqual(await changed(refuse, new AbortController().signal), { runs: [BEFORE], reported });
  assert.deepEqual(await changed(refuse, AbortSignal.abort()), { runs: [BEFORE], reported: [] });
});
