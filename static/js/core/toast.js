// @ts-check
/** Short notices from anywhere of the page; `views/toasts.js` shows them. */

/**
 * @typedef {object} ToastOptions
 * @property {'info'|'good'|'bad'} [tone]
 * @property {{label: string, run: () => void}} [action]
 * @property {string} [topic]   a notice takes the place of an older one on the same
 * @property {boolean} [stays]  it is not about what was just done here: neither an edit nor another screen ends it. Usual for `bad`
 */

/** The event that carries a toast; it bubbles from any element of the page. */
export const TOAST = 'tsr-toast';

/**
 * Show a toast from anywhere.
 *
 * @param {string} text
 * @param {ToastOptions} [options]
 */
export function toast(text, options = {}) {
  document.dispatchEvent(new CustomEvent(TOAST, { detail: { text, ...options } }));
}

/** The event that ends those about what was done last. */
export const OVER = 'tsr-toast-over';

/** Something else has been done: what is informed of the last thing goes. */
export function endToasts() {
  document.dispatchEvent(new CustomEvent(OVER));
}
