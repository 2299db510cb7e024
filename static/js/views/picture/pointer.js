// @ts-check
/**
 * The pointer on the picture: zoom, pan, select, move, resize, draw. A drag is one command, made when it ends; Escape
 * cancels it.
 *
 * @typedef {import('../../page-types.js').App} App
 * @typedef {import('../../types.js').Box} Box
 * @typedef {import('../../model/geometry.js').Handle} Handle
 * @typedef {import('../../model/geometry.js').Size} Size
 */
import { truthAt } from '../../review/chosen_truth.js';
import {
  scaleX,
  area,
  clampView,
  contains,
  dragHandle,
  handleAt,
  orderCorners,
  normalizeBox,
  sizeOf,
  toPicture,
  zoomAt,
} from '../../model/geometry.js';
import { modeOf } from '../../modes/index.js';
import { handleDrawnBox, putBox } from '../../operations/place_box.js';
import { shownTracks } from '../../review/shown_tracks.js';
import { hover, select, selectTruth, setDrag, setPlaying, setViewport, applyTrackClick } from '../../store/actions/review.js';

/** Maximum distance of the pointer to a handle, CSS px. */
const HANDLE_RADIUS_PX = 7;
/** A shorter drag is a click, CSS px. */
const MAX_CLICK_MOVE_PX = 3;

/**
 * @param {App} app
 * @param {HTMLElement} element   the picture
 * @param {() => Size} screen     its size, CSS px
 * @param {(x: number, y: number) => void} menu   opens the menu of the selected track; CSS px
 * @param {AbortSignal} signal
 */
export function listenToPointer(app, element, screen, menu, signal) {
  /** @type {null|{kind: 'pan'|'change'|'draw', x: number, y: number, moved: boolean, view: import('../../model/geometry.js').Viewport, frame: number, box: Box, key: string, handle: Handle, correct: boolean, tracksUnder: string[]}} */
  let drag = null;

  const getReview = () => app.store.get().review;
  const picture = () => sizeOf(getReview()?.video);

  /** @param {MouseEvent} event @returns {[number, number]} CSS px within the element */
  const pointerPosition = (event) => {
    const bounds = element.getBoundingClientRect();
    return [event.clientX - bounds.left, event.clientY - bounds.top];
  };

  /** Tracks under a point, the smallest first. @param {number} x @param {number} y picture px */
  const tracksAt = (x, y) => {
    const review = getReview();
    if (!review || review.shown !== review.frame) return [];
    const marginY = 3 / review.viewport.zoom;
    const marginX = 3 / scaleX(review.viewport);
    return shownTracks(review)
      .filter(({ box }) => contains([box[0] - marginX, box[1] - marginY, box[2] + marginX, box[3] + marginY], x, y))
      .sort((a, b) => area(a.box) - area(b.box));
  };

  element.addEventListener(
    'wheel',
    (event) => {
      const review = getReview();
      if (!review || review.viewport.zoom === 0) return;
      event.preventDefault();
      const [x, y] = pointerPosition(event);
      const unit = event.deltaMode === 1 ? 24 : 1;
      if (event.shiftKey && !event.ctrlKey) {
        const { viewport } = review;
        const by = (event.deltaX || event.deltaY) * unit;
        app.store.dispatch(setViewport, clampView({ ...viewport, x: viewport.x + by / scaleX(viewport) }, picture()));
        return;
      }
      const factor = Math.exp(-event.deltaY * unit * 0.0022);
      app.store.dispatch((state) =>
        state.review ? setViewport(state, zoomAt(state.review.viewport, screen(), picture(), factor, x, y)) : state,
      );
    },
    { passive: false },
  );

  element.addEventListener('pointerdown', (event) => {
    const review = getReview();
    if (!review || review.viewport.zoom === 0 || drag) return;
    const [sx, sy] = pointerPosition(event);
    const [x, y] = toPicture(review.viewport, screen(), sx, sy);
    const start = {
      x: sx,
      y: sy,
      moved: false,
      view: review.viewport,
      frame: review.frame,
      box: /** @type {Box} */ ([x, y, x, y]),
      key: '',
      handle: /** @type {Handle} */ ('move'),
      correct: event.shiftKey,
      tracksUnder: /** @type {string[]} */ ([]),
    };
    element.setPointerCapture(event.pointerId);
    if (event.button === 1 || event.button === 2) {
      drag = { ...start, kind: 'pan', key: event.button === 2 ? 'menu' : '', tracksUnder: tracksAt(x, y).map(({ key }) => key) };
      event.preventDefault();
      return;
    }
    if (event.button !== 0) return;
    element.focus({ preventScroll: true });
    if (review.mode === 'draw') {
      app.store.dispatch(setPlaying, false);
      drag = { ...start, kind: 'draw', key: review.selected ?? '' };
      return;
    }
    const found = tracksAt(x, y);
    if (modeOf(review).onTrackClick) {
      if (found.length) app.store.dispatch(applyTrackClick, found[0].key);
      return;
    }
    const selected = review.selected ? shownTracks(review).find(({ key }) => key === review.selected) : undefined;
    const handle =
      selected && review.shown === review.frame
        ? handleAt(selected.box, x, y, HANDLE_RADIUS_PX / review.viewport.zoom, review.viewport.stretch)
        : null;
    const keys = found.map(({ key }) => key);
    if (selected && handle && (handle !== 'move' || keys.includes(selected.key))) {
      app.store.dispatch(setPlaying, false);
      drag = { ...start, kind: 'change', box: selected.box, key: selected.key, handle, tracksUnder: keys };
    } else if (found.length) {
      // stop playing: a dragged box must keep its frame
      app.store.dispatch((state) => select(setPlaying(state, false), found[0].key));
      drag = { ...start, kind: 'change', box: found[0].box, key: found[0].key, handle: 'move', tracksUnder: [] };
    } else {
      drag = { ...start, kind: 'pan', key: 'empty' };
    }
  });

  element.addEventListener('pointermove', (event) => {
    const review = getReview();
    if (!review) return;
    const [sx, sy] = pointerPosition(event);
    if (!drag) {
      const point = toPicture(review.viewport, screen(), sx, sy);
      setCursor(element, review, point);
      if (review.fewLabels) app.store.dispatch(hover, tracksAt(...point)[0]?.key ?? null);
      return;
    }
    if (!drag.moved && Math.hypot(sx - drag.x, sy - drag.y) < MAX_CLICK_MOVE_PX) return;
    drag.moved = true;
    const { view } = drag;
    if (drag.kind === 'pan') {
      const moved = clampView({ ...view, x: view.x - (sx - drag.x) / scaleX(view), y: view.y - (sy - drag.y) / view.zoom }, picture());
      app.store.dispatch(setViewport, moved);
      return;
    }
    const [x, y] = toPicture(review.viewport, screen(), sx, sy);
    const [x0, y0] = toPicture(view, screen(), drag.x, drag.y);
    const { kind, key, handle, box: startBox } = drag;
    const box = kind === 'draw' ? orderCorners([startBox[0], startBox[1], x, y]) : dragHandle(startBox, handle, x - x0, y - y0);
    app.store.dispatch(setDrag, { box: normalizeBox(box, picture()), key });
  });

  element.addEventListener('pointerleave', () => app.store.dispatch(hover, null));

  /** @param {boolean} apply */
  const endDrag = (apply) => {
    const review = getReview();
    const finished = drag;
    drag = null;
    if (!finished || !review) return;
    const box = review.drag?.box ?? null;
    if (review.drag) app.store.dispatch(setDrag, null);
    if (!apply || (finished.kind !== 'pan' && review.frame !== finished.frame)) return; // a box belongs to the frame in which its drag began
    if (finished.kind === 'draw') {
      if (box && box[2] - box[0] >= 3 && box[3] - box[1] >= 3) handleDrawnBox(app, box, finished.correct);
    } else if (finished.kind === 'change') {
      if (finished.moved && box) putBox(app, finished.key, finished.frame, box);
      else if (!finished.moved && finished.tracksUnder.length > 1) {
        // another click cycles through boxes on top of each other
        const next = finished.tracksUnder[(finished.tracksUnder.indexOf(finished.key) + 1) % finished.tracksUnder.length];
        app.store.dispatch(select, next);
      }
    } else if (!finished.moved && finished.key === 'menu') {
      openMenu(finished);
    } else if (!finished.moved && finished.key === 'empty') {
      const sign = truthAt(review, ...toPicture(review.viewport, screen(), finished.x, finished.y));
      app.store.dispatch((state) => (sign === null ? select(state, null) : selectTruth(state, sign)));
    }
  };
  /** Open the menu of the box under the pointer; of several boxes, the selected one. @param {{x: number, y: number, tracksUnder: string[]}} place */
  function openMenu({ x, y, tracksUnder }) {
    const review = getReview();
    if (!review || tracksUnder.length === 0 || !modeOf(review).changesBoxes) return;
    const key = review.selected && tracksUnder.includes(review.selected) ? review.selected : tracksUnder[0];
    app.store.dispatch((state) => select(setPlaying(state, false), key));
    menu(x, y);
  }
  element.addEventListener('pointerup', () => endDrag(true));
  element.addEventListener('pointercancel', () => endDrag(false));
  element.addEventListener('contextmenu', (event) => event.preventDefault());
  document.addEventListener(
    'keydown',
    (event) => {
      if (!drag || (event.key !== 'Escape' && drag.kind === 'pan')) return;
      event.preventDefault();
      // a dragged box keeps its frame: no key may step, play or undo meanwhile
      event.stopImmediatePropagation();
      if (event.key === 'Escape') endDrag(false);
    },
    { signal, capture: true },
  );
}

const CURSORS = {
  n: 'ns-resize',
  s: 'ns-resize',
  e: 'ew-resize',
  w: 'ew-resize',
  ne: 'nesw-resize',
  sw: 'nesw-resize',
  nw: 'nwse-resize',
  se: 'nwse-resize',
  move: 'move',
};

/** @param {HTMLElement} element @param {import('../../state-types.js').ReviewState} review @param {[number, number]} point */
function setCursor(element, review, [x, y]) {
  const { cursor: modeCursor, changesBoxes } = modeOf(review);
  let cursor = modeCursor ?? 'default';
  if (modeCursor === null && review.shown === review.frame) {
    const tracks = shownTracks(review);
    const selected = changesBoxes ? tracks.find(({ key }) => key === review.selected) : undefined;
    const handle = selected ? handleAt(selected.box, x, y, HANDLE_RADIUS_PX / review.viewport.zoom, review.viewport.stretch) : null;
    cursor = handle ? CURSORS[handle] : tracks.some(({ box }) => contains(box, x, y)) ? 'pointer' : 'default';
  }
  if (element.style.cursor !== cursor) element.style.cursor = cursor;
}
