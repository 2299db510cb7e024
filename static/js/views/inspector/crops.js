// @ts-check
/** The strip of a track's crops. Only visible crops are loaded; the current frame's crop is marked. */

import { lastIndexAt } from '../../model/detail_columns.js';
import { engineName, labelFor } from '../../model/labels.js';
import { shortNumber } from '../../model/describe_events.js';
import { isLoaded } from '../../model/track_lane.js';
import { seek } from '../app.js';
import { h, setAttribute, setText } from '../dom.js';
import { figure, percent, plural } from '../../model/format.js';
import { pictureThatMayMiss } from '../pictures.js';

/** @param {import('../app.js').ViewApp} app @param {AbortSignal} signal */
export function createCrops(app, signal) {
  const cells = h('div.crops-cells');
  const scroller = h('div.crops-scroll', { tabindex: '0', role: 'group', 'aria-label': 'Crops by frame' }, cells);
  const title = h('h3', 'Crops');
  const total = h('span.small.muted');
  /** @type {Map<number, HTMLButtonElement>} */ const shown = new Map();
  /** @type {import('./index.js').Inspected|null} */ let now = null;
  /** @type {Int32Array} */ let frames = new Int32Array(0);
  /** @type {readonly import('../../types.js').Label[]} */ let labels = [];
  /** @type {import('../../model/track_entries.js').TrackEntry['spans']} */ let visible = [];
  let current = -1;
  let scheduled = false;

  /** Whether the track shows something in a frame, that is, is not marked as outside. @param {number} frame */
  const isShown = (frame) => visible.some(([first, last]) => first <= frame && frame <= last);
  /** @param {HTMLElement} cell @param {number} frame */
  const mark = (cell, frame) => cell.classList.toggle('crop-hidden', !isShown(frame));

  const later = () => {
    if (scheduled) return;
    scheduled = true;
    requestAnimationFrame(draw);
  };
  scroller.addEventListener('scroll', later, { signal, passive: true });
  const observer = new ResizeObserver(later);
  observer.observe(scroller);
  signal.addEventListener('abort', () => observer.disconnect());

  const pitch = () => (Number.parseFloat(getComputedStyle(scroller).getPropertyValue('--u')) || 4) * 18;

  function draw() {
    scheduled = false;
    const found = now?.found;
    const run = now?.review.run;
    if (!found || !run) return;
    const step = pitch();
    cells.style.setProperty('width', `${frames.length * step}px`);
    const first = Math.max(0, Math.floor(scroller.scrollLeft / step) - 2);
    const last = Math.min(frames.length, Math.ceil((scroller.scrollLeft + scroller.clientWidth) / step) + 2);
    for (const [i, cell] of shown) {
      if (i >= first && i < last) continue;
      cell.remove();
      shown.delete(i);
    }
    for (let i = first; i < last; i += 1) {
      let cell = shown.get(i);
      if (!cell) {
        cell = createCell(found.lane, i, labels, app.api.cropUrl(run.id, found.track[i], frames[i], 96));
        cell.style.setProperty('transform', `translateX(${i * step}px)`);
        cell.addEventListener('click', () => seek(app, frames[i]));
        mark(cell, frames[i]);
        shown.set(i, cell);
        cells.append(cell);
      }
      setAttribute(cell, 'aria-current', i === current ? 'true' : null);
    }
  }

  return {
    element: h('div.inspector-section', h('div.row', title, total), scroller),
    /** @param {import('./index.js').Inspected} inspected */
    update(inspected) {
      const { lane, review } = inspected;
      const turned = lane !== now?.lane || labels !== inspected.state.labels;
      labels = inspected.state.labels;
      now = inspected;
      scroller.hidden = lane === null;
      if (lane === null) {
        setText(
          total,
          isLoaded(inspected.entry.key, review.docs[inspected.entry.key], review.laneOf)
            ? 'none: the engine has no frame of this track'
            : 'loading…',
        );
        return;
      }
      if (turned) {
        for (const cell of shown.values()) cell.remove();
        shown.clear();
        frames = Int32Array.from(lane.frame);
      }
      const { spans: runs } = inspected.entry;
      if (turned || runs !== visible) {
        visible = runs;
        for (const [i, cell] of shown) mark(cell, frames[i]);
        const hidden = frames.length - frames.filter(isShown).length;
        setText(total, `${plural(frames.length, 'frame')}${hidden ? `, ${hidden} outside` : ''}`);
      }
      const at = lastIndexAt(frames, review.frame);
      const place = at >= 0 && frames[at] === review.frame ? at : -1;
      if (place === current && !turned) return;
      current = place;
      const step = pitch();
      if (place >= 0 && (place * step < scroller.scrollLeft || (place + 1) * step > scroller.scrollLeft + scroller.clientWidth)) {
        cells.style.setProperty('width', `${frames.length * step}px`);
        scroller.scrollLeft = place * step - scroller.clientWidth / 2 + step / 2;
      }
      later();
    },
  };
}

/**
 * The class of a cell is the one that was read in that frame, which P belongs to. It may differ from the track's class.
 *
 * @param {import('../../types.js').TrackLane} lane
 * @param {number} i
 * @param {readonly import('../../types.js').Label[]} labels
 * @param {string} url
 */
function createCell(lane, i, labels, url) {
  const probability = lane.top_probability[i];
  const weight = lane.weight[i];
  const label = labelFor(labels, lane.top[i]);
  return h(
    'button.crop',
    {
      title: `Frame ${lane.frame[i]}: read as ${engineName(labels, lane.top[i], lane.top_word?.[i])} with P(c|x) = ${percent(probability)}, weight w = ${shortNumber(weight)}`,
    },
    pictureThatMayMiss({ src: url, alt: `Crop in frame ${lane.frame[i]}`, decoding: 'async' }),
    h('span.crop-frame', lane.frame[i]),
    h('span.crop-value', weight === null ? 'no vote' : `w ${figure(weight, 2)}`),
    h(
      'span.crop-value',
      label?.picture && pictureThatMayMiss({ class: 'crop-read', src: label.picture, alt: label.name }),
      `P ${probability === null ? '–' : probability.toFixed(2)}`,
    ),
  );
}
