// @ts-check
/** The screen of the search: signs of all videos as crops, and actions on the selected ones. */

import { ApiError, sentence } from '../../api/errors.js';
import { formatSearch, idOf, describeMatchedLabels, parseSearch, selectTracks, withChanged } from '../../model/search.js';
import { formatRoute } from '../../model/route.js';
import { setVideos } from '../../store/actions/page.js';
import { fill, h, setText } from '../dom.js';
import { emptyState, failure, waiting } from '../empty.js';
import { count, plural } from '../../model/format.js';
import { toast } from '../../core/toast.js';
import { createSearchActions } from './actions.js';
import { createSearchFilters } from './filters.js';
import { createGrid, PICTURE } from './grid.js';

/** @typedef {import('../../types.js').FoundTrack} FoundTrack */
/** @typedef {import('../../api/search.js').SearchAnswer} SearchAnswer */

/** Number of tracks per request. */
const STEP = 120;
/** Number of tracks per request when many are needed at once. */
const MANY = 500;
/** Maximum number of selected tracks: as many as the server changes in one action. */
const MOST_SELECTED = 5000;
/** Number of labels to name for a word; the title names all. */
const MOST_NAMED = 12;
/** Interval of requests while runs are still being read, ms. */
const AGAIN = 2000;

/** The user's place, to return to after a review. @type {WeakMap<object, {query: string, count: number, top: number, at: number, selected: ReadonlySet<string>}>} */
const places = new WeakMap();

/**
 * @param {import('../../page-types.js').App} app
 * @returns {import('../../page-types.js').View}
 */
export function createSearch(app) {
  const { store, api } = app;
  const ended = new AbortController();
  const signal = AbortSignal.any([ended.signal, app.signal]);
  /** @type {FoundTrack[]} */ let tracks = [];
  /** @type {ReadonlySet<string>} */ let selected = new Set();
  let at = 0;
  let anchor = 0;
  /** @type {string|null} */ let next = null;
  /** @type {string|null} */ let query = null;
  /** @type {SearchAnswer|null} */ let answer = null;
  /** Number of the latest search; answers to older ones are not shown. */
  let asked = 0;
  let loading = false;
  /** @type {ReturnType<typeof setTimeout>|undefined} */ let again;
  signal.addEventListener('abort', () => clearTimeout(again), { once: true });

  const total = h('span.muted', { role: 'status' });
  const note = h('p.search-note', { role: 'status', hidden: true });
  const filters = createSearchFilters({
    signal,
    change: (wanted) => {
      const address = formatRoute({ screen: 'search', query: formatSearch(wanted) });
      // each query is an address, but not each letter is a step of the history
      if (location.hash !== address) {
        history.replaceState(null, '', address);
        dispatchEvent(new HashChangeEvent('hashchange'));
      }
    },
  });
  const grid = createGrid({
    signal,
    picture: (track) => api.searchCropUrl(track, PICTURE),
    select: (place, how) => {
      selected = selectTracks(selected, tracks, anchor, place, how);
      if (how !== 'range') anchor = place;
      at = place;
      show();
    },
    move: (place) => {
      at = place;
      show();
    },
    open: openTrack,
    more: () => void loadMore(),
  });
  const notice = h('div.search-notice');
  const actions = createSearchActions(app, {
    signal,
    selected: () => tracks.filter((track) => selected.has(idOf(track))),
    changed: (now) => {
      tracks = withChanged(tracks, now);
      show();
    },
    anew: () => void search(true),
    open: () => openTrack(at),
    all: () => void selectAll(),
    none: () => {
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
  element.addEventListener(
    'keydown',
    (event) => {
      if (event.target instanceof Element && event.target.closest('input, select')) return;
      if (!actions.key(event)) return;
      event.preventDefault();
      event.stopPropagation();
    },
    { signal },
  );

  /** @param {number} place */
  function openTrack(place) {
    const track = tracks[place];
    if (!track) return;
    at = place;
    location.hash = formatRoute({ screen: 'review', video: track.video, run: track.run, frame: track.frame, track: track.key });
  }

  /** @param {boolean} [keep]   repeat the same query with as many tracks, keeping place and selection */
  async function search(keep = false) {
    const mine = ++asked;
    const wanted = query ?? '';
    clearTimeout(again);
    loading = true;
    const many = keep ? Math.max(STEP, tracks.length || (places.get(app)?.count ?? 0)) : STEP;
    if (!keep) {
      tracks = [];
      answer = null;
      [selected, at, anchor] = [new Set(), 0, 0];
      fill(notice, waiting('Searching the tracks', { retry: () => void search(), signal }));
      show();
    }
    try {
      let found = await api.search(wanted, { limit: Math.min(MANY, many) }, { signal });
      const all = [...found.tracks];
      const first = found;
      while (mine === asked && found.next && all.length < many) {
        found = await api.search(wanted, { limit: Math.min(MANY, many - all.length), cursor: found.next }, { signal });
        all.push(...found.tracks);
      }
      if (mine !== asked || signal.aborted) return;
      [tracks, next, answer] = [all, found.next, first];
      const there = new Set(tracks.map(idOf));
      selected = new Set([...selected].filter((id) => there.has(id)));
      at = Math.min(at, Math.max(0, tracks.length - 1));
      fill(notice);
      if (first.unread > 0) again = setTimeout(() => void askAgain(), AGAIN);
    } catch (thrown) {
      if (mine !== asked || signal.aborted) return;
      [tracks, next, answer] = [[], null, null];
      fill(
        notice,
        failure(
          thrown instanceof ApiError && thrown.code === 'no_such_label' ? 'No such label' : 'The search did not succeed',
          thrown,
          () => search(),
        ),
      );
    } finally {
      if (mine === asked) loading = false;
    }
    show();
  }

  /** Search again for runs that were still being read, without disturbing the user. */
  async function askAgain() {
    if (selected.size === 0 && grid.top() === 0 && !document.querySelector('dialog[open]')) {
      await search(true);
      return;
    }
    const mine = asked;
    try {
      const found = await api.search(query ?? '', { limit: 1 }, { signal });
      if (mine !== asked || answer === null) return;
      answer = { ...answer, total: found.total, more: found.more, unread: found.unread };
      show();
      if (found.unread > 0) again = setTimeout(() => void askAgain(), AGAIN);
    } catch {
      if (!signal.aborted) again = setTimeout(() => void askAgain(), AGAIN);
    }
  }

  /** @param {number} [limit] @returns {Promise<boolean>} whether there was more to load */
  async function loadMore(limit = STEP) {
    if (loading || next === null || signal.aborted) return false;
    const mine = asked;
    loading = true;
    try {
      const found = await api.search(query ?? '', { limit, cursor: next }, { signal });
      if (mine !== asked) return false;
      const there = new Set(tracks.map(idOf));
      tracks = [...tracks, ...found.tracks.filter((track) => !there.has(idOf(track)))];
      next = found.next;
    } catch (thrown) {
      if (mine === asked && !signal.aborted) {
        toast(sentence(thrown), { tone: 'bad', topic: 'search' });
        next = null; // the user can search again; otherwise the list would request for ever
      }
      return false;
    } finally {
      if (mine === asked) loading = false;
    }
    show();
    return true;
  }

  async function selectAll() {
    while (tracks.length < MOST_SELECTED && next !== null) {
      if (!(await loadMore(MANY))) {
        if (!loading) break;
        await new Promise((resolve) => setTimeout(resolve, 50));
      }
    }
    if (signal.aborted) return;
    selected = new Set(tracks.slice(0, MOST_SELECTED).map(idOf));
    if (next !== null || tracks.length > MOST_SELECTED)
      toast(`The first ${count(MOST_SELECTED)} are selected: one action handles no more.`, { topic: 'search' });
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
    const told = answer === null ? '' : notesOf(answer, parseSearch(query ?? ''));
    note.hidden = told === '';
    setText(note, told);
    note.title = answer === null ? '' : describeMatchedLabels(answer.labels, parseSearch(query ?? '').label);
    if (answer !== null && tracks.length === 0) {
      const all = query !== '';
      fill(
        notice,
        emptyState({
          icon: 'search',
          title: all ? 'No track matches these filters' : 'No track yet',
          text: all
            ? 'Every filter must hold. Remove one, or widen a range.'
            : answer.unread > 0
              ? 'The runs are still being read.'
              : 'Tracks appear here when a run is complete.',
          actions: [
            all &&
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
    grid.show(tracks, selected, at);
    actions.show(selected.size);
  }

  const place = places.get(app);
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
      if (first && place?.query === query) {
        [at, anchor, selected] = [place.at, place.at, place.selected];
        void search(true).then(() => {
          grid.scrollTo(place.top);
          grid.element.focus({ preventScroll: true });
        });
      } else {
        void search().then(() => {
          const elsewhere = element.contains(document.activeElement) || document.querySelector('dialog[open]');
          if (first && !elsewhere) grid.element.focus({ preventScroll: true });
        });
      }
    },
    destroy() {
      places.set(app, { query: query ?? '', count: tracks.length, top: grid.top(), at, selected });
      ended.abort();
      element.remove();
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
  const meant = describeMatchedLabels(answer.labels, filters.label, MOST_NAMED);
  if (meant) parts.push(meant);
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
