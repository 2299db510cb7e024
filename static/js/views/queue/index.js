// @ts-check
/** The queue: uncertain tracks first, filtered and counted. A virtual listbox: only the rows on screen exist. */

import { deletedTracks } from '../../model/deleted.js';
import { trackEntries } from '../../model/track_entries.js';
import { nextIndex } from '../../model/list_keys.js';
import { queueCounts, queueOf } from '../../model/queue.js';
import { modeOf } from '../../modes/index.js';
import { extendHint } from '../../model/extend_hints.js';
import { frameCount, applyTrackClick } from '../../store/actions/review.js';
import { openTrack } from '../../operations/navigate.js';
import { openDialog } from '../../store/actions/page.js';
import { h, setAttribute, setText } from '../dom.js';
import { count, percent, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { createProgressBar, setProgress } from '../progress_bar.js';
import { createNoTracks } from '../no_tracks.js';
import { NEXT_VIDEO_KEY, openNextVideo } from '../../operations/next_video.js';
import { createQueueEnd } from './end.js';
import { createQueueFilters } from './filters.js';
import { createQueueRow } from './row.js';

/** @typedef {import('../../state-types.js').State} State */
/** @typedef {import('../../model/track_entries.js').TrackEntry} TrackEntry */

/** Rows kept above and below the visible ones, so that quick scrolling shows no gap. */
const SPARE_ROWS = 4;

/** @param {import('../../page-types.js').ViewApp} app */
export function createQueue(app) {
  const lifetime = new AbortController();
  const { signal } = lifetime;
  const filters = createQueueFilters(app);
  const leftText = h('strong');
  const shownText = h('span.muted.small');
  const countsText = h('span.queue-counts.grow', leftText, ' ', shownText);
  const deletedButton = h('button.btn.btn-small', {
    hidden: true,
    title: 'List the deleted tracks and restore them',
    onclick: () => app.store.dispatch(openDialog, { kind: 'deleted' }),
  });
  const bulkReviewButton = h(
    'button.btn.btn-small',
    {
      hidden: true,
      title: 'Give one verdict to all shown tracks (Shift+A)',
      onclick: () => app.store.dispatch(openDialog, { kind: 'bulk-review' }),
    },
    'Bulk review …',
  );
  const nextVideoButton = h(
    'button.btn.btn-small.btn-icon',
    {
      'aria-label': `Go to another video (${NEXT_VIDEO_KEY})`,
      title: `Next video with open tracks (${NEXT_VIDEO_KEY})`,
      onclick: () => void openNextVideo(app),
    },
    icon('film'),
  );
  const meter = createProgressBar('Reviewed', 'div.meter.meter-good');
  const list = h('div.queue-rows');
  const empty = createNoTracks(app, 'queue-empty');
  const end = createQueueEnd(() => void openNextVideo(app));
  const scroller = h('div.queue-list', { role: 'listbox', tabindex: '0', 'aria-label': 'Tracks by uncertainty' }, list);
  const element = h(
    'section.queue.panel',
    { 'aria-label': 'Queue' },
    h('div.panel-head', h('h2.queue-title', 'Queue'), countsText, bulkReviewButton, nextVideoButton, deletedButton),
    meter,
    filters.element,
    h('div.queue-body', scroller, empty.element),
    end.element,
  );

  /** @type {State|null} */ let state = null;
  /** @type {readonly TrackEntry[]} */ let entries = [];
  /** @type {TrackEntry[]} */ let order = [];
  /** @type {Map<string, ReturnType<typeof createQueueRow>>} */ const rows = new Map();
  let rowHeight = 64;
  let scheduled = 0;
  let needsReveal = true;

  list.addEventListener('click', (event) => {
    const row = /** @type {HTMLElement} */ (event.target).closest('[data-key]');
    const { review } = app.store.get();
    if (!review || !(row instanceof HTMLElement) || !row.dataset.key) return;
    // the mode may use the click, for example to mark the track for a merge
    if (modeOf(review).onTrackClick === null) openTrack(app, row.dataset.key);
    else app.store.dispatch(applyTrackClick, row.dataset.key);
  });
  scroller.addEventListener('keydown', (event) => {
    const at = order.findIndex((entry) => entry.key === state?.review?.selected);
    const next = nextIndex(event.key, at, order.length, { page: Math.max(1, Math.floor(scroller.clientHeight / rowHeight) - 1) });
    // with Shift or Alt the arrows move or resize the box of the selected track
    if (next === null || event.shiftKey || event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    openTrack(app, order[next].key);
  });
  scroller.addEventListener('scroll', scheduleDraw, { signal, passive: true });
  const observer = new ResizeObserver(scheduleDraw);
  observer.observe(scroller);

  function scheduleDraw() {
    if (scheduled === 0) scheduled = requestAnimationFrame(draw);
  }

  function draw() {
    scheduled = 0;
    const review = state?.review;
    if (!state || !review) return;
    const unit = Number.parseFloat(getComputedStyle(element).getPropertyValue('--u')) || 4;
    rowHeight = Math.round(unit * 18.5);
    list.style.setProperty('height', `${order.length * rowHeight}px`);
    if (needsReveal && scroller.clientHeight > 0) {
      needsReveal = false;
      reveal();
    }
    const first = Math.max(0, Math.floor(scroller.scrollTop / rowHeight) - SPARE_ROWS);
    const last = Math.min(order.length, Math.ceil((scroller.scrollTop + scroller.clientHeight) / rowHeight) + SPARE_ROWS);
    const visibleKeys = new Set(order.slice(first, last).map((entry) => entry.key));
    for (const [key, row] of rows) {
      if (visibleKeys.has(key)) continue;
      row.element.remove();
      rows.delete(key);
    }
    const video = { width: review.video.width ?? 0, height: review.video.height ?? 0, frames: frameCount(review) };
    for (let i = first; i < last; i += 1) {
      const entry = order[i];
      let row = rows.get(entry.key);
      if (!row) {
        row = createQueueRow(entry.key);
        rows.set(entry.key, row);
        list.append(row.element);
      }
      row.update(entry, state.labels, {
        index: i,
        size: order.length,
        top: i * rowHeight,
        height: rowHeight,
        selected: entry.key === review.selected,
        marked: review.marked.includes(entry.key),
        hint: extendHint(review.tracks, entry, video),
      });
    }
    const selectedRow = review.selected === null ? undefined : rows.get(review.selected);
    setAttribute(scroller, 'aria-activedescendant', selectedRow?.element.id);
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
      const previous = state?.review ?? null;
      const review = next.review;
      const labelsUnchanged = state?.labels === next.labels;
      const videosChanged = state?.videos !== next.videos;
      state = next;
      if (review === null) return;
      const dataChanged =
        !previous ||
        previous.tracks !== review.tracks ||
        previous.docs !== review.docs ||
        previous.run?.state !== review.run?.state ||
        previous.timebase !== review.timebase;
      const listChanged = dataChanged || !labelsUnchanged || previous.filter !== review.filter;
      if (listChanged || videosChanged) end.update(next, queueCounts(trackEntries(review.tracks, review.docs)));
      if (!listChanged && previous?.selected === review.selected && previous?.marked === review.marked) return;
      if (dataChanged) entries = trackEntries(review.tracks, review.docs);
      if (listChanged) {
        order = queueOf(entries, review.filter, next.labels);
        const counts = queueCounts(entries);
        const done = counts.total > 0 ? (counts.total - counts.left) / counts.total : 0;
        setText(leftText, review.tracks === null ? '' : `${count(counts.left)} left`);
        setText(
          shownText,
          review.tracks === null
            ? ''
            : order.length === counts.total
              ? `of ${count(counts.total)}`
              : `${count(order.length)} of ${count(counts.total)} shown`,
        );
        setAttribute(countsText, 'title', countsText.textContent ?? '');
        bulkReviewButton.hidden = order.length < 2;
        const deletedCount = deletedTracks(review.docs).length;
        deletedButton.hidden = deletedCount === 0;
        setText(deletedButton, `${count(deletedCount)} deleted`);
        deletedButton.setAttribute('aria-label', `${plural(deletedCount, 'deleted track')}, show`);
        setProgress(meter, done);
        meter.title = `${percent(done)} reviewed: ${count(counts.accepted)} accepted, ${count(counts.rejected)} false positives, ${count(counts.needs_work)} need work`;
        filters.update(review.filter, entries, next.labels);
        empty.update(review, counts.total, order.length === 0 ? 'No track matches these filters.' : '');
        list.style.setProperty('height', `${order.length * rowHeight}px`);
      }
      if (previous?.selected !== review.selected) needsReveal = true;
      scheduleDraw();
    },
    destroy() {
      lifetime.abort();
      observer.disconnect();
      cancelAnimationFrame(scheduled);
    },
  };
}
