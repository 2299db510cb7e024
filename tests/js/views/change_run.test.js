// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ApiError } from '../../../static/js/api/errors.js';
import { changeRun } from '../../../static/js/views/change_run.js';
import { TOAST } from '../../../static/js/views/toasts.js';

const BEFORE = /** @type {any} */ ({ id: 'r', video_id: 'v', state: 'failed' });
const AFTER = /** @type {any} */ ({ ...BEFORE, state: 'queued' });
const refuse = () => Promise.reject(new ApiError(409, 'not_resumable', 'Run 1 is complete.'));

/**
 * @param {() => Promise<any>} call
 * @param {AbortSignal} [signal]
 * @returns {Promise<{runs: any[], told: string[]}>} what the page shows afterwards
 */
async function changed(call, signal) {
  /** @type {any} */
  let state = { runs: { v: [BEFORE] }, review: null };
  /** @type {string[]} */
  const told = [];
  const page = new EventTarget();
  page.addEventListener(TOAST, (event) => told.push(/** @type {CustomEvent} */ (event).detail.text));
  Object.assign(globalThis, { document: page });
  await changeRun({ store: { get: () => state, dispatch: (action) => { state = action(state); } } }, call, signal);
  return { runs: state.runs.v, told };
}

test('what the server answers is shown', async () => {
  assert.deepEqual(await changed(async () => AFTER), { runs: [AFTER], told: [] });
  assert.deepEqual(await changed(async () => AFTER, AbortSignal.abort()), { runs: [AFTER], told: [] });
});

test('a refusal is told, unless it comes after the end of the dialog that asked', async () => {
  const told = ['Run 1 is complete.'];
  assert.deepEqual(await changed(refuse), { runs: [BEFORE], told });
  assert.deepEqual(await changed(refuse, new AbortController().signal), { runs: [BEFORE], told });
  assert.deepEqual(await changed(refuse, AbortSignal.abort()), { runs: [BEFORE], told: [] });
});
