// @ts-check
/**
 * The menu of a box: right click, the menu key or Shift+F10. Every entry is an operation with its key, so that the menu
 * teaches the keyboard. Disabled entries give the reason.
 *
 * @typedef {import('../../page-types.js').App} App
 * @typedef {import('../../page-types.js').Operation} Operation
 */
import { toScreen } from '../../model/geometry.js';
import { runOperation } from '../../operations/registry.js';
import { shownTrack } from '../../review/shown_tracks.js';
import { h } from '../dom.js';
import { icon, isIcon } from '../icons.js';
import { toast } from '../../core/toast.js';

/** Operations by group. */
const MENU_GROUPS = [
  ['relabel', 'accept', 'reject', 'needs-work', 'ignore'],
  ['follow', 'follow-forward', 'extend-first', 'extend-last'],
  ['key-frame', 'interpolate', 'occluded', 'outside'],
  ['split', 'merge', 'delete-from', 'delete-track'],
  ['zoom-track', 'note', 'report-bug'],
];
/** Space between the menu and the edge of the picture, CSS px. */
const EDGE_GAP_PX = 4;

/**
 * The present entries of the menu, by group; empty groups are omitted.
 * @param {readonly Operation[]} operations
 * @param {import('../../state-types.js').State} state
 * @returns {Operation[][]}
 */
function menuEntries(operations, state) {
  const known = new Map(operations.map((operation) => [operation.id, operation]));
  return MENU_GROUPS.map((ids) => ids.flatMap((id) => known.get(id) ?? []).filter((operation) => operation.available(state))).filter(
    (group) => group.length > 0,
  );
}

/**
 * @param {App} app
 * @param {HTMLElement} stage   the picture, which gets the focus back
 * @param {() => import('../../model/geometry.js').Size} screen   its size, CSS px
 * @param {AbortSignal} signal
 */
export function createBoxMenu(app, stage, screen, signal) {
  const element = h('div.box-menu', { role: 'menu', 'aria-label': 'Menu of the box', hidden: true });

  /** Track and frame of the menu. */
  let shownKey = '';

  /** @param {boolean} [returnFocus]   give the focus back to the picture */
  function close(returnFocus = false) {
    if (element.hidden) return;
    element.hidden = true;
    element.replaceChildren();
    if (returnFocus) stage.focus({ preventScroll: true });
  }

  /** Open the menu for the selected track. @param {number} x @param {number} y CSS px within the picture */
  function open(x, y) {
    const state = app.store.get();
    const groups = menuEntries(app.operations, state);
    if (!state.review?.selected || groups.length === 0) return;
    element.replaceChildren(
      ...groups.map((group) => h('div.box-menu-group', { role: 'group' }, ...group.map((operation) => entry(operation, state)))),
    );
    element.hidden = false;
    shownKey = `${state.review.selected} ${state.review.frame}`;
    const { width, height } = screen();
    element.style.left = `${Math.max(EDGE_GAP_PX, Math.min(x, width - element.offsetWidth - EDGE_GAP_PX))}px`;
    element.style.top = `${Math.max(EDGE_GAP_PX, Math.min(y, height - element.offsetHeight - EDGE_GAP_PX))}px`;
    items()[0]?.focus({ preventScroll: true });
  }

  /** @param {Operation} operation @param {import('../../state-types.js').State} state */
  function entry(operation, state) {
    const reason = operation.disabled(state);
    return h(
      'button.box-menu-item',
      {
        role: 'menuitem',
        tabIndex: -1,
        title: reason ?? operation.tooltip,
        'aria-disabled': reason === null ? null : 'true',
        'data-operation': operation.id,
        onclick: () => {
          close(true);
          runOperation(app, operation, toast);
        },
      },
      operation.icon && isIcon(operation.icon) ? icon(operation.icon) : h('span.box-menu-blank'),
      h('span.box-menu-name', operation.label),
      operation.keys.length > 0 ? h('kbd', operation.keys[0]) : null,
    );
  }

  const items = () => /** @type {HTMLButtonElement[]} */ ([...element.querySelectorAll('[role="menuitem"]')]);

  element.addEventListener('keydown', (event) => {
    const all = items();
    const at = all.indexOf(/** @type {HTMLButtonElement} */ (document.activeElement));
    const next = { ArrowDown: (at + 1) % all.length, ArrowUp: (at - 1 + all.length) % all.length, Home: 0, End: all.length - 1 }[event.key];
    if (next !== undefined) all[next]?.focus({ preventScroll: true });
    else if (event.key === 'Escape' || event.key === 'Tab') close(true);
    else if (event.key === 'Enter' || event.key === ' ') all[at]?.click();
    else if (!event.key.startsWith('Arrow')) return; // letters are keys of operations, as everywhere; arrows must not move the box below
    event.preventDefault();
    event.stopPropagation();
  });
  element.addEventListener('pointerdown', (event) => event.stopPropagation());
  document.addEventListener(
    'pointerdown',
    (event) => {
      if (event.target instanceof Node && !element.contains(event.target)) close();
    },
    { signal, capture: true },
  );

  stage.addEventListener('keydown', (event) => {
    if (event.key !== 'ContextMenu' && !(event.key === 'F10' && event.shiftKey)) return;
    const { review } = app.store.get();
    const shown = review?.selected ? shownTrack(review, review.selected) : null;
    if (!review || !shown) return;
    event.preventDefault();
    open(...toScreen(review.viewport, screen(), shown.box[2], shown.box[1]));
  });

  return {
    element,
    open,
    /** Close the menu if a key in it has run an operation that changed the track or the frame. @param {import('../../state-types.js').ReviewState} review */
    update({ selected, frame }) {
      if (shownKey !== `${selected} ${frame}`) close();
    },
  };
}
