// @ts-check
/**
 * Short notices, announced politely to screen readers. They ask for no decision: that is for banners. They lie over the
 * road in the picture or, on other screens, over the top bar. The next edit or screen ends them, because they are
 * outdated then and their button would undo something else. Below a dialog they stay until it is closed.
 */

import { TOAST_END, TOAST } from '../core/toast.js';
import { parseRoute, isSameView } from '../model/route.js';
import { h } from './dom.js';
import { icon, iconButton } from './icons.js';

/** @typedef {import('../state-types.js').Route} Route */

const TOAST_DURATION_MS = 6000;
const MAX_TOASTS = 4;

/** @param {Pick<import('../page-types.js').App, 'store'|'signal'>} app @returns {import('../page-types.js').Part} */
export function createToasts({ store, signal }) {
  const element = h('div.toasts', { role: 'status', 'aria-live': 'polite', 'aria-label': 'Notices' });
  /** Shown notices, oldest first; route: the screen of one that ends with the next edit or screen, else null. @type {Set<{topic: string, route: Route|null, close: () => void, countDown: () => void}>} */
  const shown = new Set();
  /** @type {Route|null} */ let route = null;
  const isCovered = () => store.get().dialog !== null;
  let wasCovered = false;

  /** Over the lower part of the picture, where the road is: signs, lanes, the hint and buttons stay visible. */
  function position() {
    const stage = document.querySelector('.picture-stage')?.getBoundingClientRect();
    const isOverPicture = stage !== undefined && stage.width > 0;
    element.classList.toggle('toasts-over-picture', isOverPicture);
    if (!isOverPicture) return;
    element.style.setProperty('--middle', `${stage.left + stage.width / 2}px`);
    const lowest = [...document.querySelectorAll('.picture-hint, .picture-truth-below')].map((part) => part.getBoundingClientRect());
    const free = Math.min(stage.bottom, ...lowest.filter(({ height }) => height > 0).map(({ top }) => top));
    element.style.setProperty('--below', `${innerHeight - free}px`);
    element.style.setProperty('--room', `${stage.width}px`);
  }

  /** @param {import('../core/toast.js').ToastOptions & {text: string}} detail */
  function show({ text, tone = 'info', action, topic, stays = tone === 'bad' }) {
    const close = () => {
      clearTimeout(timer);
      shown.delete(entry);
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
      iconButton('close', 'Close this notice', close, null),
    );
    /** @type {ReturnType<typeof setTimeout>|undefined} */ let timer;
    const countDown = () => {
      clearTimeout(timer);
      timer = isCovered() ? undefined : setTimeout(close, TOAST_DURATION_MS);
    };
    countDown();
    // A notice stays while the pointer is over it.
    item.addEventListener('pointerenter', () => clearTimeout(timer));
    item.addEventListener('pointerleave', countDown);
    const entry = { topic: topic ?? text, route: stays ? null : parseRoute(location.hash), close, countDown };
    for (const older of [...shown]) if (older.topic === entry.topic) older.close();
    shown.add(entry);
    position();
    element.append(item);
    for (const older of [...shown].slice(0, -MAX_TOASTS)) older.close();
  }

  document.addEventListener(TOAST, (event) => show(/** @type {CustomEvent} */ (event).detail), { signal });
  document.addEventListener(TOAST_END, () => [...shown].forEach(({ route, close }) => route && close()), { signal });
  addEventListener('resize', position, { signal });
  return {
    element,
    update(state) {
      if (shown.size > 0) position();
      if (isCovered() !== wasCovered) {
        wasCovered = !wasCovered;
        for (const { countDown } of shown) countDown();
      }
      if (state.route === route) return;
      route = state.route;
      for (const { route: from, close } of [...shown]) if (from && !isSameView(from, state.route, state.review?.run?.id ?? null)) close();
    },
  };
}
