// @ts-check
/** Changes a run for a button: shows the server's answer, or its refusal. */

import { sentence } from '../api/errors.js';
import { putRun } from '../store/actions/page.js';
import { toast } from '../core/toast.js';

/**
 * @param {Pick<import('./view_actions.js').ViewApp, 'load'>} app
 * @param {() => Promise<import('../types.js').Run>} call
 * @param {AbortSignal} [signal]   of a dialog; a refusal after its end is not shown
 */
export async function changeRun(app, call, signal) {
  try {
    await app.load(call, putRun);
  } catch (thrown) {
    if (!signal?.aborted) toast(sentence(thrown), { tone: 'bad' });
  }
}
