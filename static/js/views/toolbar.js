// @ts-check
/** The operations as buttons, each with its key in the tooltip. */

import { verdictOf } from '../model/documents.js';
import { runOperation } from '../operations/registry.js';
import { followFocus, h, leaveKeysToPicture } from './dom.js';
import { icon, isIcon } from './icons.js';
import { toast } from './toasts.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../page-types.js').Operation} Operation */

/** Groups and what of them stands in the bar; the rest has its button where it belongs: layers, queue, top bar. */
const BAR = [
  ['first-frame', 'back-10', 'previous-frame', 'play', 'next-frame', 'on-10', 'last-frame'],
  ['previous-key', 'next-key'],
  ['undo', 'redo'],
  ['select-mode', 'draw', 'new-box', 'merge', 'split', 'key-frame', 'interpolate'],
  ['follow', 'extend-first', 'extend-last'],
  ['occluded', 'outside', 'delete-from', 'delete-track'],
  ['relabel', 'ignore', 'note'],
  ['accept', 'reject', 'needs-work'],
  ['previous-in-queue', 'next-in-queue', 'to-track'],
  ['fit', 'actual-size', 'zoom-track', 'few-labels', 'what-if'],
  ['export', 'import', 'ground-truths', 'record', 'report-bug'],
  ['recording-view', 'scene3d-view'],
];
/** Buttons that carry their name. */
const NAMED = new Set(['accept', 'reject', 'needs-work', 'relabel', 'what-if']);
/** @type {Record<string, (review: import('../state-types.js').ReviewState) => boolean>} */
const PRESSED = {
  play: (review) => review.playing,
  draw: (review) => review.mode === 'draw',
  merge: (review) => review.mode === 'merge',
  'recording-view': (review) => review.beside === 'recording',
  'scene3d-view': (review) => review.beside === 'scene3d',
  'few-labels': (review) => review.fewLabels,
  'select-mode': (review) => review.mode === 'select',
  accept: (review) => verdictOfSelected(review) === 'accepted',
  reject: (review) => verdictOfSelected(review) === 'rejected',
  'needs-work': (review) => verdictOfSelected(review) === 'needs_work',
  ignore: (review) => docOfSelected(review)?.ignore === true,
};
/** @param {import('../state-types.js').ReviewState} review */
const docOfSelected = (review) => (review.selected ? review.docs[review.selected] : undefined);
/** @param {import('../state-types.js').ReviewState} review */
const verdictOfSelected = (review) => {
  const doc = docOfSelected(review);
  return doc && verdictOf(doc);
};

/**
 * @param {App} app
 * @returns {import('../page-types.js').View}
 */
export function createToolbar(app) {
  const element = h('div', { class: 'toolbar', role: 'toolbar', 'aria-label': 'Operations' });
  /** @type {[Operation, HTMLButtonElement][]} */
  const buttons = [];
  for (const ids of BAR) {
    const group = h('div', { class: 'toolbar-group', role: 'group' });
    for (const id of ids) {
      const operation = app.operations.find((candidate) => candidate.id === id);
      if (!operation) continue;
      const named = NAMED.has(id) || !operation.icon || !isIcon(operation.icon);
      const button = h('button', {
        class: `btn btn-quiet ${named ? '' : 'btn-icon'}`, type: 'button', 'aria-label': operation.label,
        onclick: () => runOperation(app, operation, (reason) => toast(reason)),
      }, operation.icon && isIcon(operation.icon) ? icon(operation.icon) : null, named ? h('span', null, short(operation)) : null);
      button.dataset.operation = id;
      buttons.push([operation, button]);
      group.append(button);
    }
    element.append(group);
  }
  leaveKeysToPicture(element);
  followFocus(element);
  /** @type {import('../state-types.js').State|null} */
  let last = null;

  return {
    element,
    update(state) {
      if (last && last.review === state.review && last.route === state.route) return;
      last = state;
      for (const [operation, button] of buttons) {
        const reason = operation.available(state) ? operation.disabled(state) : 'Open a video first.';
        const disabled = String(reason !== null);
        if (button.getAttribute('aria-disabled') !== disabled) button.setAttribute('aria-disabled', disabled);
        const title = reason === null ? operation.tooltip : `${operation.tooltip}. ${reason}`;
        if (button.title !== title) button.title = title;
        const pressed = PRESSED[operation.id];
        if (pressed && state.review) {
          const value = String(pressed(state.review));
          if (button.getAttribute('aria-pressed') !== value) {
            button.setAttribute('aria-pressed', value);
            if (operation.id === 'play') button.replaceChildren(icon(value === 'true' ? 'pause' : 'play'));
          }
        }
      }
    },
    destroy: () => element.remove(),
  };
}

/** @param {Operation} operation */
const short = (operation) => ({ accept: 'Accept', reject: 'False positive', 'needs-work': 'Needs work', 'what-if': 'What if' })[operation.id] ?? operation.label;
