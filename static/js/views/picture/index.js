// @ts-check
/** The picture with its layers, and a line with the present frame and track. */

import { NO_CLASS } from '../../model/documents.js';
import { scaleX, fit, sizeOf, toScreen } from '../../model/geometry.js';
import { labelName } from '../../model/labels.js';
import { trackName } from '../../model/track_name.js';
import { modeOf } from '../../modes/index.js';
import { shownTrack } from '../../review/shown_tracks.js';
import { draftOf, seek, setPlaying, setViewport } from '../../store/actions/review.js';
import { h, returnFocusToPicture, scrollFocusedIntoView, setText } from '../dom.js';
import { clock } from '../../model/format.js';
import { createLegend } from './legend.js';
import { paintLayers } from './painter.js';
import { readPenStyle } from './pen.js';
import { listenToPointer } from './pointer.js';
import { createBoxMenu } from './box_menu.js';
import { createFollowBar } from './follow_bar.js';
import { createTruthBar } from './truth_bar.js';
import { areBoxesLoaded, createKeepInView } from './keep_in_view.js';

/** @typedef {import('../../page-types.js').App} App */
/** @typedef {import('../../state-types.js').State} State */

/** @type {import('../../page-types.js').CreateView} */
export function createPicture(app) {
  const lifetime = new AbortController();
  const signal = AbortSignal.any([lifetime.signal, app.signal]);
  const pictureCanvas = h('canvas.picture-shot');
  const overlayCanvas = h('canvas.picture-layers');
  const hint = h('div.picture-hint.truncate');
  const stage = h(
    'div.picture-stage',
    {
      tabIndex: 0,
      role: 'application',
      'data-keys': 'picture',
      'aria-label': 'Picture. Tab goes through the tracks, arrows move the box, Alt and arrows resize it, Escape leaves.',
    },
    pictureCanvas,
    overlayCanvas,
    hint,
  );
  const positionText = h('span.picture-where.number');
  const frameInput = h('input.input.picture-frame.number', {
    type: 'text',
    inputmode: 'numeric',
    autocomplete: 'off',
    'aria-label': 'Frame',
    title: 'Go to a frame (G)',
    onfocus: () => frameInput.select(),
    onblur: () => setNumber(app.store.get().review?.frame ?? 0),
  });
  frameInput.addEventListener('keydown', (event) => {
    if (event.key !== 'Enter' && event.key !== 'Escape') return;
    const frame = Number(frameInput.value.replaceAll(/[\s,.]/g, ''));
    if (event.key === 'Enter' && frameInput.value.trim() && Number.isInteger(frame))
      app.store.dispatch((state) => seek(setPlaying(state, false), frame));
    event.preventDefault();
    stage.focus({ preventScroll: true });
  });
  /** @param {number} frame */
  const setNumber = (frame) => {
    if (document.activeElement !== frameInput && frameInput.value !== String(frame)) frameInput.value = String(frame);
  };
  const speed = h(
    'select.select.picture-speed',
    { 'aria-label': 'Playing speed', onchange: () => app.frames.setSpeed(Number(speed.value)) },
    ...[0.1, 0.25, 0.5, 1, 2].map((value) => h('option', { value: String(value), selected: value === 1 }, `${value}×`)),
  );
  const legend = createLegend(app);
  const followBar = createFollowBar(app);
  const menu = createBoxMenu(app, stage, () => size, signal);
  const truthBar = createTruthBar(app, () => size);
  stage.append(menu.element, truthBar.element);
  const announcement = h('div.visually-hidden', { role: 'status', 'aria-live': 'polite' });
  const footer = h('div.picture-foot', h('span.row', frameInput, positionText), speed, legend.element);
  const element = h('div.picture', stage, followBar.element, footer, announcement);
  returnFocusToPicture(element);
  scrollFocusedIntoView(footer);

  const size = { width: 0, height: 0 };
  let ratio = 1;
  /** @type {ReturnType<typeof readPenStyle>|null} */ let penStyle = null;
  /** @type {import('../../frames/cache.js').Picture|null} */ let shownPicture = null;
  /** The smoothing of the picture. @type {'low'|'high'} */
  let quality = 'high';
  /** @type {State['review']} */ let lastReview = null;
  /** @type {import('../../state-types.js').Draft|null} */ let draft = null;
  /** @type {State['labels']|null} */ let labels = null;
  /** @type {Map<number, string>} */ let names = new Map();
  let lastAnnouncement = '';
  const keepInView = createKeepInView();

  const observer = new ResizeObserver(() => {
    const stageBox = stage.getBoundingClientRect();
    ratio = globalThis.devicePixelRatio || 1;
    size.width = stageBox.width;
    size.height = stageBox.height;
    for (const canvas of [pictureCanvas, overlayCanvas]) {
      canvas.width = Math.max(1, Math.round(stageBox.width * ratio));
      canvas.height = Math.max(1, Math.round(stageBox.height * ratio));
    }
    penStyle = readPenStyle(element);
    const review = app.store.get().review;
    // a picture that filled the view keeps filling it
    if (review && (review.viewport.zoom === 0 || isFitted)) refit(review);
    lastReview = null;
    update(app.store.get());
  });
  observer.observe(stage);
  let isFitted = true;

  /** @param {NonNullable<State['review']>} review */
  function refit(review) {
    if (!size.width || !review.video.width || !review.video.height) return;
    isFitted = true;
    app.store.dispatch(setViewport, fit(sizeOf(review.video), size));
  }

  app.frames.setPainter((/** @type {import('../../frames/cache.js').Picture} */ next, /** @type {boolean} */ isPreview) => {
    shownPicture = next;
    quality = isPreview ? 'low' : 'high';
    paintShot(app.store.get().review);
    // at once, not with the next update: a picture must never appear under the boxes of the previous one
    update(app.store.get());
  });

  /** @param {State['review']} review */
  function paintShot(review) {
    const ctx = pictureCanvas.getContext('2d', { alpha: false });
    if (!ctx || !review || !size.width) return;
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.fillStyle = getComputedStyle(element).getPropertyValue('--picture-ground') || '#0b0d10';
    ctx.fillRect(0, 0, pictureCanvas.width, pictureCanvas.height);
    // a bitmap without width was released with the cache of its video
    if (!shownPicture || shownPicture.bitmap.width === 0 || review.viewport.zoom === 0) return;
    const { width, height } = sizeOf(review.video);
    const [x1, y1] = toScreen(review.viewport, size, 0, 0);
    const [x2, y2] = toScreen(review.viewport, size, width, height);
    ctx.imageSmoothingEnabled = review.viewport.zoom * ratio < 2.5;
    ctx.imageSmoothingQuality = quality;
    ctx.drawImage(shownPicture.bitmap, x1 * ratio, y1 * ratio, (x2 - x1) * ratio, (y2 - y1) * ratio);
  }

  /** @param {NonNullable<State['review']>} review */
  function paintOverlay(review) {
    const ctx = overlayCanvas.getContext('2d');
    if (!ctx || !penStyle) return;
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.clearRect(0, 0, size.width, size.height);
    // the layers belong to the cursor's frame: draw them only while its picture is on screen
    if (review.shown !== review.frame || review.viewport.zoom === 0) return;
    const counts = paintLayers(ctx, draft ? { ...review, drag: draft } : review, review.viewport, size, penStyle, (id) =>
      id === null ? 'unlabelled' : (names.get(id) ?? String(id)),
    );
    legend.update(review, counts);
  }

  /** @param {NonNullable<State['review']>} review */
  function describe(review) {
    const frames = review.timebase?.frames ?? review.video.frames ?? 0;
    const seconds = review.timebase?.secondsAt(review.frame) ?? 0;
    const corrupt = review.timebase?.isCorrupt(review.frame) ? ' · damaged' : '';
    setNumber(review.frame);
    setText(positionText, `of ${Math.max(0, frames - 1)} · ${clock(seconds)}${corrupt}`);
    stage.dataset.frame = String(review.frame);
    stage.dataset.shown = String(review.shown);
    const shown = review.selected ? shownTrack(review, review.selected) : null;
    const isMissing = review.selected && !shown && areBoxesLoaded(review);
    const text = modeOf(review).hint(review, Boolean(isMissing));
    if (review.playing) {
      const { frames, late } = app.frames.tally();
      setText(hint, frames > 20 && late > 0.2 * frames ? 'Playing slower than real time: the pictures arrive late' : '');
      return;
    }
    setText(hint, text);
    if (hint.title !== text) hint.title = text;
    const announcementText = `Frame ${review.frame}${review.selected ? `, track ${trackName(review.selected, review.docs[review.selected])}${shown ? `, ${shown.word ?? (shown.class_id === null ? 'unlabelled' : names.get(shown.class_id))}` : isMissing ? ', no box here' : ''}` : ''}`;
    if (announcementText !== lastAnnouncement) setText(announcement, (lastAnnouncement = announcementText));
  }

  /** @param {State} state */
  function update(state) {
    const { review } = state;
    followBar.update(state);
    truthBar.update(state);
    if (state.labels !== labels) {
      labels = state.labels;
      names = new Map([...state.labels.map(({ id }) => id), NO_CLASS].map((id) => [id, labelName(state.labels, id)]));
      lastReview = null;
    }
    if (draft !== draftOf(state)) {
      draft = draftOf(state);
      lastReview = null;
    }
    if (!review || review === lastReview) return;
    const before = lastReview;
    lastReview = review;
    menu.update(review);
    if (review.viewport.zoom === 0) {
      refit(review);
      return;
    }
    const view = keepInView.nextViewport(review, size, isFitted);
    if (view !== review.viewport) app.store.dispatch(setViewport, view);
    if (before && before.viewport !== review.viewport) {
      const fittedView = fit(sizeOf(review.video), size);
      isFitted = Math.abs(fittedView.zoom - review.viewport.zoom) < 1e-6;
    }
    if (before?.viewport !== review.viewport) {
      app.frames.setWidth(
        Math.ceil((review.video.width ?? 1280) * Math.min(1, Math.max(review.viewport.zoom, scaleX(review.viewport)) * ratio)),
      );
      paintShot(review);
    }
    paintOverlay(review);
    describe(review);
  }

  listenToPointer(app, stage, () => size, menu.open, signal);
  return {
    element,
    update,
    destroy() {
      lifetime.abort();
      observer.disconnect();
      app.frames.setPainter(() => {});
    },
  };
}
