// @ts-check
/** The screen of the search: signs of all videos as crops, and actions on the selected ones. */

import { ApiError, errorMessage } from '../../api/errors.js';
import { formatSearch, idOf, describeMatchedLabels, parseSearch, selectTracks, withChanged } from '../../model/search.js';
import { formatRoute } from '../../model/route.js';
import { setVideos } from '../../store/actions/page.js';
import { fill, h, setText } from '../dom.js';
import { emptyState, errorState, loadingState } from '../placeholders.js';
import { count, plural } from '../../model/format.js';
import { toast } from '../../core/toast.js';
import { createSearchActions } from './actions.js';
import { createSearchFilters } from './filters.js';
import { CROP_SIZE_PX, createTrackGrid } from './grid.js';

/** @typedef {import('../../types.js').FoundTrack} FoundTrack */
/** @typedef {import('../../api/search.js').SearchAnswer} SearchAnswer */

/** Number of tracks per request. */
const PAGE_SIZE = 120;
/** Number of tracks per request when many are needed at once. */
const BULK_PAGE_SIZE = 500;
/** Maximum number of selected tracks: as many as the server changes in one action. */
const MAX_SELECTED = 5000;
/** Number of labels to name for a word; the title names all. */
const MAX_NAMED_LABELS = 12;
/** Interval of requests while runs are still being read, ms. */
const RETRY_DELAY_MS = 2000;

/** The user's place, to return to after a review. @type {WeakMap<object, {query: string, count: number, top: number, cursor: number, selected: ReadonlySet<string>}>} */
const savedStates = new WeakMap();

/** @type {import('../../page-types.js').CreateView} */
export function createSearch(app) {
  const { store, api } = app;
  const lifetime = new AbortController();
  const signal = AbortSignal.any([lifetime.signal, app.signal]);
  /** @type {FoundTrack[]} */ let tracks = [];
  /** @type {ReadonlySet<string>} */ let selected = new Set();
  let cursor = 0;
  let anchor = 0;
  /** @type {string|null} */ let nextCursor = null;
  /** @type {string|null} */ let query = null;
  /** @type {SearchAnswer|null} */ let answer = null;
  /** Number of the latest search; answers to older ones are not shown. */
  let latestRequest = 0;
  let isLoading = false;
  /** Whether the list takes the focus with its first tracks: its keys work at once, also if the runs are still being read. */
  let takesFocus = true;
  /** @type {ReturnType<typeof setTimeout>|undefined} */ let retryTimer;
  signal.addEventListener('abort', () => clearTimeout(retryTimer), { once: true });

  const total = h('span.muted', { role: 'status' });
  const note = h('p.search-note', { role: 'status', hidden: true });
  const filters = createSearchFilters({
    signal,
    onChange: (wanted) => {
      const address = formatRoute({ screen: 'search', query: formatSearch(wanted) });
      // each query is an address, but not each letter is a step of the history
      if (location.hash !== address) {
        history.replaceState(null, '', address);
        dispatchEvent(new HashChangeEvent('hashchange'));
      }
    },
  });
  const grid = createTrackGrid({
    signal,
    picture: (track) => api.searchCropUrl(track, CROP_SIZE_PX),
    onSelect: (index, mode) => {
      selected = selectTracks(selected, tracks, anchor, index, mode);
      if (mode !== 'range') anchor = index;
      cursor = index;
      show();
    },
    onMoveCursor: (index) => {
      cursor = index;
      show();
    },
    onOpen: openTrack,
    onNearEnd: () => void loadMore(),
  });
  const notice = h('div.search-notice');
  const actions = createSearchActions(app, {
    signal,
    selected: () => tracks.filter((track) => selected.has(idOf(track))),
    onChange: (now) => {
      tracks = withChanged(tracks, now);
      show();
    },
    repeatSearch: () => void search(true),
    openTrack: () => openTrack(cursor),
    selectAll: () => void selectAll(),
    selectNone: () => {
      selected = new Set();
      show();
    },
  });
  const element = h(
    'div.search-page',
    h('div.search-head', h('h1', 'Search'), total, h('div.grow'), actions.element),
    filters.element,
    note,
    h('div.search-body', grid.element, notice),
  );
  element.addEventListener('keydown', (event) => {
    if (event.target instanceof Element && event.target.closest('input, select')) return;
    if (!actions.key(event)) return;
    event.preventDefault();
    event.stopPropagation();
  });

  /** @param {number} index */
  function openTrack(index) {
    const track = tracks[index];
    if (!track) return;
    cursor = index;
    location.hash = formatRoute({ screen: 'review', video: track.video, run: track.run, frame: track.frame, track: track.key });
  }

  /** @param {boolean} [keepsSelection]   repeat the same query with as many tracks, keeping place and selection */
  async function search(keepsSelection = false) {
    const request = ++latestRequest;
    const requestedQuery = query ?? '';
    clearTimeout(retryTimer);
    isLoading = true;
    const wantedCount = keepsSelection ? Math.max(PAGE_SIZE, tracks.length || (savedStates.get(app)?.count ?? 0)) : PAGE_SIZE;
    if (!keepsSelection) {
      tracks = [];
      answer = null;
      [selected, cursor, anchor] = [new Set(), 0, 0];
      fill(notice, loadingState('Searching the tracks', { retry: () => void search(), signal }));
      show();
    }
    try {
      let found = await api.search(requestedQuery, { limit: Math.min(BULK_PAGE_SIZE, wantedCount) }, { signal });
      const all = [...found.tracks];
      const first = found;
      while (request === latestRequest && found.next && all.length < wantedCount) {
        found = await api.search(
          requestedQuery,
          { limit: Math.min(BULK_PAGE_SIZE, wantedCount - all.length), cursor: found.next },
          { signal },
        );
        all.push(...found.tracks);
      }
      if (request !== latestRequest || signal.aborted) return;
      [tracks, nextCursor, answer] = [all, found.next, first];
      const knownIds = new Set(tracks.map(idOf));
      selected = new Set([...selected].filter((id) => knownIds.has(id)));
      cursor = Math.min(cursor, Math.max(0, tracks.length - 1));
      fill(notice);
      if (first.unread > 0) retryTimer = setTimeout(() => void retryUnread(), RETRY_DELAY_MS);
    } catch (thrown) {
      if (request !== latestRequest || signal.aborted) return;
      [tracks, nextCursor, answer] = [[], null, null];
      fill(
        notice,
        errorState(
          thrown instanceof ApiError && thrown.code === 'no_such_label' ? 'No such label' : 'The search did not succeed',
          thrown,
          () => search(),
        ),
      );
    } finally {
      if (request === latestRequest) isLoading = false;
    }
    show();
  }

  /** Search again for runs that were still being read, without disturbing the user. */
  async function retryUnread() {
    if (selected.size === 0 && grid.top() === 0 && !document.querySelector('dialog[open]')) {
      await search(true);
      return;
    }
    const request = latestRequest;
    try {
      const found = await api.search(query ?? '', { limit: 1 }, { signal });
      if (request !== latestRequest || answer === null) return;
      answer = { ...answer, total: found.total, more: found.more, unread: found.unread };
      show();
      if (found.unread > 0) retryTimer = setTimeout(() => void retryUnread(), RETRY_DELAY_MS);
    } catch {
      if (!signal.aborted) retryTimer = setTimeout(() => void retryUnread(), RETRY_DELAY_MS);
    }
  }

  /** @param {number} [limit] @returns {Promise<boolean>} whether there was more to load */
  async function loadMore(limit = PAGE_SIZE) {
    if (isLoading || nextCursor === null || signal.aborted) return false;
    const request = latestRequest;
    isLoading = true;
    try {
      const found = await api.search(query ?? '', { limit, cursor: nextCursor }, { signal });
      if (request !== latestRequest) return false;
      const knownIds = new Set(tracks.map(idOf));
      tracks = [...tracks, ...found.tracks.filter((track) => !knownIds.has(idOf(track)))];
      nextCursor = found.next;
    } catch (thrown) {
      if (request === latestRequest && !signal.aborted) {
        toast(errorMessage(thrown), { tone: 'bad', topic: 'search' });
        nextCursor = null; // the user can search again; otherwise the list would request for ever
      }
      return false;
    } finally {
      if (request === latestRequest) isLoading = false;
    }
    show();
    return true;
  }

  async function selectAll() {
    while (tracks.length < MAX_SELECTED && nextCursor !== null) {
      if (!(await loadMore(BULK_PAGE_SIZE))) {
        if (!isLoading) break;
        await new Promise((resolve) => setTimeout(resolve, 50));
      }
    }
    if (signal.aborted) return;
    selected = new Set(tracks.slice(0, MAX_SELECTED).map(idOf));
    if (nextCursor !== null || tracks.length > MAX_SELECTED)
      toast(`The first ${count(MAX_SELECTED)} are selected: one action handles no more.`, { topic: 'search' });
    show();
  }

  function show() {
    if (signal.aborted) return;
    setText(
      total,
      answer === null
        ? ''
        : `${count(answer.total)}${answer.more ? ' or more' : ''} ${answer.total === 1 ? 'track' : 'tracks'}${selected.size > 0 ? `, ${count(selected.size)} selected` : ''}`,
    );
    const noteText = answer === null ? '' : notesOf(answer, parseSearch(query ?? ''));
    note.hidden = noteText === '';
    setText(note, noteText);
    note.title = answer === null ? '' : describeMatchedLabels(answer.labels, parseSearch(query ?? '').label);
    if (answer !== null && tracks.length === 0) {
      const hasFilters = query !== '';
      fill(
        notice,
        emptyState({
          icon: 'search',
          title: hasFilters ? 'No track matches these filters' : 'No track yet',
          text: hasFilters
            ? 'Every filter must hold. Remove one, or widen a range.'
            : answer.unread > 0
              ? 'The runs are still being read.'
              : 'Tracks appear here when a run is complete.',
          actions: [
            hasFilters &&
              h(
                'button.btn',
                {
                  onclick: () => {
                    location.hash = formatRoute({ screen: 'search', query: '' });
                  },
                },
                'Remove all filters',
              ),
          ],
        }),
      );
    }
    notice.hidden = notice.childElementCount === 0;
    grid.element.hidden = !notice.hidden;
    grid.show(tracks, selected, cursor);
    actions.show(selected.size);
    if (!takesFocus || tracks.length === 0) return;
    takesFocus = false;
    // not away from a control or an open dialog
    if (document.activeElement?.contains(element)) grid.element.focus({ preventScroll: true });
  }

  const saved = savedStates.get(app);
  /** @type {readonly import('../../types.js').Video[]|null} */ let videos = null;
  /** @type {readonly import('../../types.js').Label[]|null} */ let labels = null;
  if (store.get().videos === null) void app.load(() => api.videos({ signal }), setVideos).catch(() => {});
  return {
    element,
    update(state) {
      if (state.videos !== videos || state.labels !== labels) {
        [videos, labels] = [state.videos, state.labels];
        filters.offer(state.labels, state.videos ?? []);
      }
      if (state.route.screen !== 'search' || state.route.query === query) return;
      const first = query === null;
      query = state.route.query;
      filters.show(parseSearch(query));
      if (first && saved?.query === query) {
        [cursor, anchor, selected] = [saved.cursor, saved.cursor, saved.selected];
        void search(true).then(() => grid.scrollTo(saved.top));
      } else void search();
    },
    destroy() {
      savedStates.set(app, { query: query ?? '', count: tracks.length, top: grid.top(), cursor, selected });
      lifetime.abort();
    },
  };
}

/**
 * Notes on an answer: how the query was understood, and what is missing.
 *
 * @param {SearchAnswer} answer
 * @param {import('../../model/search.js').SearchFilters} filters
 * @returns {string}
 */
function notesOf(answer, filters) {
  const parts = [];
  const explanation = describeMatchedLabels(answer.labels, filters.label, MAX_NAMED_LABELS);
  if (explanation) parts.push(explanation);
  if (answer.unread > 0)
    parts.push(
      `${plural(answer.unread, 'run')} ${answer.unread === 1 ? 'is' : 'are'} still being read: ${answer.unread === 1 ? 'its' : 'their'} tracks are missing here for now.`,
    );
  if (answer.unreadable_count > 0) {
    const [first] = answer.unreadable;
    parts.push(
      `${plural(answer.unreadable_count, 'run')} cannot be read and ${answer.unreadable_count === 1 ? 'is' : 'are'} missing here: ${first.run_name} of ${first.video_name}: ${first.message}`,
    );
  }
  return parts.join(' ');
}
