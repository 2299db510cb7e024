// @ts-check
/** Runs an action of a button; an error is shown as a notice. */

import { errorMessage } from '../api/errors.js';
import { toast } from '../core/toast.js';

/**
 * @param {() => Promise<unknown>} action
 * @param {AbortSignal} [signal]   of the view; an error after its end is not shown
 */
export async function toastErrors(action, signal) {
  try {
    await action();
  } catch (thrown) {
    if (!signal?.aborted) toast(errorMessage(thrown), { tone: 'bad' });
  }
}
