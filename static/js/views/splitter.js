// @ts-check
/**
 * A divider between two areas, movable by pointer and keyboard. The size is a CSS variable of the container, in per
 * cent.
 */

import { h } from './dom.js';
import { recall, remember } from '../core/preferences.js';

/**
 * @param {HTMLElement} container   has the variable
 * @param {`--${string}`} variable
 * @param {'vertical'|'horizontal'} orientation   of the divider
 * @param {{label: string, name: string, initial: number, low: number, high: number}} options   label: what it resizes;
 *   name: under which the size is remembered; initial, low, high: share of the container for the area after the divider,
 *   per cent
 * @returns {HTMLElement}
 */
export function createSplitter(container, variable, orientation, { label, name, initial, low, high }) {
  const vertical = orientation === 'vertical';
  const stored = Number(recall(name) ?? NaN);
  let size = Number.isFinite(stored) ? stored : initial;
  const element = h('div', {
    class: `splitter splitter-${orientation}`,
    role: 'separator',
    tabIndex: 0,
    'aria-label': label,
    'aria-orientation': orientation,
    'aria-valuemin': low,
    'aria-valuemax': high,
  });

  /** @param {number} next */
  function setSize(next) {
    size = Math.min(high, Math.max(low, next));
    container.style.setProperty(variable, `${size}%`);
    element.setAttribute('aria-valuenow', String(Math.round(size)));
  }

  /** @param {PointerEvent} event */
  function onMove(event) {
    const area = container.getBoundingClientRect();
    const share = vertical ? (area.right - event.clientX) / area.width : (area.bottom - event.clientY) / area.height;
    setSize(share * 100);
  }

  element.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    event.preventDefault();
    element.setPointerCapture(event.pointerId);
    element.classList.add('dragged');
    element.addEventListener('pointermove', onMove);
  });
  for (const kind of ['pointerup', 'pointercancel']) {
    element.addEventListener(kind, () => {
      element.removeEventListener('pointermove', onMove);
      element.classList.remove('dragged');
      remember(name, size.toFixed(1));
    });
  }
  element.addEventListener('dblclick', () => {
    setSize(initial);
    remember(name, size);
  });
  element.addEventListener('keydown', (event) => {
    const step = event.shiftKey ? 5 : 1;
    const [growKey, shrinkKey] = vertical ? ['ArrowLeft', 'ArrowRight'] : ['ArrowUp', 'ArrowDown'];
    const next = { [growKey]: size + step, [shrinkKey]: size - step, Home: low, End: high }[event.key];
    if (next === undefined || event.altKey) return;
    // The arrows also step frames; while the divider has the focus, they belong to it.
    event.preventDefault();
    event.stopPropagation();
    setSize(next);
    remember(name, size.toFixed(1));
  });
  setSize(size);
  return element;
}
