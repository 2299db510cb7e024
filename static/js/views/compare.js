// @ts-check
/** Comparison of two versions of one video: figures, confusion of classes, and the places behind every number. */

import { openDialog, setRuns } from '../store/actions/page.js';
import { createConfusion } from './compare-confusion.js';
import { createFigures } from './compare-figures.js';
import { createPlaces } from './compare-places.js';
import { fill, h, setText } from './dom.js';
import { failure, waiting } from './empty.js';
import { count, plural } from '../model/format.js';
import { icon } from './icons.js';
import { modelsOf } from './model-words.js';
import { runInexact } from '../model/describe_run.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../api/compare-types.js').Comparison} Comparison */
/** @typedef {import('../api/compare-types.js').Side} Side */

/** The list of places that was shown last, to return to it from the review. @type {{sides: string, places: import('../api/compare-types.js').Places}|null} */
let last = null;

const KINDS = /** @type {Record<string, string>} */ ({ run: 'Run', annotation: 'Corrections', truth: 'Ground truth' });

/**
 * @param {App} app
 * @returns {import('../page-types.js').View}
 */
export function createCompare(app) {
  const ended = new AbortController();
  const signal = AbortSignal.any([ended.signal, app.signal]);
  const content = h('div.compare-content');
  const element = h('div.compare', content);
  /** @type {AbortController|null} */
  let under = null;
  let key = '';
  /** The open comparison. @type {{found: Comparison, cards: HTMLElement[]}|null} */
  let open = null;

  /** @param {string} a @param {string} b */
  async function load(a, b) {
    under?.abort();
    const own = new AbortController();
    under = own;
    const both = AbortSignal.any([own.signal, signal]);
    content.replaceChildren(
      h('h1.visually-hidden', 'Compare'),
      waiting('Comparing', { retry: () => load(a, b), signal: both, after: 20_000 }),
    );
    try {
      const found = await app.api.compare(a, b, { signal: both });
      const labels = app.store.get().labels.length ? app.store.get().labels : await app.api.labels(null, { signal: both });
      if (both.aborted) return;
      show(found, a, b, labels);
      tellRuns(app.store.get());
      if (!app.store.get().runs[found.video_id]) {
        await app.load(
          () => app.api.runs(found.video_id, { signal: both }),
          (state, runs) => setRuns(state, found.video_id, runs),
        );
      }
    } catch (thrown) {
      if (both.aborted) return;
      content.replaceChildren(
        h('h1.visually-hidden', 'Compare'),
        failure('This comparison is not possible', thrown, () => load(a, b), h('a.btn', { href: '#/' }, 'Go to the library')),
      );
    }
  }

  /**
   * @param {Comparison} found
   * @param {string} a
   * @param {string} b
   * @param {import('../types.js').Label[]} labels
   */
  function show(found, a, b, labels) {
    const places = createPlaces(app, found, labels, () => void load(a, b));
    const cards = [sideCard('Reference', found.sides.reference), sideCard('Candidate', found.sides.candidate)];
    open = { found, cards };
    /** @param {import('../api/compare-types.js').Places} chosen */
    const choose = (chosen) => {
      last = { sides: `${a} ${b}`, places: chosen };
      places.show(chosen);
    };
    const video = app.store.get().videos?.find(({ id }) => id === found.video_id);
    fill(
      content,
      h(
        'header.compare-head',
        h('h1', 'Compare'),
        video && h('span.muted', `${video.name}, frames ${count(found.first)} to ${count(found.last)}`),
        h('span.grow'),
        h(
          'button.btn',
          {
            onclick: () =>
              app.store.dispatch(openDialog, {
                kind: 'compare',
                data: { video: found.video_id, run: runOf(b) ?? runOf(a), reference: a, candidate: b },
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
        h('div.compare-numbers', createFigures(found, choose), createConfusion(found, labels, choose)),
        places.element,
      ),
    );
    if (last?.sides === `${a} ${b}`) places.show(last.places);
  }

  /** Show the models behind the runs of both sides, and which runs are not exact. Runs and versions may load later than the figures. @param {import('../state-types.js').State} state */
  function tellRuns(state) {
    if (open === null) return;
    for (const [at, side] of [open.found.reference, open.found.candidate].entries()) {
      const run = state.runs[open.found.video_id]?.find(({ id }) => id === runOf(side));
      const words = /** @type {HTMLElement} */ (open.cards[at].querySelector('.side-models'));
      setText(words, run ? modelsOf(run, state.models) : '');
      words.hidden = !words.textContent;
      setText(/** @type {HTMLElement} */ (open.cards[at].querySelector('.side-inexact')), run ? runInexact(run) : '');
    }
  }

  return {
    element,
    update(state) {
      if (state.route.screen !== 'compare') return;
      tellRuns(state);
      const next = `${state.route.a} ${state.route.b}`;
      if (next === key) return;
      key = next;
      void load(state.route.a, state.route.b);
    },
    destroy() {
      ended.abort();
      element.remove();
    },
  };
}

/** @param {string} side */
function runOf(side) {
  return side.startsWith('truth:') ? undefined : side.split(':')[1];
}

/**
 * @param {string} role
 * @param {Side} side
 */
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
