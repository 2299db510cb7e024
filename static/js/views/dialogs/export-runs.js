// @ts-check
/** The videos to export, and the run of each. */

import { h, reconcile, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { runTitle } from '../../model/describe_run.js';

/** @typedef {import('../../state-types.js').State} State */
/** @typedef {import('../../types.js').Video} Video */
/** @typedef {import('../../types.js').Run} Run */

/** Maximum number of rows; the search finds the rest. */
const LISTED = 200;

/**
 * @param {import('../../page-types.js').App} app
 * @param {string[]} first     runs selected at first; none: the newest run, if there is only one video
 * @param {() => void} changed
 * @param {AbortSignal} signal
 */
export function createExportRuns(app, first, changed, signal) {
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
  const chosen = new Map();
  /** @type {State|null} */
  let last = null;
  let begun = false;

  /** @param {State} state @param {Video} video @returns {Run[]} */
  const runsOf = (state, video) => (state.runs[video.id] ?? []).filter((run) => run.state === 'complete');

  /** @param {State} state */
  function begin(state) {
    if (begun || state.videos === null) return;
    const own = state.review?.run;
    for (const video of state.videos) {
      const given =
        runsOf(state, video).find(({ id }) => first.includes(id)) ??
        (own && first.includes(own.id) && own.video_id === video.id ? own : null);
      if (given) chosen.set(video.id, given.id);
    }
    const usable = state.videos.filter(({ latest_run }) => latest_run !== null);
    if (first.length === 0 && usable.length === 1) chosen.set(usable[0].id, String(usable[0].latest_run));
    begun = first.length === 0 || chosen.size > 0;
    search.hidden = usable.length < 7;
  }

  function show() {
    if (!last || signal.aborted) return;
    const state = last;
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const usable = (state.videos ?? []).filter((video) => video.latest_run !== null);
    const found = usable
      .filter((video) => chosen.has(video.id) || words.every((word) => video.name.toLowerCase().includes(word)))
      .sort((a, b) => Number(first.length > 0 && chosen.has(b.id)) - Number(first.length > 0 && chosen.has(a.id)));
    reconcile(
      list,
      found.slice(0, LISTED),
      ({ id }) => id,
      create,
      (item, video) => showRow(state, item, video),
    );
    setText(
      total,
      usable.length === 0
        ? 'No complete run yet'
        : `${chosen.size} of ${plural(usable.length, 'video')}${found.length > LISTED ? `, ${LISTED} listed: search for others` : ''}`,
    );
  }

  /** @param {Video} video */
  function create(video) {
    const box = h('input', {
      type: 'checkbox',
      checked: chosen.has(video.id),
      onchange: () => {
        if (box.checked) chosen.set(video.id, run.value || String(video.latest_run));
        else chosen.delete(video.id);
        show();
        changed();
      },
    });
    const run = h('select.select', {
      'aria-label': `Run of ${video.name}`,
      onchange: () => {
        chosen.set(video.id, run.value);
        box.checked = true;
        show();
        changed();
      },
    });
    return h('li.pick', h('label.tick.grow', box, h('span.truncate', { title: video.path }, video.name)), run);
  }

  /** @param {State} state @param {HTMLElement} item @param {Video} video */
  function showRow(state, item, video) {
    const select = /** @type {HTMLSelectElement} */ (item.querySelector('select'));
    const runs = runsOf(state, video);
    const wanted = runs.map((run) => `${run.id} ${runTitle(run)}`).join('\n');
    select.hidden = runs.length === 0;
    if (select.dataset.options !== wanted) {
      select.dataset.options = wanted;
      select.replaceChildren(...runs.map((run) => h('option', { value: run.id }, runTitle(run))));
    }
    select.value = chosen.get(video.id) ?? String(video.latest_run);
    const box = item.querySelector('input');
    if (box) box.checked = chosen.has(video.id);
  }

  return {
    element,
    chosen: () => [...chosen.values()],
    /** Number of frames of the only video; null: unknown, or several videos. */
    frames: () => (chosen.size === 1 ? (last?.videos?.find(({ id }) => chosen.has(id))?.frames ?? null) : null),
    /** @param {State} state */
    update(state) {
      if (last && last.videos === state.videos && last.runs === state.runs) return;
      last = state;
      const before = chosen.size;
      begin(state);
      show();
      if (chosen.size !== before) changed();
    },
  };
}
