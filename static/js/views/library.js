// @ts-check
/** The first screen: all videos with their progress, and ways to add videos. */

import { isVideoFile, VIDEO_FILES } from '../model/exchange.js';
import { SORTS, arrange } from '../model/library_order.js';
import { hasRole } from '../model/team.js';
import { openDialog } from '../store/actions/page.js';
import { h, selectInput, setText } from './dom.js';
import { emptyState, loadingState } from './placeholders.js';
import { count, plural } from '../model/format.js';
import { icon } from './icons.js';
import { CARDS_PER_STEP, createCards } from './library_list.js';
import { NO_FILTERS, createLibraryFilters } from './library_filters.js';
import { createRunAll } from './library_run_all.js';
import { acceptFileDrops } from './file_drop.js';
import { createSelection } from './library_selection.js';
import { createWelcome } from './library_welcome.js';
import { createAssignmentLists } from './library_assignments.js';
import { recall, remember } from '../core/preferences.js';
import { toast } from '../core/toast.js';
import { pageHeading } from './headings.js';
import { loadMissingRuns } from './load_runs.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../state-types.js').State} State */
/** @typedef {import('../types.js').Video} Video */

/** The user's place in the library, to return to after a review. @type {WeakMap<App, {searchText: string, cardCount: number, top: number, filters: import('./library_filters.js').LibraryFilters}>} */
const savedStates = new WeakMap();

/**
 * @param {App} app
 * @param {ReturnType<import('./library_uploads.js').createUploads>} uploads
 * @returns {import('../page-types.js').View}
 */
export function createLibrary(app, uploads) {
  const { store } = app;
  const lifetime = new AbortController();
  const signal = AbortSignal.any([lifetime.signal, app.signal]);
  const saved = savedStates.get(app) ?? { searchText: '', cardCount: CARDS_PER_STEP, top: 0, filters: NO_FILTERS };
  savedStates.set(app, saved);
  const searchInput = h('input.input', {
    type: 'search',
    placeholder: 'Name or folder',
    'aria-label': 'Search videos',
    value: saved.searchText,
    oninput: onSearchChange,
  });
  const sortSelect = selectInput(
    {
      'aria-label': 'Order of the videos',
      onchange: () => {
        remember('library.sort', sortSelect.value);
        onSearchChange();
      },
    },
    Object.entries(SORTS).map(([value, { label }]) => [value, label]),
    recall('library.sort') ?? 'newest',
  );
  if (!sortSelect.value) sortSelect.value = 'newest';
  const fileInput = h('input.visually-hidden', {
    type: 'file',
    accept: VIDEO_FILES,
    multiple: true,
    tabIndex: -1,
    'aria-label': 'Video files to upload',
    onchange: () => {
      uploads.add([...(fileInput.files ?? [])]);
      fileInput.value = '';
    },
  });
  const addVideo = () => store.dispatch(openDialog, { kind: 'add-video' });
  const filters = createLibraryFilters(app, {
    initialFilters: saved.filters,
    signal,
    onChange: (chosen) => {
      if (JSON.stringify(chosen) !== JSON.stringify(saved.filters)) {
        saved.cardCount = CARDS_PER_STEP;
        cards.restart();
      }
      saved.filters = chosen;
      shownVideos = null;
      show();
    },
  });
  const runAll = createRunAll(app);
  const welcome = createWelcome(app);
  const work = createAssignmentLists();
  const welcomePlace = h('div', welcome.element);
  const totalText = h('span.muted');
  const selection = createSelection(app, () => cards.draw());
  const cards = createCards(app, {
    cardCount: saved.cardCount,
    selection,
    onGrow: (cardCount) => {
      saved.cardCount = cardCount;
      if (lastState) void loadRunsOf((shownVideos ?? []).slice(0, cardCount));
    },
  });
  const layoutButton = h('button.btn.btn-icon', {
    onclick: () => {
      remember('library.layout', recall('library.layout') === 'rows' ? 'cards' : 'rows');
      showLayout();
    },
  });
  const runQueueButton = h(
    'button.btn',
    { title: 'Running and waiting runs, and their order', onclick: () => store.dispatch(openDialog, { kind: 'run-queue' }) },
    icon('sort'),
    'Run queue',
  );
  const notice = h('div.library-notice', loadingState('Loading the videos', { signal }));
  const element = h(
    'div.library',
    h(
      'div.library-inner',
      pageHeading(
        'Library',
        totalText,
        h('div.input-with-icon.library-search', icon('search'), searchInput),
        sortSelect,
        layoutButton,
        h('button.btn', { onclick: addVideo }, icon('folder'), 'Add from folder'),
        h('button.btn', { onclick: () => fileInput.click() }, icon('upload'), 'Upload'),
        fileInput,
        runAll.element,
        runQueueButton,
        h(
          'button.btn',
          { title: 'Annotations of one or several videos', onclick: () => store.dispatch(openDialog, { kind: 'export' }) },
          icon('export'),
          'Export',
        ),
        h(
          'button.btn',
          { title: 'Add somebody’s bug bundle to the library', onclick: () => store.dispatch(openDialog, { kind: 'import-bundle' }) },
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
  /** @type {Set<string>} */ const requestedRuns = new Set();
  /** @type {State|null} */ let lastState = null;
  /** The shown videos; null: to be sorted again. @type {Video[]|null} */
  let shownVideos = [];
  let shownOrder = '';
  /** @type {readonly Video[]|null} */ let sourceVideos = null;
  let noticeKind = 'waiting';

  /** Load the runs of the videos with cards. @param {readonly Video[]} videos */
  async function loadRunsOf(videos) {
    for (const video of videos.filter(({ id, runs }) => runs > 0 && !requestedRuns.has(id))) {
      requestedRuns.add(video.id);
      try {
        await loadMissingRuns(app, video.id, { signal });
      } catch {
        if (signal.aborted) return; // A card is useful without its progress.
      }
    }
  }

  /** @param {string} kind @param {() => HTMLElement} [create] */
  function showNotice(kind, create) {
    notice.hidden = kind === 'none';
    if (noticeKind === kind) return;
    noticeKind = kind;
    notice.replaceChildren(...(create ? [create()] : []));
  }

  function showLayout() {
    const rows = recall('library.layout') === 'rows';
    cards.setRowLayout(rows);
    layoutButton.replaceChildren(icon(rows ? 'grid' : 'rows'));
    layoutButton.title = rows ? 'Show cards' : 'Show rows';
    layoutButton.setAttribute('aria-label', layoutButton.title);
  }

  /** Show another search or order. */
  function onSearchChange() {
    saved.searchText = searchInput.value;
    saved.cardCount = CARDS_PER_STEP;
    cards.restart();
    show();
  }

  function show() {
    const state = lastState;
    if (!state || state.videos === null) return;
    const order = `${sortSelect.value} ${searchInput.value}`;
    const matches = filters.matches();
    if (shownVideos === null || order !== shownOrder || sourceVideos !== state.videos)
      shownVideos = arrange(state.videos, searchInput.value, sortSelect.value).filter(({ id }) => matches === null || matches.has(id));
    [shownOrder, sourceVideos] = [order, state.videos];
    filters.element.hidden = state.videos.length === 0;
    welcomePlace.hidden = searchInput.value !== '' || matches !== null;
    setText(
      totalText,
      shownVideos.length === state.videos.length
        ? plural(shownVideos.length, 'video')
        : `${count(shownVideos.length)} of ${plural(state.videos.length, 'video')}`,
    );
    selection.show(shownVideos, state.videos);
    cards.show(shownVideos, state.runs);
    runAll.show(shownVideos);
    void loadRunsOf(shownVideos.slice(0, saved.cardCount));
    if (state.videos.length === 0) {
      showNotice('empty', () => noVideoNotice(addVideo, () => fileInput.click()));
    } else if (shownVideos.length === 0) {
      showNotice('nothing', () =>
        noMatchNotice(() => {
          searchInput.value = '';
          filters.reset();
          onSearchChange();
          searchInput.focus();
        }),
      );
    } else {
      showNotice('none');
    }
  }

  showLayout();
  return {
    element,
    update(state) {
      const previousState = lastState;
      lastState = state;
      welcome.update(state);
      filters.update(state);
      work.update(state);
      element.classList.toggle('library-closed', !hasRole(state.session, 'reviewer'));
      if (
        previousState &&
        previousState.videos === state.videos &&
        previousState.runs === state.runs &&
        previousState.assignments === state.assignments &&
        previousState.session === state.session
      )
        return;
      show();
      if (!previousState && state.videos && saved.top) element.parentElement?.scrollTo({ top: saved.top });
    },
    destroy() {
      saved.top = element.parentElement?.scrollTop ?? 0;
      lifetime.abort();
      filters.destroy();
      cards.destroy();
    },
  };
}

/** @param {() => void} addVideo @param {() => void} upload */
const noVideoNotice = (addVideo, upload) =>
  emptyState({
    icon: 'film',
    title: 'No video yet',
    text: 'Add a video from this machine, upload one, or drop files anywhere on this page. Nothing leaves this machine.',
    actions: [
      h('button.btn.btn-primary', { onclick: addVideo }, icon('folder'), 'Add from folder'),
      h('button.btn', { onclick: upload }, icon('upload'), 'Upload'),
    ],
  });

/** @param {() => void} clear */
const noMatchNotice = (clear) =>
  emptyState({
    icon: 'search',
    title: 'No video matches',
    text: 'The search covers names and folders; every word must occur. The filters cover the tracks of the run that opens with a video.',
    actions: [h('button.btn', { onclick: clear }, 'Clear search and filters')],
  });
