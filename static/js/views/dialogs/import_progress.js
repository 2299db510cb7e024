// @ts-check
/** The progress of an import while its dialog waits for the answer, and a button to cancel it. */

import { ApiError } from '../../api/errors.js';
import { h, setText } from '../dom.js';
import { bytes, count, plural } from '../../model/format.js';

/** Interval of requests, ms. */
const PAUSE = 400;

/**
 * @param {{api: import('../../api/client.js').Api}} setup
 */
export function createImportProgress({ api }) {
  const text = h('p.muted.small.grow', { role: 'status' });
  const cancel = h('button.btn', { onclick: () => void end() }, 'Cancel import');
  const element = h('div.row.grow', { hidden: true }, text, cancel);
  /** The current import. @type {{name: string, sending: AbortController, sent: boolean, over: boolean}|null} */
  let now = null;

  async function end() {
    if (now === null) return;
    cancel.disabled = true;
    setText(text, 'Cancelling the import …');
    if (!now.sent) {
      now.sending.abort(); // an incomplete upload is not imported
      return;
    }
    try {
      await api.cancelImport(now.name); // the answer to the import tells the outcome
    } catch (thrown) {
      // it has ended, or is being stored, which cannot be interrupted
      if (!(thrown instanceof ApiError && [404, 409].includes(thrown.status))) cancel.disabled = false;
    }
  }

  /** @param {NonNullable<typeof now>} one */
  async function watch(one) {
    while (!one.over && now === one) {
      try {
        const { step, boxes, seconds } = await api.importProgress(one.name, { signal: one.sending.signal });
        const since = `${count(Math.round(seconds))} s`;
        if (step === 'storing') cancel.disabled = true;
        if (!one.over && (step === 'storing' || !cancel.disabled))
          setText(
            text,
            {
              waiting: `The server is starting … ${since}`,
              reading: boxes ? `Reading: ${plural(boxes, 'box', 'boxes')} … ${since}` : `Reading and checking … ${since}`,
              storing: `Storing … ${since}`,
            }[step],
          );
      } catch {
        // it has just ended, or the server is unreachable for a moment: the answer to the import reports errors
      }
      await new Promise((resume) => {
        setTimeout(resume, PAUSE);
      });
    }
  }

  return {
    element,
    /**
     * Show the progress of one import; settles as `work` does.
     *
     * @template T
     * @param {AbortSignal} signal     aborted when the dialog closes
     * @param {(options: {progress: string, sending: import('../../api/outputs.js').Sending}) => Promise<T>} work
     * @returns {Promise<T>}
     */
    async during(signal, work) {
      const one = { name: crypto.randomUUID().replaceAll('-', ''), sending: new AbortController(), sent: false, over: false };
      const leave = () => one.sending.abort();
      signal.addEventListener('abort', leave, { once: true });
      now = one;
      cancel.disabled = false;
      element.hidden = false;
      setText(text, 'Sending …');
      try {
        return await work({
          progress: one.name,
          sending: {
            signal: one.sending.signal,
            onProgress: (sent, total) => {
              if (sent < total) setText(text, `${bytes(sent)} of ${bytes(total)} sent`);
              else if (!one.sent) {
                one.sent = true;
                void watch(one);
              }
            },
          },
        });
      } finally {
        one.over = true;
        now = null;
        element.hidden = true;
        signal.removeEventListener('abort', leave);
      }
    },
  };
}
