// @ts-check
/** Notifies the user, on any screen, when a file that they requested on this page is finished. */

import { isActive } from './output_text.js';
import { toast } from '../core/toast.js';

/** @typedef {import('../types.js').Output} Output */
/** @typedef {import('../core/toast.js').ToastOptions & {text: string}} Notice */

/**
 * The notice about a file; null: none, because the file is visible.
 *
 * @param {Output|undefined} output   unset: it was deleted
 * @param {boolean} isListed          the list of files is on the screen
 * @returns {{text: string, tone: 'good'|'bad', offers: 'download'|'files'}|null}
 */
export function outputNotice(output, isListed) {
  if (!output || isListed || output.state === 'cancelled') return null;
  if (output.state === 'complete') return { text: `${output.name} is ready.`, tone: 'good', offers: 'download' };
  return {
    text: `${output.name} could not be made: ${output.error ?? 'the terminal of the server says why.'}`,
    tone: 'bad',
    offers: 'files',
  };
}

/**
 * Wait for a file and show a notice, once.
 *
 * @param {Pick<import('../page-types.js').App, 'store' | 'signal' | 'api'>} app
 * @param {string} id     id of the file; in the store, or the list of files is still loading
 * @param {(notice: Notice) => void} [notify]
 */
export function notifyWhenFinished(app, id, notify = ({ text, ...options }) => toast(text, options)) {
  const unsubscribe = app.store.subscribe(({ outputs, route }) => {
    const output = outputs?.find((one) => one.id === id);
    if (outputs === null || (output && isActive(output))) return;
    unsubscribe();
    const notice = outputNotice(output, route.screen === 'files');
    if (!notice) return;
    const action =
      notice.offers === 'download'
        ? { label: 'Download', run: () => location.assign(app.api.downloadUrl(id)) }
        : { label: 'Files', run: () => location.assign('#/files') };
    notify({ text: notice.text, tone: notice.tone, action, topic: `made-${id}`, stays: true });
  });
  app.signal.addEventListener('abort', unsubscribe, { once: true });
}
