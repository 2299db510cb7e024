// @ts-check
/** Maps keys to operations. Text fields, open dialogs and the browser's own keys keep their keys. */

import { neighbour } from '../operations/boxes.js';
import { runOperation } from '../operations/registry.js';

/** @typedef {import('../page-types.js').App} App */

/** Elements in which keys have another meaning. */
const FIELDS = 'input:not([type="checkbox"]), textarea, select, [contenteditable], dialog';
/** Text fields: Ctrl+Z is the browser's own undo there, for letters and not for corrections. */
const WRITTEN = 'input:not([type="checkbox"], [type="radio"], [type="range"], [type="file"]), textarea, [contenteditable]';
/** Keys that a text field passes on to the page. */
const NEVER_TEXT = new Set(['F1', 'Ctrl+S', 'Ctrl+K']);
/** Elements that Space and Enter activate. A list ignores them, and so does a tab that is open already. */
const PRESSED =
  'button:not([aria-selected="true"]), a, summary, input, [role="slider"], [role="button"], [role="menuitem"], [role="checkbox"], [role="switch"]';
/** Keys that scroll an element, and the dimension along which they scroll. */
const SCROLLING = new Map([
  ['ArrowLeft', 'Width'],
  ['ArrowRight', 'Width'],
  ['ArrowUp', 'Height'],
  ['ArrowDown', 'Height'],
  ['Home', 'Height'],
  ['End', 'Height'],
]);
/** A letter that is not ASCII. */
const OTHER_SCRIPT = /^[^\x00-\x7f]$/;
const LATIN = /^\p{Script=Latin}$/u;
/** @type {Record<string, string>} */
const NAMES = { ' ': 'Space', Delete: 'Del' };

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
  const written = (name, shifted = shiftKey && (name.length > 1 || /[A-Z0-9]/.test(name))) =>
    `${event.ctrlKey || event.metaKey ? 'Ctrl+' : ''}${event.altKey ? 'Alt+' : ''}${shifted ? 'Shift+' : ''}${name}`;
  // on some layouts, Alt turns Latin letters into other characters
  if (OTHER_SCRIPT.test(key) && !LATIN.test(key) && code.startsWith('Key')) return [written(code.slice(3))];
  const names = [written(NAMES[key] ?? (key.length === 1 ? key.toUpperCase() : key))];
  if (code.startsWith('Digit')) names.push(written(code.slice(5)));
  if (code === 'BracketLeft' || code === 'BracketRight') names.push(written(code === 'BracketLeft' ? '[' : ']'));
  // a digit that is typed with Shift is still a digit
  if (/^[0-9]$/.test(key)) names.push(written(key, false));
  return [...new Set(names)];
}

/**
 * Whether the focused element uses a key itself. Keys that its own listener handles do not arrive here.
 * @param {Element|null} target
 * @param {string} name   of the key
 */
function isItsOwn(target, name) {
  if (name.endsWith('Tab')) return true;
  if (name === 'Space' || name === 'Enter') return Boolean(target?.closest(PRESSED));
  const side = SCROLLING.get(name);
  for (let at = target?.closest('[tabindex="0"]'); side && at; at = at.parentElement?.closest('[tabindex="0"]')) {
    if (Reflect.get(at, `scroll${side}`) > Reflect.get(at, `client${side}`)) return true;
  }
  return false;
}

/**
 * @param {App} app
 * @param {NonNullable<Parameters<typeof runOperation>[2]>} refuse
 * @param {() => void} [draw]   draws the page at once
 */
export function listenToKeys(app, refuse, draw = () => {}) {
  /** @type {Map<string, import('../page-types.js').Operation[]>} */
  const byKey = new Map();
  for (const operation of app.operations) for (const key of operation.keys) byKey.set(key, [...(byKey.get(key) ?? []), operation]);

  document.addEventListener(
    'keydown',
    (event) => {
      // an operation may have opened a dialog since the last drawing: typed keys belong to it and are not commands for
      // the picture
      if (app.store.get().dialog !== null) draw();
      const name = keyNames(event).find((one) => byKey.has(one)) ?? '';
      const meant = byKey.get(name) ?? [];
      if (meant.length === 0 || event.defaultPrevented) return;
      const target = event.target instanceof Element ? event.target : null;
      if (document.querySelector('dialog[open]')) return;
      if (target?.closest(WRITTEN) && !NEVER_TEXT.has(name)) return;
      if (target?.closest(FIELDS) && !name.startsWith('Ctrl+') && name !== 'F1') return;
      if (!target?.closest('[data-keys="picture"]') && isItsOwn(target, name)) return;
      // after the last track, Tab leaves the picture as usual
      if (name.endsWith('Tab') && neighbour(app.store.get(), event.shiftKey ? -1 : 1) === null) return;
      const operation = meant.find((one) => one.available(app.store.get()));
      if (!operation) return;
      event.preventDefault();
      // a held key acts once: it must not judge, cut or delete the tracks that come up while it is down
      if (event.repeat && !operation.repeats) return;
      runOperation(app, operation, refuse, name);
    },
    { signal: app.signal },
  );
}
