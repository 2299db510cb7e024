// @ts-check
/**
 * The cards of the library. Only as many as have been scrolled to exist, so that thousands of videos cost what a
 * screenful costs; further ones are made before the last is reached, with wheel, keyboard or the button alike.
 */

import { h, reconcile, setText } from './dom.js';
import { count } from '../model/format.js';
import { createCard } from './library-card.js';

/** @typedef {import('../types.js').Run} Run */
/** @typedef {import('../types.js').Video} Video */

/** Cards that are made at once: more than a 4K screen shows. */
export const STEP = 48;
/** How far below the screen the end may be before more are made, in heights of the screen. */
const AHEAD = '100%';

/**
 * @param {import('../page-types.js').App} app
 * @param {{most: number, grown: (most: number) => void, selection: Pick<ReturnType<typeof import('./library-selection.js').createSelection>, 'has'|'choose'>}} options
 *   most: cards to begin with; grown: told when there are more; selection: of videos
 * @returns {{element: HTMLElement, show: (videos: readonly Video[], runs: Record<string, Run[]>) => void, draw: () => void, asRows: (rows: boolean) => void, restart: () => void, destroy: () => void}}
 */
export function createCards(app, { most, grown, selection }) {
  const list = h('ul.cards', { 'aria-label': 'Videos' });
  const more = h('button.btn.library-more', {
    hidden: true,
    onclick: () => {
      const next = grow();
      // whoever asked by keyboard goes on with the first new one
      if (next) /** @type {HTMLElement|null} */ (next.querySelector('a, button'))?.focus();
    },
  });
  const element = h('div.library-list', list, more);
  /** @type {WeakMap<HTMLElement, ReturnType<typeof createCard>>} */
  const cards = new WeakMap();
  /** @type {readonly Video[]} */
  let all = [];
  /** @type {Record<string, Run[]>} */
  let runsOf = {};
  /** @type {IntersectionObserver|null} */
  let observer = null;

  function draw() {
    reconcile(
      list,
      all.slice(0, most),
      ({ id }) => id,
      (video) => {
        const card = createCard(app, video, (on, range) => selection.choose(video.id, on, range));
        cards.set(card.element, card);
        return card.element;
      },
      (item, video) => cards.get(item)?.show(video, runsOf[video.id], selection.has(video.id)),
    );
    const left = all.length - most;
    more.hidden = left <= 0;
    setText(more, `Show more (${count(Math.max(0, left))} left)`);
  }

  /** @returns {Element|null} the first of the new cards */
  function grow() {
    if (most >= all.length) return null;
    const before = most;
    most += STEP;
    draw();
    grown(most);
    return list.children[before] ?? null;
  }

  /** The scrolling element is known once the list stands in the page. */
  function watch() {
    const root = element.closest('.screen');
    if (observer !== null || root === null) return;
    observer = new IntersectionObserver(
      (entries) => {
        if (!entries.some(({ isIntersecting }) => isIntersecting) || grow() === null) return;
        // where the end is still near, no change of intersection would be reported
        observer?.unobserve(more);
        observer?.observe(more);
      },
      { root, rootMargin: `0px 0px ${AHEAD} 0px` },
    );
    observer.observe(more);
  }

  return {
    element,
    show(videos, runs) {
      [all, runsOf] = [videos, runs];
      draw();
      watch();
    },
    draw,
    asRows: (rows) => void list.classList.toggle('cards-rows', rows),
    /** Another search or order: from the top again. */
    restart() {
      most = STEP;
    },
    destroy() {
      observer?.disconnect();
      element.remove();
    },
  };
}
