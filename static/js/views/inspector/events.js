// @ts-check
/** One sentence per event of the track, linked to its frame. Repeated events are folded into one line. */

import { groupEvents } from '../../model/event_groups.js';
import { seek } from '../../store/actions/review.js';
import { h, reconcile, setAttribute, setText } from '../dom.js';
import { count } from '../../model/format.js';

/** Number of sentences shown before "Show all". */
const MAX_SHOWN = 60;

/** @param {import('../../page-types.js').ViewApp} app */
export function createEvents(app) {
  const list = h('ol.events');
  const total = h('span.small.muted');
  const more = h('button.btn-link.small', { onclick: showAll }, 'Show all');
  /** @type {import('../../types.js').TrackLane|null} */ let lane = null;
  /** @type {import('../../model/event_groups.js').EventGroup[]} */ let stretches = [];
  /** @type {Set<string>} */ let unfolded = new Set();
  let showsAll = false;
  let frame = 0;
  /** null: nothing is shown yet @type {boolean|null} */ let isLoaded = null;
  list.addEventListener('click', (event) => {
    const button = /** @type {HTMLElement} */ (event.target).closest('button');
    if (button?.dataset.frame) app.store.dispatch(seek, Number(button.dataset.frame));
    if (button?.dataset.fold) {
      if (!unfolded.delete(button.dataset.fold)) unfolded.add(button.dataset.fold);
      draw();
    }
  });

  function showAll() {
    showsAll = true;
    draw();
  }

  function draw() {
    const lines = (showsAll ? stretches : stretches.slice(0, MAX_SHOWN)).flatMap((stretch, i) => {
      const key = `${lane?.id}-${i}-${stretch.kind}-${stretch.frame}`;
      const { kind, frame: first, last, sentences } = stretch;
      const inner = (unfolded.has(key) ? sentences : []).map(({ frame: at, text }) => {
        return { key: `${key}-${at}`, first: at, last: at, kind, text, count: 0 };
      });
      return [{ key, first, last, kind, text: sentences[0].text, count: sentences.length }, ...inner];
    });
    reconcile(
      list,
      lines,
      (line) => line.key,
      lineElement,
      (element, line) => {
        const isCurrent = line.first <= frame && frame <= line.last && !(line.count > 1 && unfolded.has(line.key));
        setAttribute(element, 'aria-current', isCurrent ? 'true' : null);
        const fold = element.querySelector('[data-fold]');
        if (fold) {
          setAttribute(fold, 'aria-expanded', String(unfolded.has(line.key)));
          setText(fold, unfolded.has(line.key) ? 'fold' : `all ${line.count}`);
        }
      },
    );
    more.hidden = showsAll || stretches.length <= MAX_SHOWN;
    if (!isLoaded) setText(total, 'loading…');
    else setText(total, stretches.length > MAX_SHOWN && !showsAll ? `${MAX_SHOWN} of ${count(stretches.length)}` : count(stretches.length));
  }

  return {
    element: h('div.inspector-section', h('div.row', h('h3', 'Events'), total, h('span.grow'), more), list),
    /** @param {import('./index.js').Inspected} inspected */
    update(inspected) {
      if (inspected.lane === lane && inspected.review.frame === frame && inspected.isLoaded === isLoaded) return;
      isLoaded = inspected.isLoaded;
      if (inspected.lane !== lane) {
        lane = inspected.lane;
        stretches = groupEvents(inspected.sentences);
        unfolded = new Set();
        showsAll = false;
      }
      frame = inspected.review.frame;
      draw();
    },
  };
}

/**
 * @typedef {object} Line
 * @property {string} key
 * @property {number} first
 * @property {number} last
 * @property {string} kind
 * @property {string} text
 * @property {number} count   number of sentences folded into it; 0: it belongs to a folded line
 */

/** @param {Line} line @returns {HTMLElement} */
function lineElement(line) {
  const rangeText = line.count > 1 ? `frames ${line.first} to ${line.last}` : `frame ${line.first}`;
  const element = h(
    'li',
    { class: `event event-${line.kind}${line.count ? '' : ' event-inner'}` },
    h('button.btn-link', { dataset: { frame: String(line.first) } }, rangeText),
    line.count > 1 ? `, the first: ${line.text} ` : `: ${line.text}`,
  );
  if (line.count > 1) element.append(h('button.btn-link', { dataset: { fold: line.key } }));
  return element;
}
