// @ts-check
/** Short notices from anywhere in the page; `views/toasts.js` shows them. */

/**
 * @typedef {object} ToastOptions
 * @property {'info'|'good'|'bad'} [tone]
 * @property {{label: string, run: () => void}} [action]
 * @property {string} [topic]   a notice replaces an older one of the same topic
 * @property {boolean} [stays]  neither an edit nor another screen ends it. Default for `bad`
 *
 * @typedef {(text: string, options?: ToastOptions) => void} Notify   what shows a toast, as `toast` does
 */

/** The event that carries a toast; it bubbles from any element of the page. */
export const TOAST = 'tsr-toast';

/** Show a toast from anywhere. @param {string} text @param {ToastOptions} [options] */
export function toast(text, options = {}) {
  document.dispatchEvent(new CustomEvent(TOAST, { detail: { text, ...options } }));
}

/** The event that ends the notices about the last action. */
export const TOAST_END = 'tsr-toast-over';

/** End the notices about the last action, because another one was made. */
export function endToasts() {
  document.dispatchEvent(new CustomEvent(TOAST_END));
}
