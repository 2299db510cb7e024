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
const REACH = 7;
/** A shorter drag is a click, CSS px. */
const CLICK = 3;

/**
 * @param {App} app
 * @param {HTMLElement} element   the picture
 * @param {() => Size} screen     its size, CSS px
 * @param {(x: number, y: number) => void} menu   opens the menu of the selected track; CSS px
 * @param {AbortSignal} signal
 */
export function listenToPointer(app, element, screen, menu, signal) {
  /** @type {null|{kind: 'pan'|'change'|'draw', x: number, y: number, moved: boolean, view: import('../../model/geometry.js').Viewport, frame: number, box: Box, key: string, handle: Handle, correct: boolean, under: string[]}} */
  let drag = null;

  const review = () => app.store.get().review;
  const picture = () => sizeOf(review()?.video);

  /** @param {MouseEvent} event @returns {[number, number]} CSS px within the element */
  const at = (event) => {
    const place = element.getBoundingClientRect();
    return [event.clientX - place.left, event.clientY - place.top];
  };

  /** Tracks under a point, the smallest first. @param {number} x @param {number} y picture px */
  const under = (x, y) => {
    const now = review();
    if (!now || now.shown !== now.frame) return [];
    const slack = 3 / now.viewport.zoom;
    const wide = 3 / scaleX(now.viewport);
    return shownTracks(now)
      .filter(({ box }) => contains([box[0] - wide, box[1] - slack, box[2] + wide, box[3] + slack], x, y))
      .sort((a, b) => area(a.box) - area(b.box));
  };

  element.addEventListener(
    'wheel',
    (event) => {
      const now = review();
      if (!now || now.viewport.zoom === 0) return;
      event.preventDefault();
      const [x, y] = at(event);
      const unit = event.deltaMode === 1 ? 24 : 1;
      if (event.shiftKey && !event.ctrlKey) {
        const { viewport } = now;
        const by = (event.deltaX || event.deltaY) * unit;
        app.store.dispatch(setViewport, clampView({ ...viewport, x: viewport.x + by / scaleX(viewport) }, picture()));
        return;
      }
      const factor = Math.exp(-event.deltaY * unit * 0.0022);
      app.store.dispatch((state) =>
        state.review ? setViewport(state, zoomAt(state.review.viewport, screen(), picture(), factor, x, y)) : state,
      );
    },
    { signal, passive: false },
  );

  element.addEventListener(
    'pointerdown',
    (event) => {
      const now = review();
      if (!now || now.viewport.zoom === 0 || drag) return;
      const [sx, sy] = at(event);
      const [x, y] = toPicture(now.viewport, screen(), sx, sy);
      const base = {
        x: sx,
        y: sy,
        moved: false,
        view: now.viewport,
        frame: now.frame,
        box: /** @type {Box} */ ([x, y, x, y]),
        key: '',
        handle: /** @type {Handle} */ ('move'),
        correct: event.shiftKey,
        under: /** @type {string[]} */ ([]),
      };
      element.setPointerCapture(event.pointerId);
      if (event.button === 1 || event.button === 2) {
        drag = { ...base, kind: 'pan', key: event.button === 2 ? 'menu' : '', under: under(x, y).map(({ key }) => key) };
        event.preventDefault();
        return;
      }
      if (event.button !== 0) return;
      element.focus({ preventScroll: true });
      if (now.mode === 'draw') {
        app.store.dispatch(setPlaying, false);
        drag = { ...base, kind: 'draw', key: now.selected ?? '' };
        return;
      }
      const found = under(x, y);
      if (modeOf(now).onTrackClick) {
        if (found.length) app.store.dispatch(applyTrackClick, found[0].key);
        return;
      }
      const chosen = now.selected ? shownTracks(now).find(({ key }) => key === now.selected) : undefined;
      const handle = chosen && now.shown === now.frame ? handleAt(chosen.box, x, y, REACH / now.viewport.zoom, now.viewport.stretch) : null;
      const keys = found.map(({ key }) => key);
      if (chosen && handle && (handle !== 'move' || keys.includes(chosen.key))) {
        app.store.dispatch(setPlaying, false);
        drag = { ...base, kind: 'change', box: chosen.box, key: chosen.key, handle, under: keys };
      } else if (found.length) {
        // stop playing: a dragged box must keep its frame
        app.store.dispatch((state) => select(setPlaying(state, false), found[0].key));
        drag = { ...base, kind: 'change', box: found[0].box, key: found[0].key, handle: 'move', under: [] };
      } else {
        drag = { ...base, kind: 'pan', key: 'empty' };
      }
    },
    { signal },
  );

  element.addEventListener(
    'pointermove',
    (event) => {
      const now = review();
      if (!now) return;
      const [sx, sy] = at(event);
      if (!drag) {
        const point = toPicture(now.viewport, screen(), sx, sy);
        setCursor(element, now, point);
        if (now.fewLabels) app.store.dispatch(hover, under(...point)[0]?.key ?? null);
        return;
      }
      if (!drag.moved && Math.hypot(sx - drag.x, sy - drag.y) < CLICK) return;
      drag.moved = true;
      const { view } = drag;
      if (drag.kind === 'pan') {
        const moved = clampView({ ...view, x: view.x - (sx - drag.x) / scaleX(view), y: view.y - (sy - drag.y) / view.zoom }, picture());
        app.store.dispatch(setViewport, moved);
        return;
      }
      const [x, y] = toPicture(now.viewport, screen(), sx, sy);
      const [x0, y0] = toPicture(view, screen(), drag.x, drag.y);
      const { kind, key, handle, box: start } = drag;
      const box = kind === 'draw' ? orderCorners([start[0], start[1], x, y]) : dragHandle(start, handle, x - x0, y - y0);
      app.store.dispatch(setDrag, { box: normalizeBox(box, picture()), key });
    },
    { signal },
  );

  element.addEventListener('pointerleave', () => app.store.dispatch(hover, null), { signal });

  /** @param {boolean} keep */
  const end = (keep) => {
    const now = review();
    const ended = drag;
    drag = null;
    if (!ended || !now) return;
    const box = now.drag?.box ?? null;
    if (now.drag) app.store.dispatch(setDrag, null);
    if (!keep || (ended.kind !== 'pan' && now.frame !== ended.frame)) return; // a box belongs to the frame in which its drag began
    if (ended.kind === 'draw') {
      if (box && box[2] - box[0] >= 3 && box[3] - box[1] >= 3) handleDrawnBox(app, box, ended.correct);
    } else if (ended.kind === 'change') {
      if (ended.moved && box) putBox(app, ended.key, ended.frame, box);
      else if (!ended.moved && ended.under.length > 1) {
        // another click cycles through boxes on top of each other
        const next = ended.under[(ended.under.indexOf(ended.key) + 1) % ended.under.length];
        app.store.dispatch(select, next);
      }
    } else if (!ended.moved && ended.key === 'menu') {
      openMenu(ended);
    } else if (!ended.moved && ended.key === 'empty') {
      const sign = truthAt(now, ...toPicture(now.viewport, screen(), ended.x, ended.y));
      app.store.dispatch((state) => (sign === null ? select(state, null) : selectTruth(state, sign)));
    }
  };
  /** Open the menu of the box under the pointer; of several boxes, the selected one. @param {{x: number, y: number, under: string[]}} place */
  function openMenu({ x, y, under: keys }) {
    const now = review();
    if (!now || keys.length === 0 || !modeOf(now).changesBoxes) return;
    const key = now.selected && keys.includes(now.selected) ? now.selected : keys[0];
    app.store.dispatch((state) => select(setPlaying(state, false), key));
    menu(x, y);
  }
  element.addEventListener('pointerup', () => end(true), { signal });
  element.addEventListener('pointercancel', () => end(false), { signal });
  element.addEventListener('contextmenu', (event) => event.preventDefault(), { signal });
  document.addEventListener(
    'keydown',
    (event) => {
      if (!drag || (event.key !== 'Escape' && drag.kind === 'pan')) return;
      event.preventDefault();
      // a dragged box keeps its frame: no key may step, play or undo meanwhile
      event.stopImmediatePropagation();
      if (event.key === 'Escape') end(false);
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

/**
 * @param {HTMLElement} element
 * @param {import('../../state-types.js').ReviewState} review
 * @param {[number, number]} point
 */
function setCursor(element, review, [x, y]) {
  const { cursor: everywhere, changesBoxes } = modeOf(review);
  let cursor = everywhere ?? 'default';
  if (everywhere === null && review.shown === review.frame) {
    const tracks = shownTracks(review);
    const chosen = changesBoxes ? tracks.find(({ key }) => key === review.selected) : undefined;
    const handle = chosen ? handleAt(chosen.box, x, y, REACH / review.viewport.zoom, review.viewport.stretch) : null;
    cursor = handle ? CURSORS[handle] : tracks.some(({ box }) => contains(box, x, y)) ? 'pointer' : 'default';
  }
  if (element.style.cursor !== cursor) element.style.cursor = cursor;
}
