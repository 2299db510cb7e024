// @ts-check
/** The queue: uncertain tracks first, filtered and counted. A virtual listbox: only the rows on screen exist. */

import { deletedTracks } from '../../model/deleted.js';
import { trackEntries } from '../../model/track_entries.js';
import { nextIndex } from '../../model/list_keys.js';
import { queueCounts, queueOf } from '../../model/queue.js';
import { extendHint } from '../../model/extend_hints.js';
import { frameCount } from '../../store/actions/review.js';
import { openTrack } from '../../operations/navigate.js';
import { dialog, mark } from '../app.js';
import { h, setAttribute, setText } from '../dom.js';
import { count, percent, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { createMeter, setMeter } from '../meter.js';
import { createNoTracks } from '../no_tracks.js';
import { NEXT_VIDEO_KEY, openNextVideo } from '../../operations/next_video.js';
import { createQueueEnd } from './end.js';
import { createFilters } from './filters.js';
import { createRow } from './row.js';

/** @typedef {import('../../state-types.js').State} State */
/** @typedef {import('../../model/track_entries.js').TrackEntry} TrackEntry */

/** Rows kept above and below the visible ones, so that quick scrolling shows no gap. */
const SPARE = 4;

/** @param {import('../app.js').ViewApp} app */
export function createQueue(app) {
  const life = new AbortController();
  const { signal } = life;
  const filters = createFilters(app, signal);
  const left = h('strong.queue-left');
  const shown = h('span.muted.small');
  const deleted = h('button.btn.btn-small', {
    hidden: true,
    title: 'List the deleted tracks and restore them',
    onclick: () => dialog(app, { kind: 'deleted' }),
  });
  const judge = h(
    'button.btn.btn-small',
    { hidden: true, title: 'Give one verdict to all shown tracks (Shift+A)', onclick: () => dialog(app, { kind: 'bulk-review' }) },
    'Bulk review …',
  );
  const next = h(
    'button.btn.btn-small.btn-icon',
    {
      'aria-label': `Go to another video (${NEXT_VIDEO_KEY})`,
      title: `Next video with open tracks (${NEXT_VIDEO_KEY})`,
      onclick: () => void openNextVideo(app),
    },
    icon('film'),
  );
  const meter = createMeter('Reviewed', 'div.meter.meter-good');
  const list = h('div.queue-rows');
  const empty = createNoTracks(app, 'queue-empty');
  const end = createQueueEnd(() => void openNextVideo(app));
  const scroller = h('div.queue-list', { role: 'listbox', tabindex: '0', 'aria-label': 'Tracks by uncertainty' }, list);
  const element = h(
    'section.queue.panel',
    { 'aria-label': 'Queue' },
    h('div.panel-head', h('h2.queue-title', 'Queue'), left, h('span.grow'), deleted, judge, shown, next),
    meter,
    filters.element,
    h('div.queue-body', scroller, empty.element),
    end.element,
  );

  /** @type {State|null} */ let state = null;
  /** @type {readonly TrackEntry[]} */ let entries = [];
  /** @type {TrackEntry[]} */ let order = [];
  /** @type {Map<string, ReturnType<typeof createRow>>} */ const rows = new Map();
  let rowHeight = 64;
  let scheduled = 0;
  let wanting = true;

  list.addEventListener(
    'click',
    (event) => {
      const row = /** @type {HTMLElement} */ (event.target).closest('[data-key]');
      if (row instanceof HTMLElement && row.dataset.key && !mark(app, row.dataset.key)) openTrack(app, row.dataset.key);
    },
    { signal },
  );
  scroller.addEventListener(
    'keydown',
    (event) => {
      const at = order.findIndex((entry) => entry.key === state?.review?.selected);
      const next = nextIndex(event.key, at, order.length, { page: Math.max(1, Math.floor(scroller.clientHeight / rowHeight) - 1) });
      // with Shift or Alt the arrows move or resize the box of the selected track
      if (next === null || event.shiftKey || event.altKey) return;
      event.preventDefault();
      event.stopPropagation();
      openTrack(app, order[next].key);
    },
    { signal },
  );
  scroller.addEventListener('scroll', later, { signal, passive: true });
  const observer = new ResizeObserver(later);
  observer.observe(scroller);

  function later() {
    if (scheduled === 0) scheduled = requestAnimationFrame(draw);
  }

  function draw() {
    scheduled = 0;
    const review = state?.review;
    if (!state || !review) return;
    const unit = Number.parseFloat(getComputedStyle(element).getPropertyValue('--u')) || 4;
    rowHeight = Math.round(unit * 18.5);
    list.style.setProperty('height', `${order.length * rowHeight}px`);
    if (wanting && scroller.clientHeight > 0) {
      wanting = false;
      reveal();
    }
    const first = Math.max(0, Math.floor(scroller.scrollTop / rowHeight) - SPARE);
    const last = Math.min(order.length, Math.ceil((scroller.scrollTop + scroller.clientHeight) / rowHeight) + SPARE);
    const wanted = new Set(order.slice(first, last).map((entry) => entry.key));
    for (const [key, row] of rows) {
      if (wanted.has(key)) continue;
      row.element.remove();
      rows.delete(key);
    }
    const video = { width: review.video.width ?? 0, height: review.video.height ?? 0, frames: frameCount(review) };
    for (let i = first; i < last; i += 1) {
      const entry = order[i];
      let row = rows.get(entry.key);
      if (!row) {
        row = createRow(entry.key);
        rows.set(entry.key, row);
        list.append(row.element);
      }
      row.update(entry, state.labels, {
        place: i,
        size: order.length,
        top: i * rowHeight,
        height: rowHeight,
        selected: entry.key === review.selected,
        marked: review.marked.includes(entry.key),
        hint: extendHint(review.tracks, entry, video),
      });
    }
    const chosen = review.selected === null ? undefined : rows.get(review.selected);
    setAttribute(scroller, 'aria-activedescendant', chosen?.element.id);
  }

  function reveal() {
    const at = order.findIndex((entry) => entry.key === state?.review?.selected);
    if (at < 0) return;
    const top = at * rowHeight;
    if (top < scroller.scrollTop) scroller.scrollTop = top;
    else if (top + rowHeight > scroller.scrollTop + scroller.clientHeight) scroller.scrollTop = top + rowHeight - scroller.clientHeight;
  }

  return {
    element,
    /** @param {State} next */
    update(next) {
      const before = state?.review ?? null;
      const review = next.review;
      const labelled = state?.labels === next.labels;
      const elsewhere = state?.videos !== next.videos;
      state = next;
      if (review === null) return;
      const data =
        !before ||
        before.tracks !== review.tracks ||
        before.docs !== review.docs ||
        before.run?.state !== review.run?.state ||
        before.timebase !== review.timebase;
      const turned = data || !labelled || before.filter !== review.filter;
      if (turned || elsewhere) end.update(next, queueCounts(trackEntries(review.tracks, review.docs)));
      if (!turned && before?.selected === review.selected && before?.marked === review.marked) return;
      if (data) entries = trackEntries(review.tracks, review.docs);
      if (turned) {
        order = queueOf(entries, review.filter, next.labels);
        const counts = queueCounts(entries);
        const done = counts.total > 0 ? (counts.total - counts.left) / counts.total : 0;
        setText(left, review.tracks === null ? '' : `${count(counts.left)} left`);
        setText(
          shown,
          order.length === counts.total ? `of ${count(counts.total)}` : `${count(order.length)} of ${count(counts.total)} shown`,
        );
        judge.hidden = order.length < 2;
        const gone = deletedTracks(review.docs).length;
        deleted.hidden = gone === 0;
        setText(deleted, `${count(gone)} deleted`);
        deleted.setAttribute('aria-label', `${plural(gone, 'deleted track')}, show`);
        setMeter(meter, done);
        meter.title = `${percent(done)} reviewed: ${count(counts.accepted)} accepted, ${count(counts.rejected)} false positives, ${count(counts.needs_work)} need work`;
        filters.update(review.filter, entries, next.labels);
        empty.update(review, counts.total, order.length === 0 ? 'No track matches these filters.' : '');
        list.style.setProperty('height', `${order.length * rowHeight}px`);
      }
      if (before?.selected !== review.selected) wanting = true;
      later();
    },
    destroy() {
      life.abort();
      observer.disconnect();
      cancelAnimationFrame(scheduled);
      element.remove();
    },
  };
}
