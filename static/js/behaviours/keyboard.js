// @ts-check
/** Keys to operations. Typing into a field, an open dialog and the browser's own keys are left alone. */

import { neighbour } from '../operations/boxes.js';
import { runOperation } from '../operations/registry.js';

/** @typedef {import('../page-types.js').App} App */

/** Keys that mean something else inside these. */
const FIELDS = 'input, textarea, select, [contenteditable], dialog';
/** Where one writes: there the browser's own Ctrl+Z takes back letters, not corrections. */
const WRITTEN = 'input:not([type="checkbox"], [type="radio"], [type="range"], [type="file"]), textarea, [contenteditable]';
/** The keys that a field leaves to the page. */
const NEVER_TEXT = new Set(['F1', 'Ctrl+S']);
/** What the space bar presses. A list does nothing with it, nor does a tab that is open already. */
const PRESSED = 'button:not([aria-selected="true"]), a, summary, [role="slider"], [role="button"], [role="menuitem"], [role="checkbox"], [role="switch"]';
/** Keys that a focused control uses itself. */
const CONTROL_KEYS = new Set(['Space', 'Enter', 'Tab', 'Shift+Tab', 'ArrowLeft', 'ArrowRight', 'ArrowUp', 'ArrowDown', 'Home', 'End', 'Escape']);

/**
 * How a key event is written in operations: `Ctrl+Shift+Z`, `ArrowLeft`, `Del`.
 * @param {{key: string, code?: string, ctrlKey: boolean, metaKey: boolean, altKey: boolean, shiftKey: boolean}} event
 * @returns {string}
 */
export function keyName(event) {
  let key = event.key;
  if (key === ' ') key = 'Space';
  else if (key === 'Delete') key = 'Del';
  else if (event.code?.startsWith('Digit') && event.shiftKey) key = event.code.slice(5);
  else if (event.altKey && event.code?.startsWith('Key')) key = event.code.slice(3); // Alt makes other letters on some layouts
  else if (key.length === 1) key = key.toUpperCase();
  const shift = event.shiftKey && (key.length > 1 || /[A-Z0-9]/.test(key)) ? 'Shift+' : '';
  return `${event.ctrlKey || event.metaKey ? 'Ctrl+' : ''}${event.altKey ? 'Alt+' : ''}${shift}${key}`;
}

/**
 * @param {App} app
 * @param {(reason: string) => void} refuse
 */
export function listenToKeys(app, refuse) {
  /** @type {Map<string, import('../page-types.js').Operation>} */
  const byKey = new Map();
  for (const operation of app.operations) for (const key of operation.keys) byKey.set(key, operation);

  document.addEventListener('keydown', (event) => {
    const name = keyName(event);
    const operation = byKey.get(name);
    if (!operation || event.defaultPrevented) return;
    const target = event.target instanceof Element ? event.target : null;
    if (document.querySelector('dialog[open]')) return;
    if (target?.closest(WRITTEN) && !NEVER_TEXT.has(name)) return;
    if (target?.closest(FIELDS) && !name.startsWith('Ctrl+') && name !== 'F1') return;
    // Tab, arrows and the like belong to the picture only while it has the focus
    const onPicture = target?.closest('[data-keys="picture"]') != null;
    if (CONTROL_KEYS.has(name) || name.includes('Arrow')) {
      const free = target === document.body || target?.closest('main') === target;
      if (!onPicture && !(free && !name.endsWith('Tab'))) {
        if (!(name === 'Space' && !target?.closest(PRESSED)) && name !== 'Escape') return;
      }
      // behind the last track Tab leaves the picture as usual
      if (name.endsWith('Tab') && neighbour(app.store.get(), event.shiftKey ? -1 : 1) === null) return;
    }
    if (!operation.available(app.store.get())) return;
    event.preventDefault();
    runOperation(app, operation, refuse);
  }, { signal: app.signal });
}
