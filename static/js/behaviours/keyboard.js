// @ts-check
/** Maps keys to operations. Text fields, open dialogs and the browser's own keys keep their keys. */

import { neighbour } from '../operations/boxes.js';
import { runOperation } from '../operations/registry.js';

/** @typedef {import('../page-types.js').App} App */

/** Elements in which keys have another meaning. */
const KEY_FIELDS = 'input:not([type="checkbox"]), textarea, select, [contenteditable], dialog';
/** Text fields: Ctrl+Z is the browser's own undo there, for letters and not for corrections. */
const TEXT_FIELDS = 'input:not([type="checkbox"], [type="radio"], [type="range"], [type="file"]), textarea, [contenteditable]';
/** Keys that a text field passes on to the page. */
const GLOBAL_KEYS = new Set(['F1', 'Ctrl+S', 'Ctrl+K']);
/** Elements that Space and Enter activate. A list ignores them, and so does a tab that is open already. */
const ACTIVATABLE =
  'button:not([aria-selected="true"]), a, summary, input, [role="slider"], [role="button"], [role="menuitem"], [role="checkbox"], [role="switch"]';
/** Keys that scroll an element, and the dimension along which they scroll. */
const SCROLL_KEYS = new Map([
  ['ArrowLeft', 'Width'],
  ['ArrowRight', 'Width'],
  ['ArrowUp', 'Height'],
  ['ArrowDown', 'Height'],
  ['Home', 'Height'],
  ['End', 'Height'],
]);
/** A letter that is not ASCII. */
const NOT_ASCII = /^[^\x00-\x7f]$/;
const LATIN = /^\p{Script=Latin}$/u;
/** @type {Record<string, string>} */
const KEY_NAMES = { ' ': 'Space', Delete: 'Del' };

/**
 * How a key event can be written in operations (`Ctrl+Shift+Z`, `ArrowLeft`, `Del`), most likely first: the character
 * that it types, or the keycap at its place if it types a letter of another script or another sign in the row of
 * digits.
 * @param {{key: string, code?: string, ctrlKey: boolean, metaKey: boolean, altKey: boolean, shiftKey: boolean}} event
 * @returns {string[]}
 */
export function keyNames(event) {
  const { key, code = '', shiftKey } = event;
  /** @param {string} name @param {boolean} [shifted] */
  const withModifiers = (name, shifted = shiftKey && (name.length > 1 || /[A-Z0-9]/.test(name))) =>
    `${event.ctrlKey || event.metaKey ? 'Ctrl+' : ''}${event.altKey ? 'Alt+' : ''}${shifted ? 'Shift+' : ''}${name}`;
  // on some layouts, Alt turns letters into other characters, on macOS also into Latin ones
  if (NOT_ASCII.test(key) && (event.altKey || !LATIN.test(key)) && code.startsWith('Key')) return [withModifiers(code.slice(3))];
  const names = [withModifiers(KEY_NAMES[key] ?? (key.length === 1 ? key.toUpperCase() : key))];
  if (code.startsWith('Digit')) names.push(withModifiers(code.slice(5)));
  if (code === 'BracketLeft' || code === 'BracketRight') names.push(withModifiers(code === 'BracketLeft' ? '[' : ']'));
  // a digit that is typed with Shift is still a digit
  if (/^[0-9]$/.test(key)) names.push(withModifiers(key, false));
  return [...new Set(names)];
}

/**
 * Whether the focused element uses a key itself. A key that its own listener handles does not reach the page.
 * @param {Element|null} target
 * @param {string} name   of the key
 */
function isHandledByElement(target, name) {
  if (name.endsWith('Tab')) return true;
  if (name === 'Space' || name === 'Enter') return Boolean(target?.closest(ACTIVATABLE));
  const dimension = SCROLL_KEYS.get(name);
  for (let element = target?.closest('[tabindex="0"]'); dimension && element; element = element.parentElement?.closest('[tabindex="0"]')) {
    if (Reflect.get(element, `scroll${dimension}`) > Reflect.get(element, `client${dimension}`)) return true;
  }
  return false;
}

/**
 * @param {App} app
 * @param {NonNullable<Parameters<typeof runOperation>[2]>} onDisabled
 * @param {() => void} [draw]   draws the page at once
 */
export function listenToKeys(app, onDisabled, draw = () => {}) {
  /** @type {Map<string, import('../page-types.js').Operation[]>} */
  const byKey = new Map();
  for (const operation of app.operations) for (const key of operation.keys) byKey.set(key, [...(byKey.get(key) ?? []), operation]);

  // A key that an input method uses, such as the Enter that ends a composition, is no key of the page. Safari sends this
  // Enter after the composition, with the code 229.
  document.addEventListener('keydown', (event) => (event.isComposing || event.keyCode === 229) && event.stopImmediatePropagation(), {
    capture: true,
    signal: app.signal,
  });
  document.addEventListener(
    'keydown',
    (event) => {
      // an operation may have opened a dialog since the last drawing: typed keys belong to it and are not commands for
      // the picture
      if (app.store.get().dialog !== null) draw();
      const name = keyNames(event).find((one) => byKey.has(one)) ?? '';
      const matching = byKey.get(name) ?? [];
      if (matching.length === 0 || event.defaultPrevented) return;
      const target = event.target instanceof Element ? event.target : null;
      if (document.querySelector('dialog[open]')) return;
      if (target?.closest(TEXT_FIELDS) && !GLOBAL_KEYS.has(name)) return;
      if (target?.closest(KEY_FIELDS) && !name.startsWith('Ctrl+') && name !== 'F1') return;
      if (!target?.closest('[data-keys="picture"]') && isHandledByElement(target, name)) return;
      // after the last track, Tab leaves the picture as usual
      if (name.endsWith('Tab') && neighbour(app.store.get(), event.shiftKey ? -1 : 1) === null) return;
      const operation = matching.find((one) => one.available(app.store.get()));
      if (!operation) return;
      event.preventDefault();
      // a held key acts once: it must not judge, cut or delete the tracks that come up while it is down
      if (event.repeat && !operation.repeats) return;
      runOperation(app, operation, onDisabled, name);
    },
    { signal: app.signal },
  );
}
