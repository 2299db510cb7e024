// @ts-check
/** Empty states of views: what is missing, why, and what to do. Also errors and waiting. */

import { errorMessage } from '../api/errors.js';
import { fill, h } from './dom.js';
import { icon } from './icons.js';

/** The time after which a waiting view says that it takes long, ms. */
const SLOW_AFTER_MS = 12_000;

/**
 * @param {{icon?: import('./icons.js').IconName, title: string, text?: string, actions?: (HTMLElement|null|false)[], error?: boolean}} options
 * @returns {HTMLElement}
 */
export function emptyState({ icon: name = 'info', title, text, actions = [], error = false }) {
  return h(
    'div',
    { class: error ? 'empty empty-error' : 'empty', role: error ? 'alert' : null },
    icon(name),
    h('h2', title),
    text && h('p', text),
    actions.length > 0 && h('div.empty-actions', ...actions),
  );
}

/**
 * An error, with a button that tries again.
 *
 * @param {string} title
 * @param {unknown} thrown   an error, or a sentence
 * @param {(() => unknown)|undefined} retry
 * @param {...HTMLElement} actions   further actions
 */
export const errorState = (title, thrown, retry, ...actions) =>
  emptyState({
    error: true,
    icon: 'alert',
    title,
    text: typeof thrown === 'string' ? thrown : errorMessage(thrown),
    actions: [
      retry !== undefined && h('button.btn.btn-primary', { onclick: () => void retry() }, icon('refresh'), 'Try again'),
      ...actions,
    ],
  });

/**
 * A waiting view. After a while it says that loading takes long, and offers to try again.
 *
 * @param {string} activity   `Loading the videos`
 * @param {{retry?: () => void, signal?: AbortSignal, slowAfterMs?: number}} [options]
 * @returns {HTMLElement}
 */
export function loadingState(activity, { retry, signal, slowAfterMs = SLOW_AFTER_MS } = {}) {
  const element = h('div.empty', { role: 'status' }, h('p', `${activity} …`), h('span.meter.meter-waiting.empty-meter', h('span')));
  const clearTimer = () => clearTimeout(timer);
  const timer = setTimeout(() => {
    signal?.removeEventListener('abort', clearTimer); // it would keep the element for as long as the page is open
    if (!element.isConnected) return;
    fill(
      element,
      icon('alert'),
      h('h2', 'This takes longer than it should'),
      h(
        'p',
        `${activity}, but the server has not answered yet. It may be busy with a run, or it has stopped: check the terminal where it was started.`,
      ),
      retry && h('div.empty-actions', h('button.btn', { onclick: retry }, icon('refresh'), 'Try again')),
    );
  }, slowAfterMs);
  signal?.addEventListener('abort', clearTimer, { once: true });
  return element;
}
