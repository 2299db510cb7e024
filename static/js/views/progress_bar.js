// @ts-check
/** Progress bars. */

import { h, setAttribute } from './dom.js';

/** @param {string} label @param {'span.meter'|'span.meter.run-meter'|'div.meter.meter-good'} [selector] @returns {HTMLElement} */
export const createProgressBar = (label, selector = 'span.meter') =>
  h(selector, { role: 'progressbar', 'aria-label': label, 'aria-valuemin': 0, 'aria-valuemax': 100 }, h('span'));

/** @param {HTMLElement} bar @param {number|null} fraction   0..1; null: not known */
export function setProgress(bar, fraction) {
  bar.classList.toggle('meter-waiting', fraction === null);
  bar.style.setProperty('--part', `${(fraction ?? 0) * 100}%`);
  setAttribute(bar, 'aria-valuenow', fraction === null ? null : Math.round(fraction * 100));
}
