// @ts-check
/** Changes a run for a button: shows the server's answer, or its refusal. */

import { putRun } from '../store/actions/page.js';
import { toastErrors } from './toast_errors.js';

/**
 * @param {Pick<import('../page-types.js').ViewApp, 'load'>} app
 * @param {() => Promise<import('../types.js').Run>} call
 * @param {AbortSignal} [signal]   of a dialog; a refusal after its end is not shown
 */
export const changeRun = (app, call, signal) => toastErrors(() => app.load(call, putRun), signal);
