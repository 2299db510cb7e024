// @ts-check
/** The grid of crops. Only visible rows exist; keys and pointer select as in a file manager. */

import { nextIndex } from '../../model/list_keys.js';
import { idOf } from '../../model/search.js';
import { h, reconcile, setAttribute, setText } from '../dom.js';
import { icon } from '../icons.js';
import { pictureThatMayMiss, showPicture } from '../pictures.js';

/** @typedef {import('../../types.js').FoundTrack} FoundTrack */

/** Width of a tile with its gap, px. */
const WIDTH = 148;
const HEIGHT = 178;
/** Rows kept above and below the visible ones. */
const BEYOND = 3;
/** Longer side of requested pictures, px: sharp on screens of double density. */
export const PICTURE = 192;
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
 * @param {(at: number, how: 'only'|'toggle'|'range') => void} setup.select
 * @param {(at: number) => void} setup.move               moves only the cursor
 * @param {(at: number) => void} setup.open
 * @param {() => void} setup.more                         called near the end
 * @param {AbortSignal} setup.signal
 */
export function createGrid({ picture, select, move, open, more, signal }) {
  const sheet = h('div.found-sheet', { role: 'presentation' });
  const element = h(
    'div.found',
    { role: 'listbox', tabIndex: 0, id: 'found', 'aria-multiselectable': 'true', 'aria-label': 'Found tracks' },
    sheet,
  );
  /** @type {readonly FoundTrack[]} */ let tracks = [];
  /** @type {ReadonlySet<string>} */ let selected = new Set();
  let at = 0;
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

  element.addEventListener(
    'click',
    (event) => {
      const place = placeOf(event.target);
      if (place !== null)
        select(
          place,
          event.shiftKey
            ? 'range'
            : event.ctrlKey || event.metaKey || (event.target instanceof Element && event.target.closest('.found-tick'))
              ? 'toggle'
              : 'only',
        );
    },
    { signal },
  );
  element.addEventListener(
    'dblclick',
    (event) => {
      const place = placeOf(event.target);
      if (place !== null) open(place);
    },
    { signal },
  );
  element.addEventListener(
    'keydown',
    (event) => {
      const name = event.key;
      const next = event.altKey ? null : nextIndex(name, at, tracks.length, { columns, page: Math.max(1, rows - 1) });
      if (next !== null) {
        if (event.shiftKey) select(next, 'range');
        else if (event.ctrlKey || event.metaKey) move(next);
        else select(next, 'only');
      } else if (name === ' ' && tracks.length > 0) select(at, 'toggle');
      else if (name === 'Enter' && tracks[at]) open(at);
      else return;
      event.preventDefault();
      event.stopPropagation();
    },
    { signal },
  );

  /** @param {EventTarget|null} target */
  function placeOf(target) {
    const tile = target instanceof Element ? /** @type {HTMLElement|null} */ (target.closest('.found-tile')) : null;
    return tile ? Number(tile.dataset.at) : null;
  }

  function draw() {
    const width = element.clientWidth;
    if (width === 0 || signal.aborted) return;
    columns = Math.max(1, Math.floor((width - 8) / WIDTH));
    rows = Math.max(1, Math.floor(element.clientHeight / HEIGHT));
    const all = Math.ceil(tracks.length / columns);
    sheet.style.setProperty('--sheet', `${all * HEIGHT}px`);
    const first = Math.max(0, Math.floor(element.scrollTop / HEIGHT) - BEYOND);
    const last = Math.min(all, Math.ceil((element.scrollTop + element.clientHeight) / HEIGHT) + BEYOND);
    const shown = tracks.slice(first * columns, last * columns).map((track, i) => ({ track, place: first * columns + i }));
    reconcile(
      sheet,
      shown,
      ({ track }) => idOf(track),
      create,
      (tile, { track, place }) => fillTile(tile, track, place),
    );
    setAttribute(element, 'aria-activedescendant', tracks[at] && document.getElementById(`found-${at}`) ? `found-${at}` : null);
    if (last * columns >= tracks.length - columns * 4) more();
  }

  function create() {
    const image = pictureThatMayMiss({ class: 'found-picture', loading: 'lazy', decoding: 'async' });
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

  /** @param {HTMLElement} tile @param {FoundTrack} track @param {number} place */
  function fillTile(tile, track, place) {
    const [frame, words, from] = /** @type {HTMLElement[]} */ ([...tile.children]);
    const image = /** @type {HTMLImageElement} */ (frame.firstElementChild);
    showPicture(image, picture(track));
    tile.id = `found-${place}`;
    tile.dataset.at = String(place);
    tile.style.setProperty('--x', `${(place % columns) * WIDTH}px`);
    tile.style.setProperty('--y', `${Math.floor(place / columns) * HEIGHT}px`);
    tile.classList.toggle('found-at', place === at);
    tile.dataset.state = track.state;
    setAttribute(tile, 'aria-selected', String(selected.has(idOf(track))));
    setAttribute(tile, 'aria-posinset', place + 1);
    setAttribute(tile, 'aria-setsize', tracks.length);
    const label = track.label?.name ?? 'No label';
    const sure = `${Math.round(track.uncertainty * 100)} %`;
    const told = STATES[track.state];
    setText(words.children[0], label);
    setText(words.children[1], sure);
    const state = from.children[0];
    if (/** @type {HTMLElement} */ (state).dataset.state !== track.state) {
      /** @type {HTMLElement} */ (state).dataset.state = track.state;
      state.replaceChildren(...(told.icon ? [icon(told.icon)] : []));
    }
    setText(from.children[1], track.video_name);
    tile.title = [
      label,
      `${told.text}, ${sure} uncertain, ${Math.round(track.size)} px`,
      `${track.video_name}, frame ${track.frame}`,
      track.author ? `Edited last by ${track.author}` : '',
      track.tags.join(', '),
    ]
      .filter(Boolean)
      .join('\n');
    setAttribute(tile, 'aria-label', `${label}, ${told.text}, ${sure} uncertain, ${track.video_name}, frame ${track.frame}`);
  }

  return {
    element,
    /** @param {readonly FoundTrack[]} found @param {ReadonlySet<string>} chosen @param {number} cursor */
    show(found, chosen, cursor) {
      const moved = cursor !== at;
      [tracks, selected, at] = [found, chosen, cursor];
      if (moved) {
        const top = Math.floor(at / columns) * HEIGHT;
        if (top < element.scrollTop) element.scrollTop = top;
        else if (top + HEIGHT > element.scrollTop + element.clientHeight) element.scrollTop = top + HEIGHT - element.clientHeight;
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
