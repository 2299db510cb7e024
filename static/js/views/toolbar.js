// @ts-check
/** The operations as buttons, each with its key in the tooltip. */

import { verdictOf } from '../model/documents.js';
import { runOperation } from '../operations/registry.js';
import { addRovingTabIndex, h, returnFocusToPicture, scrollFocusedIntoView, setAttribute } from './dom.js';
import { icon, isIcon } from './icons.js';
import { toast } from '../core/toast.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../page-types.js').Operation} Operation */

/**
 * Groups and their operations in the toolbar; other operations have buttons elsewhere: layers, queue, top bar.
 * @type {readonly [string, readonly string[]][]}
 */
const TOOLBAR_GROUPS = [
  ['Frames', ['first-frame', 'back-10', 'previous-frame', 'play', 'next-frame', 'on-10', 'last-frame']],
  ['Key frames', ['previous-key', 'next-key']],
  ['History', ['undo', 'redo']],
  ['Boxes and tracks', ['select-mode', 'draw', 'new-box', 'merge', 'split', 'key-frame', 'interpolate']],
  ['Follow', ['follow', 'extend-first', 'extend-last']],
  ['Visibility', ['occluded', 'outside', 'delete-from', 'delete-track']],
  ['Label', ['relabel', 'ignore', 'note']],
  ['Verdict', ['accept', 'reject', 'needs-work']],
  ['Queue', ['previous-in-queue', 'next-in-queue', 'to-track']],
  ['View', ['fit', 'actual-size', 'zoom-track', 'few-labels', 'what-if']],
  ['Files', ['export', 'import', 'ground-truths', 'record', 'report-bug']],
  ['Beside the picture', ['recording-view', 'scene3d-view']],
];
/** Groups in the order in which their buttons get names if there is space. */
const NAMED_FIRST = [
  'Verdict',
  'Label',
  'Boxes and tracks',
  'Follow',
  'Visibility',
  'View',
  'Queue',
  'Files',
  'History',
  'Beside the picture',
  'Key frames',
  'Frames',
];
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

/** @type {import('../page-types.js').CreateView} */
export function createToolbar(app) {
  const element = h('div.toolbar', { role: 'toolbar', 'aria-label': 'Operations' });
  /** @type {[Operation, HTMLButtonElement][]} */ const buttons = [];
  const groups = TOOLBAR_GROUPS.map(([name, ids]) =>
    h(
      'div.toolbar-group',
      { role: 'group', 'aria-label': name },
      ids.flatMap((id) => {
        const operation = app.operations.find((candidate) => candidate.id === id);
        if (!operation?.icon || !isIcon(operation.icon)) return [];
        const button = h(
          'button.btn.btn-quiet',
          { tabIndex: -1, 'aria-label': operation.label, dataset: { operation: id }, onclick: () => runOperation(app, operation, toast) },
          icon(operation.icon),
          h('span', operation.short ?? operation.label),
        );
        buttons.push([operation, button]);
        return [button];
      }),
    ),
  );
  element.append(...groups);
  addRovingTabIndex(
    element,
    buttons.map(([, button]) => button),
  );
  const observer = new ResizeObserver(() => nameButtons(element, groups));
  observer.observe(element);
  returnFocusToPicture(element);
  scrollFocusedIntoView(element);
  /** @type {import('../state-types.js').State|null} */ let lastState = null;

  return {
    element,
    update(state) {
      if (lastState && lastState.review === state.review && lastState.route === state.route) return;
      lastState = state;
      for (const [operation, button] of buttons) {
        const reason = operation.available(state) ? operation.disabled(state) : 'Open a video first.';
        setAttribute(button, 'aria-disabled', String(reason !== null));
        setAttribute(button, 'title', reason === null ? operation.tooltip : `${operation.tooltip}. ${reason}`);
        const pressed = PRESSED[operation.id];
        if (pressed && state.review) {
          const value = String(pressed(state.review));
          if (button.getAttribute('aria-pressed') !== value) {
            button.setAttribute('aria-pressed', value);
            if (operation.id === 'play') button.firstElementChild?.replaceWith(icon(value === 'true' ? 'pause' : 'play'));
          }
        }
      }
    },
    destroy: () => observer.disconnect(),
  };
}

/**
 * Show names on the buttons of as many groups as fit into one row.
 * @param {HTMLElement} bar
 * @param {readonly HTMLElement[]} groups   in the order of `TOOLBAR_GROUPS`
 */
function nameButtons(bar, groups) {
  const order = NAMED_FIRST.map((name) => groups[TOOLBAR_GROUPS.findIndex(([one]) => one === name)]);
  /** @param {HTMLElement} group @param {boolean} named */
  const name = (group, named) => {
    for (const button of group.children) button.classList.toggle('btn-icon', !named);
  };
  const fits = () => bar.scrollWidth <= bar.clientWidth && groups.every(({ offsetTop }) => offsetTop === groups[0].offsetTop);
  for (const group of groups) name(group, false);
  for (const group of order) {
    name(group, true);
    if (!fits()) name(group, false);
  }
}
