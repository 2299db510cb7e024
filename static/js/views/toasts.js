// @ts-check
/**
 * Short notices, announced politely to screen readers. They ask for no decision: that is for banners. They lie over the
 * road in the picture or, on other screens, over the top bar. The next edit or screen ends them, because they are
 * outdated then and their button would undo something else.
 */

import { TOAST_END, TOAST } from '../core/toast.js';
import { parseRoute, isSameView } from '../model/route.js';
import { h } from './dom.js';
import { icon } from './icons.js';

/** @typedef {import('../state-types.js').Route} Route */

/** ms */
const TOAST_DURATION_MS = 6000;

/**
 * @param {{signal: AbortSignal}} app
 * @returns {import('../page-types.js').View}
 */
export function createToasts(app) {
  const element = h('div.toasts', { role: 'status', 'aria-live': 'polite', 'aria-label': 'Notices' });
  const lifetime = new AbortController();
  const signal = AbortSignal.any([lifetime.signal, app.signal]);
  /** Notices that end with the next edit or screen: their screen, and the function that ends them. @type {Map<HTMLElement, {route: Route, close: () => void}>} */
  const temporary = new Map();
  /** @type {Route|null} */
  let route = null;

  /** Over the lower part of the picture, where the road is: signs, lanes and buttons stay visible. */
  function position() {
    const stage = document.querySelector('.picture-stage')?.getBoundingClientRect();
    const isOverPicture = stage !== undefined && stage.width > 0;
    element.classList.toggle('toasts-over-picture', isOverPicture);
    if (!isOverPicture) return;
    element.style.setProperty('--middle', `${stage.left + stage.width / 2}px`);
    element.style.setProperty('--below', `${innerHeight - stage.bottom}px`);
    element.style.setProperty('--room', `${stage.width}px`);
  }

  /** @param {import('../core/toast.js').ToastOptions & {text: string}} detail */
  function show({ text, tone = 'info', action, topic, stays = tone === 'bad' }) {
    const close = () => {
      clearTimeout(timer);
      temporary.delete(item);
      item.remove();
    };
    const item = h(
      'div',
      { class: `toast toast-${tone}` },
      icon(tone === 'bad' ? 'alert' : tone === 'good' ? 'check' : 'info'),
      h('span.grow', text),
      action &&
        h(
          'button.btn.btn-small',
          {
            onclick: () => {
              close();
              action.run();
            },
          },
          action.label,
        ),
      h('button.btn.btn-quiet.btn-icon.btn-small', { 'aria-label': 'Close this notice', onclick: close }, icon('close')),
    );
    let timer = setTimeout(close, TOAST_DURATION_MS);
    // A notice stays while the pointer is over it.
    item.addEventListener('pointerenter', () => clearTimeout(timer));
    item.addEventListener('pointerleave', () => {
      timer = setTimeout(close, TOAST_DURATION_MS);
    });
    item.dataset.topic = topic ?? text;
    if (!stays) temporary.set(item, { route: parseRoute(location.hash), close });
    for (const older of element.querySelectorAll('.toast'))
      if (/** @type {HTMLElement} */ (older).dataset.topic === item.dataset.topic) older.remove();
    position();
    element.append(item);
    while (element.childElementCount > 4) element.firstElementChild?.remove();
  }

  document.addEventListener(TOAST, (event) => show(/** @type {CustomEvent} */ (event).detail), { signal });
  document.addEventListener(TOAST_END, () => [...temporary.values()].forEach(({ close }) => close()), { signal });
  addEventListener('resize', position, { signal });
  return {
    element,
    update(state) {
      if (state.route === route) return;
      route = state.route;
      if (element.childElementCount > 0) position();
      for (const shown of [...temporary.values()]) if (!isSameView(shown.route, state.route, state.review?.run?.id ?? null)) shown.close();
    },
    destroy: () => lifetime.abort(),
  };
}
