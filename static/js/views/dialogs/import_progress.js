// @ts-check
/** The progress of an import while its dialog waits for the answer, and a button to cancel it. */

import { ApiError } from '../../api/errors.js';
import { h, setText } from '../dom.js';
import { bytes, count, plural } from '../../model/format.js';
import { randomId } from '../../core/random_id.js';
import { toast } from '../../core/toast.js';

/** Interval of requests, ms. */
const POLL_INTERVAL_MS = 400;

/** Say what happens to an import whose dialog was closed. @param {string} file   its name */
export function reportClosed(file) {
  toast(`The dialog was closed during the import of ${file}, so it is cancelled unless the server stores it already.`, { tone: 'bad' });
}

/** @param {{api: import('../../api/client.js').Api}} setup */
export function createImportProgress({ api }) {
  const text = h('p.muted.small.grow', { role: 'status' });
  const cancelButton = h('button.btn', { onclick: () => void cancelImport() }, 'Cancel import');
  const element = h('div.row.grow', { hidden: true }, text, cancelButton);
  /** The current import. @type {{name: string, sending: AbortController, sent: boolean, isOver: boolean}|null} */
  let current = null;

  async function cancelImport() {
    if (current === null) return;
    cancelButton.disabled = true;
    setText(text, 'Cancelling the import …');
    if (!current.sent) {
      current.sending.abort(); // an incomplete upload is not imported
      return;
    }
    try {
      await api.cancelImport(current.name); // the answer to the import tells the outcome
    } catch (thrown) {
      // it has ended, or is being stored, which cannot be interrupted
      if (!(thrown instanceof ApiError && [404, 409].includes(thrown.status))) cancelButton.disabled = false;
    }
  }

  /** @param {NonNullable<typeof current>} task */
  async function watch(task) {
    while (!task.isOver && current === task) {
      try {
        const { step, boxes, seconds } = await api.importProgress(task.name, { signal: task.sending.signal });
        const elapsed = `${count(Math.round(seconds))} s`;
        if (step === 'storing') cancelButton.disabled = true;
        if (!task.isOver && (step === 'storing' || !cancelButton.disabled))
          setText(
            text,
            {
              waiting: `The server is starting … ${elapsed}`,
              reading: boxes ? `Reading: ${plural(boxes, 'box', 'boxes')} … ${elapsed}` : `Reading and checking … ${elapsed}`,
              storing: `Storing … ${elapsed}`,
            }[step],
          );
      } catch {
        // it has just ended, or the server is unreachable for a moment: the answer to the import reports errors
      }
      await new Promise((resume) => {
        setTimeout(resume, POLL_INTERVAL_MS);
      });
    }
  }

  return {
    element,
    /**
     * Show the progress of one import; settles as `sendRequest` does.
     *
     * @template T
     * @param {AbortSignal} signal     aborted when the dialog closes
     * @param {(options: {progress: string, sending: import('../../api/outputs.js').Sending}) => Promise<T>} sendRequest
     * @returns {Promise<T>}
     */
    async during(signal, sendRequest) {
      const task = { name: randomId().replaceAll('-', ''), sending: new AbortController(), sent: false, isOver: false };
      const abort = () => task.sending.abort();
      signal.addEventListener('abort', abort, { once: true });
      current = task;
      cancelButton.disabled = false;
      element.hidden = false;
      setText(text, 'Sending …');
      try {
        return await sendRequest({
          progress: task.name,
          sending: {
            signal: task.sending.signal,
            onProgress: (sent, total) => {
              if (sent < total) setText(text, `${bytes(sent)} of ${bytes(total)} sent`);
              else if (!task.sent) {
                task.sent = true;
                void watch(task);
              }
            },
          },
        });
      } finally {
        task.isOver = true;
        current = null;
        element.hidden = true;
        signal.removeEventListener('abort', abort);
      }
    },
  };
}
