// @ts-check
/** One sentence on each event of the track, each linked to its frame. */

import { sentencesOf } from '../../model/plain_words.js';
import { seek } from '../app.js';
import { h, reconcile, setAttribute, setText } from '../dom.js';
import { count } from '../format.js';

/** Sentences shown before a person asks for all. */
const SOME = 60;

/** @param {import('../app.js').ViewApp} app @param {AbortSignal} signal */
export function createEvents(app, signal) {
  const list = h('ol', { class: 'events' });
  const total = h('span', { class: 'small muted' });
  const more = h('button', { class: 'btn-link small', type: 'button' }, 'Show all');
  /** @type {import('../../types.js').TrackLane|null} */ let lane = null;
  /** @type {import('../../model/plain_words.js').Sentence[]} */ let sentences = [];
  let all = false;
  let frame = 0;
  more.addEventListener('click', () => {
    all = true;
    draw();
  }, { signal });
  list.addEventListener('click', (event) => {
    const button = /** @type {HTMLElement} */ (event.target).closest('button');
    if (button?.dataset.frame) seek(app, Number(button.dataset.frame));
  }, { signal });

  function draw() {
    const shown = (all ? sentences : sentences.slice(0, SOME)).map((sentence, i) => ({ sentence, i }));
    reconcile(list, shown, ({ sentence, i }) => `${lane?.id}-${sentence.frame}-${i}`, ({ sentence }) => h('li', { class: `event event-${sentence.kind}` },
      h('button', { class: 'btn-link', type: 'button', dataset: { frame: String(sentence.frame) } }, `frame ${sentence.frame}`), `: ${sentence.text}`),
    (element, { sentence }) => setAttribute(element, 'aria-current', sentence.frame === frame ? 'true' : null));
    more.hidden = all || sentences.length <= SOME;
    setText(total, sentences.length > SOME && !all ? `${SOME} of ${count(sentences.length)}` : count(sentences.length));
  }

  return {
    element: h('div', { class: 'inspector-section' }, h('div', { class: 'row' }, h('h3', null, 'Events'), total, h('span', { class: 'grow' }), more), list),
    /** @param {import('./index.js').Inspected} inspected */
    update(inspected) {
      if (inspected.lane === lane && inspected.review.frame === frame) return;
      if (inspected.lane !== lane) {
        lane = inspected.lane;
        sentences = lane ? sentencesOf(lane) : [];
        all = false;
      }
      frame = inspected.review.frame;
      draw();
    },
  };
}
