// @ts-check
/** The strip of a track's crops. Only visible crops are loaded; the current frame's crop is marked. */

import { lastIndexAt } from '../../model/detail_columns.js';
import { engineName, labelFor } from '../../model/labels.js';
import { shortNumber } from '../../model/describe_events.js';
import { seek } from '../../store/actions/review.js';
import { h, setAttribute, setText } from '../dom.js';
import { figure, percent, plural } from '../../model/format.js';
import { imageWithPlaceholder } from '../images.js';

/** @param {import('../../page-types.js').ViewApp} app @param {AbortSignal} signal */
export function createCrops(app, signal) {
  const cells = h('div.crops-cells');
  const scroller = h('div.crops-scroll', { tabindex: '0', role: 'group', 'aria-label': 'Crops by frame' }, cells);
  const title = h('h3', 'Crops');
  const total = h('span.small.muted');
  /** @type {Map<number, HTMLButtonElement>} */ const cellsByIndex = new Map();
  /** @type {import('./index.js').Inspected|null} */ let current = null;
  /** @type {Int32Array} */ let frames = new Int32Array(0);
  /** @type {readonly import('../../types.js').Label[]} */ let labels = [];
  /** @type {import('../../model/track_entries.js').TrackEntry['spans']} */ let visibleRuns = [];
  let currentIndex = -1;
  let scheduled = false;

  /** Whether the track shows something in a frame, that is, is not marked as outside. @param {number} frame */
  const isShown = (frame) => visibleRuns.some(([first, last]) => first <= frame && frame <= last);
  /** @param {HTMLElement} cell @param {number} frame */
  const markHidden = (cell, frame) => cell.classList.toggle('crop-hidden', !isShown(frame));

  const scheduleDraw = () => {
    if (scheduled) return;
    scheduled = true;
    requestAnimationFrame(draw);
  };
  scroller.addEventListener('scroll', scheduleDraw, { signal, passive: true });
  const observer = new ResizeObserver(scheduleDraw);
  observer.observe(scroller);
  signal.addEventListener('abort', () => observer.disconnect());

  const cellWidth = () => (Number.parseFloat(getComputedStyle(scroller).getPropertyValue('--u')) || 4) * 18;

  function draw() {
    scheduled = false;
    const lane = current?.laneData;
    const run = current?.review.run;
    if (!lane || !run) return;
    const step = cellWidth();
    cells.style.setProperty('width', `${frames.length * step}px`);
    const first = Math.max(0, Math.floor(scroller.scrollLeft / step) - 2);
    const last = Math.min(frames.length, Math.ceil((scroller.scrollLeft + scroller.clientWidth) / step) + 2);
    for (const [i, cell] of cellsByIndex) {
      if (i >= first && i < last) continue;
      cell.remove();
      cellsByIndex.delete(i);
    }
    for (let i = first; i < last; i += 1) {
      let cell = cellsByIndex.get(i);
      if (!cell) {
        cell = createCell(lane.lane, i, labels, app.api.cropUrl(run.id, lane.track[i], frames[i], 96));
        cell.style.setProperty('transform', `translateX(${i * step}px)`);
        cell.addEventListener('click', () => app.store.dispatch(seek, frames[i]));
        markHidden(cell, frames[i]);
        cellsByIndex.set(i, cell);
        cells.append(cell);
      }
      setAttribute(cell, 'aria-current', i === currentIndex ? 'true' : null);
    }
  }

  return {
    element: h('div.inspector-section', h('div.row', title, total), scroller),
    /** @param {import('./index.js').Inspected} inspected */
    update(inspected) {
      const { lane, review } = inspected;
      const hasChanged = lane !== current?.lane || labels !== inspected.state.labels;
      labels = inspected.state.labels;
      current = inspected;
      scroller.hidden = lane === null;
      if (lane === null) {
        setText(total, inspected.isLoaded ? 'none: the engine has no frame of this track' : 'loading…');
        return;
      }
      if (hasChanged) {
        for (const cell of cellsByIndex.values()) cell.remove();
        cellsByIndex.clear();
        frames = Int32Array.from(lane.frame);
      }
      const { spans: runs } = inspected.entry;
      if (hasChanged || runs !== visibleRuns) {
        visibleRuns = runs;
        for (const [i, cell] of cellsByIndex) markHidden(cell, frames[i]);
        const hidden = frames.length - frames.filter(isShown).length;
        setText(total, `${plural(frames.length, 'frame')}${hidden ? `, ${hidden} outside` : ''}`);
      }
      const nearest = lastIndexAt(frames, review.frame);
      const index = nearest >= 0 && frames[nearest] === review.frame ? nearest : -1;
      if (index === currentIndex && !hasChanged) return;
      currentIndex = index;
      const step = cellWidth();
      if (index >= 0 && (index * step < scroller.scrollLeft || (index + 1) * step > scroller.scrollLeft + scroller.clientWidth)) {
        cells.style.setProperty('width', `${frames.length * step}px`);
        scroller.scrollLeft = index * step - scroller.clientWidth / 2 + step / 2;
      }
      scheduleDraw();
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
    imageWithPlaceholder({ src: url, alt: `Crop in frame ${lane.frame[i]}`, decoding: 'async' }),
    h('span.crop-frame', lane.frame[i]),
    h('span.crop-value', weight === null ? 'no vote' : `w ${figure(weight, 2)}`),
    h(
      'span.crop-value',
      label?.picture && imageWithPlaceholder({ class: 'crop-read', src: label.picture, alt: label.name }),
      `P ${probability === null ? '–' : probability.toFixed(2)}`,
    ),
  );
}
