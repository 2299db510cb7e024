// @ts-check
/** The bar of the shown ground truth: its name, the chosen sign, and buttons to take signs over. */

import { chosenTruth } from '../../review/chosen_truth.js';
import { toScreen } from '../../model/geometry.js';
import { trackName } from '../../model/track_name.js';
import { truthLabel } from '../../operations/ground_truth.js';
import { runOperation } from '../../operations/registry.js';
import { h, setText } from '../dom.js';
import { toast } from '../../core/toast.js';

const BUTTONS = /** @type {const} */ ([
  ['next-truth', 'Next'],
  ['take-truth-box', 'Take box'],
  ['take-truth-sign', 'Take sign'],
  ['take-truth-label', 'Take all'],
]);

/**
 * @param {import('../../page-types.js').App} app
 * @param {() => {width: number, height: number}} screen   the picture's size, CSS px
 */
export function createTruthBar(app, screen) {
  const badge = h('div.picture-badge');
  const statusText = h('span.truth-words.truncate');
  const buttons = BUTTONS.map(([id, text]) => {
    const operation = app.operations.find((one) => one.id === id);
    const button = h(
      'button.btn.btn-small',
      { title: operation?.tooltip, onclick: () => operation && runOperation(app, operation, (why) => toast(why)) },
      text,
    );
    return { id, operation, button };
  });
  const bar = h('div.truth-bar', { role: 'group', 'aria-label': 'Ground truth' }, statusText, ...buttons.map(({ button }) => button));
  const element = h('div.picture-truth', { hidden: true }, badge, bar);
  // pointer events on the bar must not reach the picture below
  for (const kind of ['pointerdown', 'wheel', 'contextmenu']) bar.addEventListener(kind, (event) => event.stopPropagation());
  /** @type {import('../../state-types.js').ReviewState|null} */ let lastReview = null;

  /** @param {import('../../state-types.js').State} state */
  function update(state) {
    const { review } = state;
    if (review === lastReview) return;
    lastReview = review;
    element.hidden = !review?.layers.truth || review.truthName === null;
    if (!review || element.hidden) return;
    setText(badge, `Ground truth: ${review.truthName ?? ''}`);
    const chosenSign = chosenTruth(review);
    const description =
      chosenSign === null
        ? ''
        : `Sign ${chosenSign.sign}${chosenSign.box === null ? ', no box here' : `: ${truthLabel(state)}, ${chosenSign.on ? `IoU ${chosenSign.on.iou.toFixed(2)} with track ${trackName(chosenSign.on.key, review.docs[chosenSign.on.key])}` : 'on no track'}`}`;
    setText(statusText, description);
    statusText.title = description;
    for (const { id, operation, button } of buttons) {
      button.hidden = chosenSign === null && id !== 'next-truth';
      button.setAttribute('aria-disabled', String(Boolean(operation?.disabled(state))));
      if (id === 'take-truth-label' && chosenSign?.box) setText(button, `Take all “${truthLabel(state)}”`);
    }
    // keep the bar away from its sign
    const [, y] = chosenSign?.box ? toScreen(review.viewport, screen(), 0, (chosenSign.box[1] + chosenSign.box[3]) / 2) : [0, Infinity];
    element.classList.toggle('picture-truth-below', y < screen().height / 2);
  }

  return { element, update };
}
