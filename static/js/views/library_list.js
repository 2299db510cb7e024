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
const LOOKAHEAD_MARGIN = '100%';

/**
 * @param {import('../page-types.js').App} app
 * @param {{cardCount: number, onGrow: (cardCount: number) => void, selection: Pick<ReturnType<typeof import('./library_selection.js').createSelection>, 'has'|'choose'>}} options
 *   cardCount: initial number of cards; onGrow: called when there are more; selection: of videos
 * @returns {{element: HTMLElement, show: (videos: readonly Video[], runs: Record<string, Run[]>) => void, draw: () => void, setRowLayout: (rows: boolean) => void, restart: () => void, destroy: () => void}}
 */
export function createCards(app, { cardCount, onGrow, selection }) {
  const list = h('ul.cards', { 'aria-label': 'Videos' });
  const moreButton = h('button.btn.library-more', {
    hidden: true,
    onclick: () => {
      const next = addCards();
      // a keyboard user continues with the first new card
      if (next) /** @type {HTMLElement|null} */ (next.querySelector('a, button'))?.focus();
    },
  });
  const element = h('div.library-list', list, moreButton);
  /** @type {WeakMap<HTMLElement, ReturnType<typeof createCard>>} */ const cards = new WeakMap();
  /** @type {readonly Video[]} */ let allVideos = [];
  /** @type {Record<string, Run[]>} */ let runsOf = {};
  /** @type {IntersectionObserver|null} */ let observer = null;

  function draw() {
    reconcile(
      list,
      allVideos.slice(0, cardCount),
      ({ id }) => id,
      (video) => {
        const card = createCard(app, video, (on, range) => selection.choose(video.id, on, range));
        cards.set(card.element, card);
        return card.element;
      },
      (item, video) => cards.get(item)?.show(video, runsOf[video.id], selection.has(video.id)),
    );
    const hiddenCount = allVideos.length - cardCount;
    moreButton.hidden = hiddenCount <= 0;
    setText(moreButton, `Show more (${count(Math.max(0, hiddenCount))} left)`);
  }

  /** @returns {Element|null} the first of the new cards */
  function addCards() {
    if (cardCount >= allVideos.length) return null;
    const oldCount = cardCount;
    cardCount += CARDS_PER_STEP;
    draw();
    onGrow(cardCount);
    return list.children[oldCount] ?? null;
  }

  /** Watch the end of the list. The scrolling element is known only once the list is in the page. */
  function observeEnd() {
    const root = element.closest('.screen');
    if (observer !== null || root === null) return;
    observer = new IntersectionObserver(
      (entries) => {
        if (!entries.some(({ isIntersecting }) => isIntersecting) || addCards() === null) return;
        // while the end stays near, no change of intersection would be reported
        observer?.unobserve(moreButton);
        observer?.observe(moreButton);
      },
      { root, rootMargin: `0px 0px ${LOOKAHEAD_MARGIN} 0px` },
    );
    observer.observe(moreButton);
  }

  return {
    element,
    show(videos, runs) {
      [allVideos, runsOf] = [videos, runs];
      draw();
      observeEnd();
    },
    draw,
    setRowLayout: (rows) => void list.classList.toggle('cards-rows', rows),
    /** Start at the top again, after another search or order. */
    restart() {
      cardCount = CARDS_PER_STEP;
    },
    destroy: () => observer?.disconnect(),
  };
}
