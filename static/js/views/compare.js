// @ts-check
/** Comparison of two versions of one video: figures, confusion of classes, and the places behind every number. */

import { openDialog } from '../store/actions/page.js';
import { createConfusionMatrix } from './compare_confusion.js';
import { createFigures } from './compare_figures.js';
import { createPlaceList } from './compare_places.js';
import { fill, h, setText } from './dom.js';
import { errorState, loadingState } from './placeholders.js';
import { count, plural } from '../model/format.js';
import { icon } from './icons.js';
import { describeRunModels } from './model_version_text.js';
import { runInexact } from '../model/describe_run.js';
import { loadMissingRuns } from './load_runs.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../api/compare-types.js').Comparison} Comparison */
/** @typedef {import('../api/compare-types.js').Side} Side */

/** The list of places that was shown last, to return to it from the review. @type {{sides: string, places: import('../api/compare-types.js').Places}|null} */
let lastShown = null;

const KINDS = /** @type {Record<string, string>} */ ({ run: 'Run', annotation: 'Corrections', truth: 'Ground truth' });

/** @type {import('../page-types.js').CreateView} */
export function createCompare(app) {
  const lifetime = new AbortController();
  const signal = AbortSignal.any([lifetime.signal, app.signal]);
  const content = h('div.compare-content');
  const element = h('div.compare', content);
  /** @type {AbortController|null} */ let pendingRequest = null;
  let shownKey = '';
  /** The open comparison. @type {{comparison: Comparison, cards: HTMLElement[]}|null} */
  let openComparison = null;

  /** @param {string} a @param {string} b */
  async function load(a, b) {
    pendingRequest?.abort();
    const request = new AbortController();
    pendingRequest = request;
    const requestSignal = AbortSignal.any([request.signal, signal]);
    content.replaceChildren(
      h('h1.visually-hidden', 'Compare'),
      loadingState('Comparing', { retry: () => load(a, b), signal: requestSignal, slowAfterMs: 20_000 }),
    );
    try {
      const comparison = await app.api.compare(a, b, { signal: requestSignal });
      // those in the store belong to the library's set, which the video need not use
      const labels = await app.api.labels(comparison.video_id, { signal: requestSignal });
      if (requestSignal.aborted) return;
      show(comparison, a, b, labels);
      showRuns(app.store.get());
      await loadMissingRuns(app, comparison.video_id, { signal: requestSignal });
    } catch (thrown) {
      if (requestSignal.aborted) return;
      content.replaceChildren(
        h('h1.visually-hidden', 'Compare'),
        errorState('This comparison is not possible', thrown, () => load(a, b), h('a.btn', { href: '#/' }, 'Go to the library')),
      );
    }
  }

  /** @param {Comparison} comparison @param {string} a @param {string} b @param {import('../types.js').Label[]} labels */
  function show(comparison, a, b, labels) {
    const places = createPlaceList(app, comparison, labels, () => void load(a, b));
    const cards = [sideCard('Reference', comparison.sides.reference), sideCard('Candidate', comparison.sides.candidate)];
    openComparison = { comparison, cards };
    /** @param {import('../api/compare-types.js').Places} chosen */
    const choose = (chosen) => {
      lastShown = { sides: `${a} ${b}`, places: chosen };
      places.show(chosen);
    };
    const video = app.store.get().videos?.find(({ id }) => id === comparison.video_id);
    fill(
      content,
      h(
        'header.compare-head',
        h('h1', 'Compare'),
        video && h('span.muted', `${video.name}, frames ${count(comparison.first)} to ${count(comparison.last)}`),
        h('span.grow'),
        h(
          'button.btn',
          {
            onclick: () =>
              app.store.dispatch(openDialog, {
                kind: 'compare',
                data: { video: comparison.video_id, run: runOf(b) ?? runOf(a), reference: a, candidate: b },
              }),
          },
          icon('settings'),
          'Change sides',
        ),
        h('a.btn', { href: `#/compare?a=${encodeURIComponent(b)}&b=${encodeURIComponent(a)}` }, icon('refresh'), 'Swap'),
      ),
      h('div.compare-sides', cards[0], h('span.compare-against.muted', 'against'), cards[1]),
      h(
        'div.compare-columns',
        h('div.compare-numbers', createFigures(comparison, choose), createConfusionMatrix(comparison, labels, choose)),
        places.element,
      ),
    );
    if (lastShown?.sides === `${a} ${b}`) places.show(lastShown.places);
  }

  /** Show the models behind the runs of both sides, and which runs are not exact. Runs and versions may load later than the figures. @param {import('../state-types.js').State} state */
  function showRuns(state) {
    if (openComparison === null) return;
    for (const [index, side] of [openComparison.comparison.reference, openComparison.comparison.candidate].entries()) {
      const run = state.runs[openComparison.comparison.video_id]?.find(({ id }) => id === runOf(side));
      const modelsText = /** @type {HTMLElement} */ (openComparison.cards[index].querySelector('.side-models'));
      setText(modelsText, run ? describeRunModels(run, state.models) : '');
      modelsText.hidden = !modelsText.textContent;
      setText(/** @type {HTMLElement} */ (openComparison.cards[index].querySelector('.side-inexact')), run ? runInexact(run) : '');
    }
  }

  return {
    element,
    update(state) {
      if (state.route.screen !== 'compare') return;
      showRuns(state);
      const next = `${state.route.a} ${state.route.b}`;
      if (next === shownKey) return;
      shownKey = next;
      void load(state.route.a, state.route.b);
    },
    destroy: () => lifetime.abort(),
  };
}

/** @param {string} side */
function runOf(side) {
  return side.startsWith('truth:') ? undefined : side.split(':')[1];
}

/** @param {string} role @param {Side} side */
function sideCard(role, side) {
  return h(
    'section.compare-side',
    { 'aria-label': role },
    h('span.muted.small', `${role} · ${KINDS[side.kind] ?? side.kind}`),
    h('strong.truncate', { title: side.name }, side.name),
    h('span.muted.small', `${plural(side.tracks, 'track')}, ${plural(side.boxes, 'box', 'boxes')}`),
    h('span.side-models.muted.small', { hidden: true }),
    h('span.side-inexact.field-warning'),
  );
}
