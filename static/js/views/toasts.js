// @ts-check
/** Short notices at the lower edge, told to screen readers politely. They hold no decision: what needs one is a banner. */

import {h} from './dom.js';
import {icon} from './icons.js';

/** ms */
const STAY = 6000;

/**
 * @typedef {object} ToastOptions
 * @property {'info'|'good'|'bad'} [tone]
 * @property {{label: string, run: () => void}} [action]
 * @property {string} [topic]   a notice takes the place of an older one on the same
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
  document.dispatchEvent(new CustomEvent(TOAST, {detail: {text, ...options}}));
}

/**
 * @param {{signal: AbortSignal}} app
 * @returns {{element: HTMLElement, destroy: () => void}}
 */
export function createToasts(app) {
  const element = h('div', {class: 'toasts', role: 'status', 'aria-live': 'polite', 'aria-label': 'Notices'});
  const ended = new AbortController();

  /** @param {ToastOptions & {text: string}} detail */
  function show({text, tone = 'info', action, topic}) {
    const close = () => {
      clearTimeout(timer);
      item.remove();
    };
    const item = h('div', {class: `toast toast-${tone}`},
      icon(tone === 'bad' ? 'alert' : tone === 'good' ? 'check' : 'info'),
      h('span', {class: 'grow'}, text),
      action && h('button', {class: 'btn btn-small', type: 'button', onclick: () => {
        close();
        action.run();
      }}, action.label),
      h('button', {class: 'btn btn-quiet btn-icon btn-small', type: 'button', 'aria-label': 'Close this notice', onclick: close}, icon('close')));
    let timer = setTimeout(close, STAY);
    // Nobody loses a notice while reading it.
    item.addEventListener('pointerenter', () => clearTimeout(timer));
    item.addEventListener('pointerleave', () => {
      timer = setTimeout(close, STAY);
    });
    item.dataset.topic = topic ?? text;
    for (const older of element.querySelectorAll('.toast')) if (/** @type {HTMLElement} */ (older).dataset.topic === item.dataset.topic) older.remove();
    element.append(item);
    while (element.childElementCount > 4) element.firstElementChild?.remove();
  }

  document.addEventListener(TOAST, (event) => show(/** @type {CustomEvent} */ (event).detail), {signal: AbortSignal.any([ended.signal, app.signal])});
  return {element, destroy: () => ended.abort()};
}
