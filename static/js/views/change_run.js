// @ts-check
/** What a button asks of a run: the server's answer is shown, its refusal told. */

import { sentence } from '../api/errors.js';
import { putRun } from '../store/actions/page.js';
import { toast } from './toasts.js';

/**
 * @param {Pick<import('./app.js').ViewApp, 'store'>} app
 * @param {() => Promise<import('../types.js').Run>} call
 * @param {AbortSignal} [signal]   of a dialog: a refusal that comes after its end is not told
 */
export async function changeRun(app, call, signal) {
  try {
    const run = await call();
    app.store.dispatch((state) => putRun(state, run));
  } catch (thrown) {
    if (!signal?.aborted) toast(sentence(thrown), { tone: 'bad' });
  }
}
