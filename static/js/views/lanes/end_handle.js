// @ts-check
/** The end of the selected track's bar. The picture follows its drag, and the track ends where it is released. */

import { h } from '../dom.js';
import { leaveField } from './gestures.js';

/** Minimum move of the pointer per frame, px, because in a long drive one pixel is many frames. */
const MIN_PX_PER_FRAME = 3;

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
 * @param {{showFrame: (frame: number) => void, endTrack: (key: string, last: number) => void}} hooks   `endTrack`: end
 *   the track after a frame
 * @param {AbortSignal} signal
 */
export function createEndHandle({ showFrame, endTrack }, signal) {
  const element = h('div.lanes-end', {
    hidden: true,
    'aria-hidden': 'true',
    title: 'Drag to end the track earlier; the picture shows its last frame (Alt+Del ends it at the cursor)',
  });
  /** @type {EndBar|null} */ let bar = null;
  /** The current drag: the bar and pointer at its start, and the last frame now. @type {{bar: EndBar, from: number, last: number}|null} */
  let drag = null;

  const position = () => {
    const shown = drag?.bar ?? bar;
    element.hidden = shown === null;
    if (shown === null) return;
    const x = shown.x - (drag ? (shown.last - drag.last) * shown.scale : 0);
    element.style.setProperty('transform', `translate(${Math.round(x)}px, ${Math.round(shown.y)}px)`);
    element.style.setProperty('height', `${shown.height}px`);
  };
  const endDrag = () => {
    drag = null;
    position();
  };

  element.addEventListener('pointerdown', (event) => {
    if (event.button !== 0 || bar === null) return;
    event.preventDefault();
    event.stopPropagation();
    leaveField();
    element.setPointerCapture(event.pointerId);
    drag = { bar, from: event.clientX, last: bar.last };
    showFrame(bar.last);
  });
  element.addEventListener('pointermove', (event) => {
    event.stopPropagation(); // so that the lanes do not seek to the frame under the pointer
    if (drag === null) return;
    const { first, last, scale } = drag.bar;
    const frame = Math.min(last, Math.max(first, last + Math.round((event.clientX - drag.from) / Math.max(MIN_PX_PER_FRAME, scale))));
    if (frame === drag.last) return;
    drag.last = frame;
    position();
    showFrame(frame);
  });
  element.addEventListener('pointerup', (event) => {
    event.stopPropagation();
    const finishedDrag = drag;
    endDrag();
    if (finishedDrag !== null && finishedDrag.last < finishedDrag.bar.last) endTrack(finishedDrag.bar.key, finishedDrag.last);
  });
  element.addEventListener('lostpointercapture', endDrag);
  document.addEventListener(
    'keydown',
    (event) => {
      if (drag === null || event.key !== 'Escape') return;
      event.preventDefault();
      event.stopPropagation();
      showFrame(drag.bar.last);
      endDrag();
    },
    { signal, capture: true },
  );

  return {
    element,
    /** @param {EndBar|null} next   null: no bar is selected, or its end is not visible */
    update(next) {
      if (drag !== null && next?.key !== drag.bar.key) drag = null;
      bar = next;
      position();
    },
  };
}
