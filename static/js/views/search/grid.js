// @ts-check
/** The grid of crops. Only visible rows exist; keys and pointer select as in a file manager. */

import { nextIndex } from '../../model/list_keys.js';
import { idOf } from '../../model/search.js';
import { h, reconcile, setAttribute, setText } from '../dom.js';
import { icon } from '../icons.js';
import { imageWithPlaceholder, setImageSource } from '../images.js';

/** @typedef {import('../../types.js').FoundTrack} FoundTrack */

/** Width of a tile with its gap, px. */
const TILE_WIDTH_PX = 148;
const TILE_HEIGHT_PX = 178;
/** Rows kept above and below the visible ones. */
const SPARE_ROWS = 3;
/** Longer side of requested pictures, px: sharp on screens of double density. */
export const CROP_SIZE_PX = 192;
/** @type {Record<FoundTrack['state'], {text: string, icon: import('../icons.js').IconName|null}>} */
const STATES = {
  open: { text: 'Open', icon: null },
  needs_work: { text: 'Needs work', icon: 'needs_work' },
  accepted: { text: 'Accepted', icon: 'accept' },
  rejected: { text: 'False positive', icon: 'reject' },
  ignored: { text: 'Ignored', icon: 'ignore' },
};

/**
 * @param {object} setup
 * @param {(track: FoundTrack) => string} setup.picture   address of a crop
 * @param {(index: number, mode: 'only'|'toggle'|'range') => void} setup.onSelect
 * @param {(index: number) => void} setup.onMoveCursor
 * @param {(index: number) => void} setup.onOpen
 * @param {() => void} setup.onNearEnd                    called near the end
 * @param {AbortSignal} setup.signal
 */
export function createTrackGrid({ picture, onSelect, onMoveCursor, onOpen, onNearEnd, signal }) {
  const sheet = h('div.found-sheet', { role: 'presentation' });
  const element = h(
    'div.found',
    { role: 'listbox', tabIndex: 0, id: 'found', 'aria-multiselectable': 'true', 'aria-label': 'Found tracks' },
    sheet,
  );
  /** @type {readonly FoundTrack[]} */ let tracks = [];
  /** @type {ReadonlySet<string>} */ let selected = new Set();
  let cursor = 0;
  let columns = 1;
  let rows = 1;
  let scheduled = false;

  const sizes = new ResizeObserver(() => draw());
  sizes.observe(element);
  signal.addEventListener('abort', () => sizes.disconnect(), { once: true });
  element.addEventListener(
    'scroll',
    () => {
      if (scheduled) return;
      scheduled = true;
      requestAnimationFrame(() => {
        scheduled = false;
        draw();
      });
    },
    { signal, passive: true },
  );

  element.addEventListener('click', (event) => {
    const index = indexOf(event.target);
    if (index !== null)
      onSelect(
        index,
        event.shiftKey
          ? 'range'
          : event.ctrlKey || event.metaKey || (event.target instanceof Element && event.target.closest('.found-tick'))
            ? 'toggle'
            : 'only',
      );
  });
  element.addEventListener('dblclick', (event) => {
    const index = indexOf(event.target);
    if (index !== null) onOpen(index);
  });
  element.addEventListener('keydown', (event) => {
    const name = event.key;
    const next = event.altKey ? null : nextIndex(name, cursor, tracks.length, { columns, page: Math.max(1, rows - 1) });
    if (next !== null) {
      if (event.shiftKey) onSelect(next, 'range');
      else if (event.ctrlKey || event.metaKey) onMoveCursor(next);
      else onSelect(next, 'only');
    } else if (name === ' ' && tracks.length > 0) onSelect(cursor, 'toggle');
    else if (name === 'Enter' && tracks[cursor]) onOpen(cursor);
    else return;
    event.preventDefault();
    event.stopPropagation();
  });

  /** @param {EventTarget|null} target */
  function indexOf(target) {
    const tile = target instanceof Element ? /** @type {HTMLElement|null} */ (target.closest('.found-tile')) : null;
    return tile ? Number(tile.dataset.at) : null;
  }

  function draw() {
    const width = element.clientWidth;
    if (width === 0 || signal.aborted) return;
    columns = Math.max(1, Math.floor((width - 8) / TILE_WIDTH_PX));
    rows = Math.max(1, Math.floor(element.clientHeight / TILE_HEIGHT_PX));
    const rowCount = Math.ceil(tracks.length / columns);
    sheet.style.setProperty('--sheet', `${rowCount * TILE_HEIGHT_PX}px`);
    const first = Math.max(0, Math.floor(element.scrollTop / TILE_HEIGHT_PX) - SPARE_ROWS);
    const last = Math.min(rowCount, Math.ceil((element.scrollTop + element.clientHeight) / TILE_HEIGHT_PX) + SPARE_ROWS);
    const shown = tracks.slice(first * columns, last * columns).map((track, i) => ({ track, index: first * columns + i }));
    reconcile(
      sheet,
      shown,
      ({ track }) => idOf(track),
      create,
      (tile, { track, index }) => fillTile(tile, track, index),
    );
    setAttribute(element, 'aria-activedescendant', tracks[cursor] && document.getElementById(`found-${cursor}`) ? `found-${cursor}` : null);
    if (last * columns >= tracks.length - columns * 4) onNearEnd();
  }

  function create() {
    const image = imageWithPlaceholder({ class: 'found-picture', loading: 'lazy', decoding: 'async' });
    return h(
      'div.found-tile',
      { role: 'option' },
      h(
        'div.found-frame',
        image,
        h('span.found-none.muted.small', 'The picture cannot be read'),
        h('span.found-tick', { 'aria-hidden': 'true' }, icon('check')),
      ),
      h('div.found-words', h('span.truncate.grow', { dir: 'auto' }), h('span.found-uncertainty.muted.small')),
      h('div.found-words.muted.small', h('span.found-state'), h('span.truncate.grow', { dir: 'auto' })),
    );
  }

  /** @param {HTMLElement} tile @param {FoundTrack} track @param {number} index */
  function fillTile(tile, track, index) {
    const [frame, labelLine, videoLine] = /** @type {HTMLElement[]} */ ([...tile.children]);
    const image = /** @type {HTMLImageElement} */ (frame.firstElementChild);
    setImageSource(image, picture(track));
    tile.id = `found-${index}`;
    tile.dataset.at = String(index);
    tile.style.setProperty('--x', `${(index % columns) * TILE_WIDTH_PX}px`);
    tile.style.setProperty('--y', `${Math.floor(index / columns) * TILE_HEIGHT_PX}px`);
    tile.classList.toggle('found-at', index === cursor);
    tile.dataset.state = track.state;
    setAttribute(tile, 'aria-selected', String(selected.has(idOf(track))));
    setAttribute(tile, 'aria-posinset', index + 1);
    setAttribute(tile, 'aria-setsize', tracks.length);
    const label = track.label?.name ?? 'No label';
    const uncertaintyText = `${Math.round(track.uncertainty * 100)} %`;
    const stateInfo = STATES[track.state];
    setText(labelLine.children[0], label);
    setText(labelLine.children[1], uncertaintyText);
    const state = videoLine.children[0];
    if (/** @type {HTMLElement} */ (state).dataset.state !== track.state) {
      /** @type {HTMLElement} */ (state).dataset.state = track.state;
      state.replaceChildren(...(stateInfo.icon ? [icon(stateInfo.icon)] : []));
    }
    setText(videoLine.children[1], track.video_name);
    tile.title = [
      label,
      `${stateInfo.text}, ${uncertaintyText} uncertain, ${Math.round(track.size)} px`,
      `${track.video_name}, frame ${track.frame}`,
      track.author ? `Edited last by ${track.author}` : '',
      track.tags.join(', '),
    ]
      .filter(Boolean)
      .join('\n');
    setAttribute(
      tile,
      'aria-label',
      `${label}, ${stateInfo.text}, ${uncertaintyText} uncertain, ${track.video_name}, frame ${track.frame}`,
    );
  }

  return {
    element,
    /** @param {readonly FoundTrack[]} found @param {ReadonlySet<string>} chosen @param {number} newCursor */
    show(found, chosen, newCursor) {
      const moved = newCursor !== cursor;
      [tracks, selected, cursor] = [found, chosen, newCursor];
      if (moved) {
        const top = Math.floor(cursor / columns) * TILE_HEIGHT_PX;
        if (top < element.scrollTop) element.scrollTop = top;
        else if (top + TILE_HEIGHT_PX > element.scrollTop + element.clientHeight)
          element.scrollTop = top + TILE_HEIGHT_PX - element.clientHeight;
      }
      draw();
    },
    top: () => element.scrollTop,
    /** @param {number} top */
    scrollTo: (top) => {
      draw();
      element.scrollTop = top;
    },
  };
}
