// @ts-check
/**
 * The tooltip of the control with the keyboard focus. Browsers show a `title` only to the pointer; screen readers read
 * it anyway, so this is only visual.
 */

import { h, setText } from './dom.js';

/** Distance between a control and its tooltip, CSS px. */
const GAP_PX = 6;

/**
 * @param {AbortSignal} signal   aborted when the page ends
 * @returns {HTMLElement}
 */
export function createTooltip(signal) {
  // a popover is drawn on top of dialogs too
  const element = h('div.tooltip', { popover: 'manual', 'aria-hidden': 'true' });
  /** @type {Element|null} */
  let anchor = null;

  function hide() {
    anchor = null;
    if (element.matches(':popover-open')) element.hidePopover();
  }

  document.addEventListener(
    'focusin',
    ({ target }) => {
      hide();
      if (!(target instanceof HTMLElement) || !target.title || !target.matches(':focus-visible')) return;
      anchor = target;
      setText(element, target.title);
      element.showPopover();
      const control = target.getBoundingClientRect();
      const { width, height } = element.getBoundingClientRect();
      const below = control.bottom + GAP_PX;
      const top = below + height <= innerHeight ? below : control.top - GAP_PX - height;
      const left = Math.min(control.left + control.width / 2 - width / 2, innerWidth - width - GAP_PX);
      element.style.setProperty('left', `${Math.max(GAP_PX, left)}px`);
      element.style.setProperty('top', `${Math.max(GAP_PX, top)}px`);
    },
    { signal },
  );
  document.addEventListener('focusout', hide, { signal });
  document.addEventListener('input', hide, { signal }); // it must not cover the results below a field
  document.addEventListener('pointerdown', hide, { signal, capture: true });
  document.addEventListener('scroll', () => anchor && hide(), { signal, capture: true, passive: true });
  document.addEventListener(
    'keydown',
    ({ key }) => {
      if (key === 'Escape') hide();
    },
    { signal, capture: true },
  );
  return element;
}
