// @ts-check
/** The videos to export, and the run of each. */

import { h, reconcile, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { runTitle } from '../../model/describe_run.js';

/** @typedef {import('../../state-types.js').State} State */
/** @typedef {import('../../types.js').Video} Video */
/** @typedef {import('../../types.js').Run} Run */

/** Maximum number of rows; the search finds the rest. */
const MAX_ROWS = 200;

/**
 * @param {import('../../page-types.js').App} app
 * @param {string[]} initialRuns   runs selected at first; none: the newest run, if there is only one video
 * @param {() => void} onChange
 * @param {AbortSignal} signal
 */
export function createExportRuns(app, initialRuns, onChange, signal) {
  const search = h('input.input', {
    type: 'search',
    placeholder: 'Search',
    'aria-label': 'Search videos to export',
    oninput: () => show(),
  });
  const list = h('ul.pick-list', { 'aria-label': 'Videos to export' });
  const total = h('span.muted.small', { role: 'status' });
  const element = h('div.field', h('div.row', h('span.field-label.grow', 'Videos'), total), search, list);
  /** Chosen run by video; a video without an entry is not selected. @type {Map<string, string>} */
  const chosenRuns = new Map();
  /** @type {State|null} */ let lastState = null;
  let isInitialised = false;

  /** @param {State} state @param {Video} video @returns {Run[]} */
  const runsOf = (state, video) => (state.runs[video.id] ?? []).filter((run) => run.state === 'complete');

  /** @param {State} state */
  function initialise(state) {
    if (isInitialised || state.videos === null) return;
    const openRun = state.review?.run;
    for (const video of state.videos) {
      const initialRun =
        runsOf(state, video).find(({ id }) => initialRuns.includes(id)) ??
        (openRun && initialRuns.includes(openRun.id) && openRun.video_id === video.id ? openRun : null);
      if (initialRun) chosenRuns.set(video.id, initialRun.id);
    }
    const usableVideos = state.videos.filter(({ latest_run }) => latest_run !== null);
    if (initialRuns.length === 0 && usableVideos.length === 1) chosenRuns.set(usableVideos[0].id, String(usableVideos[0].latest_run));
    isInitialised = initialRuns.length === 0 || chosenRuns.size > 0;
    search.hidden = usableVideos.length < 7;
  }

  function show() {
    if (!lastState || signal.aborted) return;
    const state = lastState;
    const searchWords = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const usableVideos = (state.videos ?? []).filter((video) => video.latest_run !== null);
    const listedVideos = usableVideos
      .filter((video) => chosenRuns.has(video.id) || searchWords.every((word) => video.name.toLowerCase().includes(word)))
      .sort((a, b) => Number(initialRuns.length > 0 && chosenRuns.has(b.id)) - Number(initialRuns.length > 0 && chosenRuns.has(a.id)));
    reconcile(
      list,
      listedVideos.slice(0, MAX_ROWS),
      ({ id }) => id,
      create,
      (item, video) => showRow(state, item, video),
    );
    setText(
      total,
      usableVideos.length === 0
        ? 'No complete run yet'
        : `${chosenRuns.size} of ${plural(usableVideos.length, 'video')}${listedVideos.length > MAX_ROWS ? `, ${MAX_ROWS} listed: search for others` : ''}`,
    );
  }

  /** @param {Video} video */
  function create(video) {
    const checkbox = h('input', {
      type: 'checkbox',
      checked: chosenRuns.has(video.id),
      onchange: () => {
        if (checkbox.checked) chosenRuns.set(video.id, run.value || String(video.latest_run));
        else chosenRuns.delete(video.id);
        show();
        onChange();
      },
    });
    const run = h('select.select', {
      'aria-label': `Run of ${video.name}`,
      onchange: () => {
        chosenRuns.set(video.id, run.value);
        checkbox.checked = true;
        show();
        onChange();
      },
    });
    return h('li.pick', h('label.tick.grow', checkbox, h('span.truncate', { title: video.path }, video.name)), run);
  }

  /** @param {State} state @param {HTMLElement} item @param {Video} video */
  function showRow(state, item, video) {
    const select = /** @type {HTMLSelectElement} */ (item.querySelector('select'));
    const runs = runsOf(state, video);
    const optionsKey = runs.map((run) => `${run.id} ${runTitle(run)}`).join('\n');
    select.hidden = runs.length === 0;
    if (select.dataset.options !== optionsKey) {
      select.dataset.options = optionsKey;
      select.replaceChildren(...runs.map((run) => h('option', { value: run.id }, runTitle(run))));
    }
    select.value = chosenRuns.get(video.id) ?? String(video.latest_run);
    const checkbox = item.querySelector('input');
    if (checkbox) checkbox.checked = chosenRuns.has(video.id);
  }

  return {
    element,
    chosen: () => [...chosenRuns.values()],
    /** Number of frames of the only video; null: unknown, or several videos. */
    frames: () => (chosenRuns.size === 1 ? (lastState?.videos?.find(({ id }) => chosenRuns.has(id))?.frames ?? null) : null),
    /** @param {State} state */
    update(state) {
      if (lastState && lastState.videos === state.videos && lastState.runs === state.runs) return;
      lastState = state;
      const previousSize = chosenRuns.size;
      initialise(state);
      show();
      if (chosenRuns.size !== previousSize) onChange();
    },
  };
}
