// @ts-check
/** Progress bars. */

import { h, setAttribute } from './dom.js';

/** @param {string} label @param {'span.meter'|'span.meter.run-meter'|'div.meter.meter-good'} [selector] @returns {HTMLElement} */
export const createMeter = (label, selector = 'span.meter') =>
  h(selector, { role: 'progressbar', 'aria-label': label, 'aria-valuemin': 0, 'aria-valuemax': 100 }, h('span'));

/** @param {HTMLElement} meter @param {number|null} part   0..1; null: not known */
export function setMeter(meter, part) {
  meter.classList.toggle('meter-waiting', part === null);
  meter.style.setProperty('--part', `${(part ?? 0) * 100}%`);
  setAttribute(meter, 'aria-valuenow', part === null ? null : Math.round(part * 100));
}
