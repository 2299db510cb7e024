// @ts-check
/** The first screen: all videos with their progress, and ways to add videos. */

import { isVideoFile, VIDEO_FILES } from '../model/exchange.js';
import { SORTS, arrange } from '../model/library_order.js';
import { may } from '../model/team.js';
import { hideBanner, openDialog, setRuns, setSession, setVideos } from '../store/actions/page.js';
import { h, setText } from './dom.js';
import { loadingState } from './placeholders.js';
import { count, plural } from '../model/format.js';
import { icon } from './icons.js';
import { CARDS_PER_STEP, createCards } from './library_list.js';
import { NO_FILTERS, createLibraryFilters } from './library_filters.js';
import { noMatch, noVideo, notLoaded } from './library_notices.js';
import { createRunAll } from './library_run_all.js';
import { acceptFileDrops } from './file_drop.js';
import { createSelection } from './library_selection.js';
import { createUploads } from './library_uploads.js';
import { createWelcome } from './library_welcome.js';
import { createAssignmentLists } from './library_assignments.js';
import { recall, remember } from '../core/preferences.js';
import { toast } from '../core/toast.js';
import { pageHeading } from './headings.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../state-types.js').State} State */
/** @typedef {import('../types.js').Video} Video */

/** The user's place in the library, to return to after a review. @type {WeakMap<App, {search: string, most: number, top: number, chosen: import('./library_filters.js').LibraryFilters}>} */
const places = new WeakMap();

/**
 * @param {App} app
 * @returns {import('../page-types.js').View}
 */
export function createLibrary(app) {
  const { store, api } = app;
  const ended = new AbortController();
  const signal = AbortSignal.any([ended.signal, app.signal]);
  const place = places.get(app) ?? { search: '', most: CARDS_PER_STEP, top: 0, chosen: NO_FILTERS };
  places.set(app, place);
  const search = h('input.input', {
    type: 'search',
    placeholder: 'Name or folder',
    'aria-label': 'Search videos',
    value: place.search,
    oninput: turn,
  });
  const sort = h(
    'select.select',
    {
      'aria-label': 'Order of the videos',
      onchange: () => {
        remember('library.sort', sort.value);
        turn();
      },
    },
    ...Object.entries(SORTS).map(([value, { label }]) => h('option', { value }, label)),
  );
  sort.value = recall('library.sort') ?? 'newest';
  if (!sort.value) sort.value = 'newest';
  const files = h('input.visually-hidden', {
    type: 'file',
    accept: VIDEO_FILES,
    multiple: true,

    tabIndex: -1,
    'aria-label': 'Video files to upload',
    onchange: () => {
      uploads.add([...(files.files ?? [])]);
      files.value = '';
    },
  });
  const addVideo = () => store.dispatch(openDialog, { kind: 'add-video' });
  const uploads = createUploads(app, signal);
  const filters = createLibraryFilters(app, {
    chosen: place.chosen,
    signal,
    changed: (chosen) => {
      if (JSON.stringify(chosen) !== JSON.stringify(place.chosen)) {
        place.most = CARDS_PER_STEP;
        cards.restart();
      }
      place.chosen = chosen;
      found = null;
      show();
    },
  });
  const runAll = createRunAll(app);
  const welcome = createWelcome(app);
  const work = createAssignmentLists();
  const welcomePlace = h('div', welcome.element);
  const total = h('span.muted');
  const selection = createSelection(app, () => cards.draw());
  const cards = createCards(app, {
    cardCount: place.most,
    selection,
    onGrow: (most) => {
      place.most = most;
      if (last) void loadRuns((found ?? []).slice(0, most));
    },
  });
  const layout = h('button.btn.btn-icon', {
    onclick: () => {
      remember('library.layout', recall('library.layout') === 'rows' ? 'cards' : 'rows');
      showLayout();
    },
  });
  const runQueue = h(
    'button.btn',
    {
      title: 'Running and waiting runs, and their order',
      onclick: () => store.dispatch(openDialog, { kind: 'run-queue' }),
    },
    icon('sort'),
    'Run queue',
  );
  const notice = h('div.library-notice', loadingState('Loading the videos', { retry: load, signal }));
  const element = h(
    'div.library',
    h(
      'div.library-inner',
      pageHeading(
        'Library',
        total,
        h('div.input-with-icon.library-search', icon('search'), search),
        sort,
        layout,
        h('button.btn', { onclick: addVideo }, icon('folder'), 'Add from folder'),
        h('button.btn', { onclick: () => files.click() }, icon('upload'), 'Upload'),
        files,
        runAll.element,
        runQueue,
        h(
          'button.btn',
          {
            title: 'Annotations of one or several videos',
            onclick: () => store.dispatch(openDialog, { kind: 'export' }),
          },
          icon('export'),
          'Export',
        ),
        h(
          'button.btn',
          {
            title: 'Add somebody’s bug bundle to the library',
            onclick: () => store.dispatch(openDialog, { kind: 'import-bundle' }),
          },
          icon('bug'),
          'Open bug bundle',
        ),
      ),
      filters.element,
      uploads.element,
      work.element,
      welcomePlace,
      notice,
      selection.element,
      cards.element,
    ),
    h('div.drop-hint', { 'aria-hidden': 'true' }, icon('upload'), h('span', 'Drop videos to upload them, annotations on their video')),
  );
  acceptFileDrops(element, (dropped) => {
    uploads.add(dropped.filter(isVideoFile));
    const data = dropped.find((file) => !isVideoFile(file));
    if (!data) return;
    if (/\.zip$/i.test(data.name)) store.dispatch(openDialog, { kind: 'import-bundle', data: { file: data } });
    else toast('Drop annotations onto the video that they belong to.');
  });
  /** @type {Set<string>} */
  const asked = new Set();
  /** @type {State|null} */
  let last = null;
  /** The shown videos; null: to be sorted again. @type {Video[]|null} */
  let found = [];
  let arranged = '';
  /** @type {readonly Video[]|null} */
  let of = null;
  let noticed = 'waiting';

  async function load() {
    try {
      await app.load(
        () => Promise.all([api.session({ signal }), api.videos({ signal })]),
        (state, [session, videos]) => hideBanner(setVideos(setSession(state, session), videos), 'load'),
      );
    } catch (thrown) {
      if (signal.aborted) return;
      noticed = 'error';
      notice.replaceChildren(
        notLoaded(thrown, () => {
          noticed = 'waiting';
          notice.replaceChildren(loadingState('Loading the videos', { retry: load, signal }));
          void load();
        }),
      );
    }
  }

  /** Load the runs of the videos with cards. @param {readonly Video[]} videos */
  async function loadRuns(videos) {
    for (const video of videos.filter(({ id, runs }) => runs > 0 && !asked.has(id))) {
      asked.add(video.id);
      if (store.get().runs[video.id]) continue;
      try {
        await app.load(
          () => api.runs(video.id, { signal }),
          (state, runs) => setRuns(state, video.id, runs),
        );
      } catch {
        if (signal.aborted) return; // A card is useful without its progress.
      }
    }
  }

  /** @param {string} kind @param {() => HTMLElement} [create] */
  function notify(kind, create) {
    notice.hidden = kind === 'none';
    if (noticed === kind) return;
    noticed = kind;
    notice.replaceChildren(...(create ? [create()] : []));
  }

  function showLayout() {
    const rows = recall('library.layout') === 'rows';
    cards.asRows(rows);
    layout.replaceChildren(icon(rows ? 'grid' : 'rows'));
    layout.title = rows ? 'Show cards' : 'Show rows';
    layout.setAttribute('aria-label', layout.title);
  }

  /** Show another search or order. */
  function turn() {
    place.search = search.value;
    place.most = CARDS_PER_STEP;
    cards.restart();
    show();
  }

  function show() {
    const state = last;
    if (!state || state.videos === null) return;
    const wanted = `${sort.value} ${search.value}`;
    const passing = filters.passing();
    if (found === null || wanted !== arranged || of !== state.videos)
      found = arrange(state.videos, search.value, sort.value).filter(({ id }) => passing === null || passing.has(id));
    [arranged, of] = [wanted, state.videos];
    filters.element.hidden = state.videos.length === 0;
    welcomePlace.hidden = search.value !== '' || passing !== null;
    setText(
      total,
      found.length === state.videos.length
        ? plural(found.length, 'video')
        : `${count(found.length)} of ${plural(state.videos.length, 'video')}`,
    );
    selection.show(found, state.videos);
    cards.show(found, state.runs);
    runAll.show(found);
    void loadRuns(found.slice(0, place.most));
    if (state.videos.length === 0) {
      notify('empty', () => noVideo(addVideo, () => files.click()));
    } else if (found.length === 0) {
      notify('nothing', () =>
        noMatch(() => {
          search.value = '';
          filters.reset();
          turn();
          search.focus();
        }),
      );
    } else {
      notify('none');
    }
  }

  showLayout();
  if (store.get().videos === null) void load();
  return {
    element,
    update(state) {
      const before = last;
      last = state;
      welcome.update(state);
      filters.update(state);
      work.update(state);
      element.classList.toggle('library-closed', !may(state.session, 'reviewer'));
      if (
        before &&
        before.videos === state.videos &&
        before.runs === state.runs &&
        before.assignments === state.assignments &&
        before.session === state.session
      )
        return;
      show();
      if (!before && state.videos && place.top) element.parentElement?.scrollTo({ top: place.top });
    },
    destroy() {
      place.top = element.parentElement?.scrollTop ?? 0;
      ended.abort();
      filters.destroy();
      cards.destroy();
      element.remove();
    },
  };
}
