// @ts-check
/** Pointer, wheel, keys and buttons of the lanes: they seek and change the shown range. */

import { panBy, spanAround, toFrame, zoomAround } from '../../model/time_axis.js';
import { changeLanesView, openDialog } from '../../store/actions/page.js';
import { frameCount, seek, dragTau, showSpan } from '../../store/actions/review.js';
import { attachGestures } from './gestures.js';

/** @typedef {import('../../state-types.js').ReviewState} ReviewState */
/** @typedef {{first: number, last: number}} Span */

/** The range of frames in the lanes: all frames until one is set. @param {ReviewState} review @returns {Span} */
export const shownSpan = (review) => (review.span.last > review.span.first ? review.span : { first: 0, last: frameCount(review) });

/**
 * @param {import('../../page-types.js').ViewApp} app
 * @param {import('./layout.js').LanesLayout} parts
 * @param {HTMLElement} proposalPlot                    the strip of a follow's proposals
 * @param {object} lanes
 * @param {() => number} lanes.width                    width of the plots, px
 * @param {(x: number|null) => void} lanes.hover
 * @param {(x: number, y: number) => void} lanes.pick   called after a click among the tracks
 * @param {() => Span|null} lanes.selected              first and last frame of the selected track
 */
export function listenToControls(app, parts, proposalPlot, { width, hover, pick, selected }) {
  const getReview = () => app.store.get().review;
  /** @param {(review: ReviewState, span: Span, frames: number) => Span} next */
  const changeSpan = (next) => {
    const review = getReview();
    if (review !== null) app.store.dispatch(showSpan, next(review, shownSpan(review), frameCount(review)));
  };

  /** @type {import('./gestures.js').GestureTarget} */
  const plot = {
    seek: (x) => {
      const review = getReview();
      if (review) app.store.dispatch(seek, Math.floor(toFrame(shownSpan(review), x, width())));
    },
    pan: (from, to) =>
      changeSpan((_, span, frames) => panBy(span, ((from - to) / Math.max(1, width())) * (span.last - span.first), frames)),
    zoom: (x, factor) => changeSpan((_, span, frames) => zoomAround(span, toFrame(span, x, width()), factor, frames)),
    hover,
  };
  attachGestures(parts.axisPlot, 'pan', plot);
  attachGestures(parts.detailPlot, 'seek', plot);
  attachGestures(proposalPlot, 'seek', plot);
  attachGestures(parts.tracksPlot, 'seek', { ...plot, press: pick });
  attachGestures(parts.overviewPlot, 'seek', {
    ...plot,
    hover: undefined,
    seek: (x) => {
      const frame = (x / Math.max(1, width())) * frameCount(getReview());
      app.store.dispatch(seek, Math.floor(frame));
      changeSpan((_, span, frames) => panBy(span, frame - (span.first + span.last) / 2, frames));
    },
    pan: (from, to) => changeSpan((_, span, frames) => panBy(span, ((to - from) / Math.max(1, width())) * frames, frames)),
  });

  /** @param {number} factor */
  const zoomAtCursor = (factor) =>
    changeSpan((review, span, frames) => {
      const visible = review.frame >= span.first && review.frame < span.last;
      return zoomAround(span, visible ? review.frame + 0.5 : (span.first + span.last) / 2, factor, frames);
    });
  parts.zoomIn.addEventListener('click', () => zoomAtCursor(0.5));
  parts.zoomOut.addEventListener('click', () => zoomAtCursor(2));
  parts.fit.addEventListener('click', () => changeSpan((_, __, frames) => ({ first: 0, last: frames })));
  parts.toTrack.addEventListener('click', () => {
    const track = selected();
    if (track) changeSpan((_, __, frames) => spanAround(track.first, track.last, frames));
  });
  parts.fold.addEventListener('click', () => app.store.dispatch((now) => changeLanesView(now, { folded: !now.lanesView.folded })));
  parts.chosen.addEventListener('change', () => app.store.dispatch(changeLanesView, { lane: parts.chosen.value }));
  parts.reset.addEventListener('click', () => app.store.dispatch(dragTau, null));
  parts.whatIf.addEventListener('click', () => app.store.dispatch(openDialog, { kind: 'whatif' }));
  parts.axisPlot.addEventListener('keydown', (event) => {
    /** @type {Record<string, number>} */
    const steps = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -100, PageUp: 100, Home: -1e9, End: 1e9 };
    const review = getReview();
    if (review === null || event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key === '+' || event.key === '-') zoomAtCursor(event.key === '+' ? 0.5 : 2);
    else if (steps[event.key] !== undefined) app.store.dispatch(seek, review.frame + steps[event.key]);
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
}
