// @ts-check
/** The end of the selected track's bar. The picture follows its drag, and the track ends where it is released. */

import { h } from '../dom.js';

/** Minimum move of the pointer per frame, px, because in a long drive one pixel is many frames. */
const LEAST = 3;

/**
 * @typedef {object} EndBar
 * @property {string} key
 * @property {number} first   frame
 * @property {number} last    frame
 * @property {number} x       end of the bar in the plot, px
 * @property {number} y       its upper edge, px
 * @property {number} height  px
 * @property {number} scale   px per frame
 */

/**
 * @param {{look: (frame: number) => void, end: (key: string, last: number) => void}} hooks   `look`: show a frame;
 *   `end`: end the track after a frame
 * @param {AbortSignal} signal
 */
export function createEndHandle({ look, end }, signal) {
  const element = h('div.lanes-end', {
    hidden: true,
    'aria-hidden': 'true',
    title: 'Drag to end the track earlier; the picture shows its last frame (Alt+Del ends it at the cursor)',
  });
  /** @type {EndBar|null} */ let bar = null;
  /** The current drag: the bar and pointer at its start, and the last frame now. @type {{bar: EndBar, from: number, last: number}|null} */
  let held = null;

  const place = () => {
    const shown = held?.bar ?? bar;
    element.hidden = shown === null;
    if (shown === null) return;
    const x = shown.x - (held ? (shown.last - held.last) * shown.scale : 0);
    element.style.setProperty('transform', `translate(${Math.round(x)}px, ${Math.round(shown.y)}px)`);
    element.style.setProperty('height', `${shown.height}px`);
  };
  const letGo = () => {
    held = null;
    place();
  };

  element.addEventListener(
    'pointerdown',
    (event) => {
      if (event.button !== 0 || bar === null) return;
      event.preventDefault();
      event.stopPropagation();
      element.setPointerCapture(event.pointerId);
      held = { bar, from: event.clientX, last: bar.last };
      look(bar.last);
    },
    { signal },
  );
  element.addEventListener(
    'pointermove',
    (event) => {
      event.stopPropagation(); // so that the lanes do not seek to the frame under the pointer
      if (held === null) return;
      const { first, last, scale } = held.bar;
      const frame = Math.min(last, Math.max(first, last + Math.round((event.clientX - held.from) / Math.max(LEAST, scale))));
      if (frame === held.last) return;
      held.last = frame;
      place();
      look(frame);
    },
    { signal },
  );
  element.addEventListener(
    'pointerup',
    (event) => {
      event.stopPropagation();
      const done = held;
      letGo();
      if (done !== null && done.last < done.bar.last) end(done.bar.key, done.last);
    },
    { signal },
  );
  element.addEventListener('lostpointercapture', letGo, { signal });
  document.addEventListener(
    'keydown',
    (event) => {
      if (held === null || event.key !== 'Escape') return;
      event.preventDefault();
      event.stopPropagation();
      look(held.bar.last);
      letGo();
    },
    { signal, capture: true },
  );

  return {
    element,
    /** @param {EndBar|null} next   null: no bar is selected, or its end is not visible */
    update(next) {
      if (held !== null && next?.key !== held.bar.key) held = null;
      bar = next;
      place();
    },
  };
}
