// @ts-check
/** Help: every operation with its keys, from the registry that toolbar and keyboard use. */

import { h, setText } from '../dom.js';
import { icon } from '../icons.js';

/** @typedef {import('../../page-types.js').Operation} Operation */

/** Texts on key caps. @type {Record<string, string>} */
const KEY_CAPS = { ' ': 'Space', ArrowLeft: '←', ArrowRight: '→', ArrowUp: '↑', ArrowDown: '↓', Delete: 'Del', Escape: 'Esc' };

/**
 * @param {readonly Operation[]} operations
 * @param {string} text
 * @returns {[string, Operation[]][]} group and its operations, in the order of the registry
 */
export function groupOperations(operations, text) {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  /** @type {Map<string, Operation[]>} */ const groups = new Map();
  for (const operation of operations) {
    const searchable = `${operation.label} ${operation.tooltip} ${operation.keys.join(' ')} ${operation.group}`.toLowerCase();
    if (!words.every((word) => searchable.includes(word))) continue;
    groups.set(operation.group, [...(groups.get(operation.group) ?? []), operation]);
  }
  return [...groups];
}

/**
 * The tooltip without its key, which is shown beside it; empty if it only repeats the name.
 *
 * @param {Operation} operation
 * @returns {string}
 */
function explanation({ tooltip, label, keys }) {
  const text = keys.reduce((rest, key) => (rest.endsWith(` (${key})`) ? rest.slice(0, -key.length - 3) : rest), tooltip);
  return text === label ? '' : text;
}

/**
 * A key as printed on the keyboard.
 *
 * @param {string} keys   `Ctrl+Shift+Z`
 * @returns {HTMLElement}
 */
export function keyHint(keys) {
  const parts = keys === '+' ? ['+'] : keys.split('+');
  return h('span.keys', ...parts.map((part) => h('kbd.kbd', KEY_CAPS[part] ?? part)));
}

/** @type {import('./index.js').CreateDialog<'help'>} */
export function helpDialog({ app, close }) {
  const search = h('input.input', {
    type: 'search',
    placeholder: 'Search what you want to do, or a key',
    'aria-label': 'Search the help',
    oninput: show,
  });
  const list = h('div.help-groups');
  const foundText = h('p.muted.small', { role: 'status' });

  function show() {
    const groups = groupOperations(app.operations, search.value);
    list.replaceChildren(
      ...groups.map(([group, operations]) =>
        h(
          'section.help-group',
          h('h3', group),
          h(
            'dl.help-list',
            ...operations.flatMap((operation) => [
              h('dt', ...operation.keys.map(keyHint)),
              h('dd', h('span.help-label', operation.label), explanation(operation) && h('span.muted.small', explanation(operation))),
            ]),
          ),
        ),
      ),
    );
    const total = groups.reduce((sum, [, operations]) => sum + operations.length, 0);
    setText(foundText, search.value ? (total ? `${total} found` : 'Nothing found. Try another word.') : '');
  }
  show();

  return {
    title: 'Help and keys',
    size: 'wide',
    focus: search,
    body: h(
      'div.stack',
      h(
        'p.muted',
        'Every action also has a button with its key in the tooltip; in the picture, the mouse also does what Tab, Enter and the arrows do. Keys work unless a text field has the focus.',
      ),
      h('div.input-with-icon', icon('search'), search),
      foundText,
      list,
      h('p.muted.small', `tsr ${app.store.get().session?.version ?? ''}`),
    ),
    footer: [h('span.grow'), h('button.btn', { onclick: close }, 'Close')],
  };
}
