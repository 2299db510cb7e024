// @ts-check
/** The tau line over L_positive: a slider for the pointer and the keyboard. */

import { logPosition, valueAtLogPosition } from '../../model/gate_lane.js';
import { shortNumber } from '../../model/describe_events.js';
import { h, setAttribute, setText } from '../dom.js';

/** @param {(tau: number|null) => void} onChange   null: the run's own */
export function createTauSlider(onChange) {
  const grip = h('span.tau-grip');
  const element = h(
    'div.tau-slider',
    {
      role: 'slider',
      tabindex: '0',
      'aria-label': 'tau, the threshold of the gate',
      'aria-orientation': 'vertical',
      'aria-valuenow': '1', // until a lane is loaded
      title: 'Drag: which verdicts would flip. Double-click or Home: the run’s own tau',
    },
    grip,
  );
  /** @type {{low: number, high: number}} */ let domain = { low: 1, high: 100 };
  let tau = 1;
  let dragged = false;
  /** The value to restore if the drag is cancelled. @type {number|null} */ let tauBeforeDrag = null;
  /** @type {number|null} */ let pointerId = null;
  let top = 0;
  let height = 1;

  element.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    event.preventDefault();
    event.stopPropagation();
    element.focus();
    element.setPointerCapture(event.pointerId);
    pointerId = event.pointerId;
    tauBeforeDrag = dragged ? tau : null;
  });
  element.addEventListener('lostpointercapture', () => {
    pointerId = null;
  });
  element.addEventListener('pointermove', (event) => {
    if (!element.hasPointerCapture(event.pointerId) || element.parentElement === null) return;
    const y = event.clientY - element.parentElement.getBoundingClientRect().top;
    onChange(valueAtLogPosition(1 - (y - top) / height, domain));
  });
  element.addEventListener('dblclick', () => onChange(null));
  element.addEventListener('keydown', (event) => {
    if (event.key === 'Escape' && pointerId !== null) {
      event.preventDefault();
      event.stopPropagation();
      element.releasePointerCapture(pointerId);
      onChange(tauBeforeDrag);
      return;
    }
    /** @type {Record<string, number>} */
    const factors = { ArrowUp: 1.02, ArrowRight: 1.02, ArrowDown: 1 / 1.02, ArrowLeft: 1 / 1.02, PageUp: 1.2, PageDown: 1 / 1.2 };
    const factor = factors[event.key];
    if ((factor === undefined && event.key !== 'Home') || event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    if (event.key === 'Home') onChange(null);
    else {
      // The next key may come before the page is painted, and continues from here.
      tau = Number(Math.min(domain.high, Math.max(domain.low, tau * factor)).toPrecision(3));
      onChange(tau);
    }
  });

  return {
    element,
    /**
     * @param {{tau: number, domain: {low: number, high: number}, top: number, height: number, dragged: boolean,
     *   flips: {total: number, verdicts: number}}} view   top, height: px of the axis in the parent
     */
    update(view) {
      ({ tau, domain, top, height, dragged } = view);
      element.style.setProperty('transform', `translateY(${Math.round(top + height * (1 - logPosition(tau, domain)))}px)`);
      setAttribute(element, 'data-dragged', view.dragged);
      setAttribute(element, 'aria-valuenow', tau);
      setAttribute(element, 'aria-valuemin', domain.low);
      setAttribute(element, 'aria-valuemax', domain.high);
      setAttribute(element, 'aria-valuetext', `tau ${shortNumber(tau)}, ${view.flips.total} of ${view.flips.verdicts} verdicts flip`);
      setText(grip, `tau ${shortNumber(tau)}`);
    },
  };
}
