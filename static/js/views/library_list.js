// @ts-check
/**
 * The cards of the library. Only as many exist as have been scrolled to, so that thousands of videos cost no more than
 * a screenful. More are made before the last one is reached, for wheel, keyboard and button alike.
 */

import { h, reconcile, setText } from './dom.js';
import { count } from '../model/format.js';
import { createCard } from './library_card.js';

/** @typedef {import('../types.js').Run} Run */
/** @typedef {import('../types.js').Video} Video */

/** Number of cards made at a time: more than a 4K screen shows. */
export const CARDS_PER_STEP = 48;
/** Distance of the end below the screen at which more cards are made, in heights of the screen. */
const AHEAD = '100%';

/**
 * @param {import('../page-types.js').App} app
 * @param {{cardCount: number, onGrow: (cardCount: number) => void, selection: Pick<ReturnType<typeof import('./library_selection.js').createSelection>, 'has'|'choose'>}} options
 *   cardCount: initial number of cards; onGrow: called when there are more; selection: of videos
 * @returns {{element: HTMLElement, show: (videos: readonly Video[], runs: Record<string, Run[]>) => void, draw: () => void, asRows: (rows: boolean) => void, restart: () => void, destroy: () => void}}
 */
export function createCards(app, { cardCount, onGrow, selection }) {
  const list = h('ul.cards', { 'aria-label': 'Videos' });
  const more = h('button.btn.library-more', {
    hidden: true,
    onclick: () => {
      const next = grow();
      // a keyboard user continues with the first new card
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
      all.slice(0, cardCount),
      ({ id }) => id,
      (video) => {
        const card = createCard(app, video, (on, range) => selection.choose(video.id, on, range));
        cards.set(card.element, card);
        return card.element;
      },
      (item, video) => cards.get(item)?.show(video, runsOf[video.id], selection.has(video.id)),
    );
    const left = all.length - cardCount;
    more.hidden = left <= 0;
    setText(more, `Show more (${count(Math.max(0, left))} left)`);
  }

  /** @returns {Element|null} the first of the new cards */
  function grow() {
    if (cardCount >= all.length) return null;
    const before = cardCount;
    cardCount += CARDS_PER_STEP;
    draw();
    onGrow(cardCount);
    return list.children[before] ?? null;
  }

  /** Watch the end of the list. The scrolling element is known only once the list is in the page. */
  function watch() {
    const root = element.closest('.screen');
    if (observer !== null || root === null) return;
    observer = new IntersectionObserver(
      (entries) => {
        if (!entries.some(({ isIntersecting }) => isIntersecting) || grow() === null) return;
        // while the end stays near, no change of intersection would be reported
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
    /** Start at the top again, after another search or order. */
    restart() {
      cardCount = CARDS_PER_STEP;
    },
    destroy() {
      observer?.disconnect();
      element.remove();
    },
  };
}
