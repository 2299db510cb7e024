// @ts-check
/** Pointer, wheel, keys and buttons of the lanes: they seek and change the shown range. */

import { panBy, spanAround, toFrame, zoomAround } from '../../model/time_axis.js';
import { changeLanesView } from '../../store/actions/page.js';
import { frameCount } from '../../store/actions/review.js';
import { dialog, seek, setTau, show } from '../app.js';
import { attachGestures } from './gestures.js';

/** @typedef {import('../../state-types.js').ReviewState} ReviewState */
/** @typedef {{first: number, last: number}} Span */

/** The range of frames in the lanes: all frames until one is set. @param {ReviewState} review @returns {Span} */
export const spanOf = (review) => (review.span.last > review.span.first ? review.span : { first: 0, last: frameCount(review) });

/**
 * @param {import('../app.js').ViewApp} app
 * @param {import('./frame.js').LanesFrame} parts
 * @param {HTMLElement} proposed               the strip of a follow's proposals
 * @param {object} lanes
 * @param {() => number} lanes.width           width of the plots, px
 * @param {(x: number|null) => void} lanes.hover
 * @param {(x: number, y: number) => void} lanes.pick   called after a click among the tracks
 * @param {() => Span|null} lanes.selected     first and last frame of the selected track
 * @param {AbortSignal} signal
 */
export function listenToControls(app, parts, proposed, { width, hover, pick, selected }, signal) {
  const review = () => app.store.get().review;
  /** @param {(r: ReviewState, span: Span, frames: number) => Span} next */
  const changeSpan = (next) => {
    const r = review();
    if (r !== null) show(app, next(r, spanOf(r), frameCount(r)));
  };

  /** @type {import('./gestures.js').GestureTarget} */
  const plot = {
    seek: (x) => {
      const r = review();
      if (r) seek(app, Math.floor(toFrame(spanOf(r), x, width())));
    },
    pan: (from, to) =>
      changeSpan((_, span, frames) => panBy(span, ((from - to) / Math.max(1, width())) * (span.last - span.first), frames)),
    zoom: (x, factor) => changeSpan((_, span, frames) => zoomAround(span, toFrame(span, x, width()), factor, frames)),
    hover,
  };
  attachGestures(parts.axisPlot, 'pan', plot, signal);
  attachGestures(parts.detailPlot, 'seek', plot, signal);
  attachGestures(proposed, 'seek', plot, signal);
  attachGestures(parts.tracksPlot, 'seek', { ...plot, press: pick }, signal);
  attachGestures(
    parts.overviewPlot,
    'seek',
    {
      ...plot,
      hover: undefined,
      seek: (x) => {
        const frame = (x / Math.max(1, width())) * frameCount(review());
        seek(app, Math.floor(frame));
        changeSpan((_, span, frames) => panBy(span, frame - (span.first + span.last) / 2, frames));
      },
      pan: (from, to) => changeSpan((_, span, frames) => panBy(span, ((to - from) / Math.max(1, width())) * frames, frames)),
    },
    signal,
  );

  /** @param {number} factor */
  const zoomButton = (factor) =>
    changeSpan((r, span, frames) => {
      const visible = r.frame >= span.first && r.frame < span.last;
      return zoomAround(span, visible ? r.frame + 0.5 : (span.first + span.last) / 2, factor, frames);
    });
  parts.zoomIn.addEventListener('click', () => zoomButton(0.5), { signal });
  parts.zoomOut.addEventListener('click', () => zoomButton(2), { signal });
  parts.fit.addEventListener('click', () => changeSpan((_, __, frames) => ({ first: 0, last: frames })), { signal });
  parts.toTrack.addEventListener(
    'click',
    () => {
      const track = selected();
      if (track) changeSpan((_, __, frames) => spanAround(track.first, track.last, frames));
    },
    { signal },
  );
  parts.fold.addEventListener('click', () => app.store.dispatch((now) => changeLanesView(now, { folded: !now.lanesView.folded })), {
    signal,
  });
  parts.chosen.addEventListener('change', () => app.store.dispatch(changeLanesView, { lane: parts.chosen.value }), {
    signal,
  });
  parts.reset.addEventListener('click', () => setTau(app, null), { signal });
  parts.whatIf.addEventListener('click', () => dialog(app, { kind: 'whatif' }), { signal });
  parts.axisPlot.addEventListener(
    'keydown',
    (event) => {
      /** @type {Record<string, number>} */
      const steps = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -100, PageUp: 100, Home: -1e9, End: 1e9 };
      const r = review();
      if (r === null || event.ctrlKey || event.altKey || event.metaKey) return;
      if (event.key === '+' || event.key === '-') zoomButton(event.key === '+' ? 0.5 : 2);
      else if (steps[event.key] !== undefined) seek(app, r.frame + steps[event.key]);
      else return;
      event.preventDefault();
      event.stopPropagation();
    },
    { signal },
  );
}
