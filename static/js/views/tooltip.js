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
  /** @type {Element|null} */ let anchor = null;

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
      const [left, top] = tooltipPlace(
        target.getBoundingClientRect(),
        target.closest('[role="menu"]')?.getBoundingClientRect() ?? null,
        element.getBoundingClientRect(),
        { width: innerWidth, height: innerHeight },
      );
      element.style.setProperty('left', `${left}px`);
      element.style.setProperty('top', `${top}px`);
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

/**
 * The place of a tooltip in the window: beside a menu, so that it covers none of its entries, otherwise below or above
 * the control.
 * @param {Pick<DOMRect, 'left'|'top'|'bottom'|'width'>} control
 * @param {Pick<DOMRect, 'left'|'right'>|null} menu   the menu of the control
 * @param {import('../model/geometry.js').Size} size   of the tooltip
 * @param {import('../model/geometry.js').Size} screen   size of the window
 * @returns {[number, number]} left and top, CSS px
 */
export function tooltipPlace(control, menu, { width, height }, screen) {
  const lastLeft = screen.width - width - GAP_PX;
  if (menu !== null) {
    const top = Math.max(GAP_PX, Math.min(control.top, screen.height - height - GAP_PX));
    if (menu.right + GAP_PX <= lastLeft) return [menu.right + GAP_PX, top];
    if (menu.left - GAP_PX - width >= GAP_PX) return [menu.left - GAP_PX - width, top];
  }
  const below = control.bottom + GAP_PX;
  const top = below + height <= screen.height ? below : control.top - GAP_PX - height;
  return [Math.max(GAP_PX, Math.min(control.left + control.width / 2 - width / 2, lastLeft)), Math.max(GAP_PX, top)];
}
