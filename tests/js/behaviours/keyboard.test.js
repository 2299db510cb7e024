// @ts-check
import assert from 'node:assert/strict';
import { afterEach, beforeEach, test } from 'node:test';

import { keyNames, listenToKeys } from '../../../static/js/behaviours/keyboard.js';

const NONE = { ctrlKey: false, metaKey: false, altKey: false, shiftKey: false };
/** What of an element counts here: which selectors it or something around it answers to, and its sizes. */
class Part {
  /** @param {string} names   of selectors, `|` between them @param {Record<string, number>} [sizes] */
  constructor(names, sizes = {}) {
    this.names = names.split('|');
    /** @type {Part|null} */
    this.parentElement = null;
    Object.assign(this, { scrollWidth: 0, clientWidth: 0, scrollHeight: 0, clientHeight: 0 }, sizes);
  }

  /** @param {string} selector */
  closest(selector) {
    return this.names.some((name) => selector.split(', ').some((one) => one.startsWith(name))) ? this : null;
  }
}
const PICTURE = new Part('[data-keys="picture"]|[tabindex="0"]');

/** @type {string[]} */
let done = [];
let ended = new AbortController();
/** The dialog that the state names, and whether it is drawn. @type {{asked: object|null, open: boolean}} */
const dialog = { asked: null, open: false };

beforeEach(() => {
  done = [];
  ended = new AbortController();
  Object.assign(dialog, { asked: null, open: false });
  const page = Object.assign(new EventTarget(), { querySelector: () => (dialog.open ? {} : null) });
  Object.assign(globalThis, { document: page, Element: Part });
  /** @param {string[]} keys @param {boolean} repeats */
  const operation = (keys, repeats) => ({
    id: keys[0],
    keys,
    repeats,
    available: () => true,
    disabled: () => null,
    run: () => done.push(keys[0]),
  });
  const operations = [
    operation(['A'], false),
    operation(['Del'], false),
    operation(['F'], true),
    operation(['1'], false),
    operation(['8'], false),
    operation(['Shift+8'], false),
    ...['ArrowLeft', 'ArrowDown', 'Alt+ArrowLeft', 'Shift+ArrowDown', 'Home'].map((key) => operation([key], true)),
    operation(['Space'], false),
    operation(['Escape'], false),
  ];
  listenToKeys(
    /** @type {any} */ ({ operations, store: { get: () => ({ review: null, dialog: dialog.asked }) }, signal: ended.signal }),
    () => {},
    () => (dialog.open = true),
  );
});
afterEach(() => {
  ended.abort();
  Reflect.deleteProperty(globalThis, 'document');
  Reflect.deleteProperty(globalThis, 'Element');
});

/**
 * @param {string} key
 * @param {Record<string, unknown>} [more]
 * @param {Part} [target]
 * @returns {boolean} whether the browser does nothing of its own with it
 */
function pressKey(key, more = {}, target = PICTURE) {
  const event = Object.assign(new Event('keydown', { cancelable: true }), { ...NONE, repeat: false, key, code: '', ...more });
  Object.defineProperty(event, 'target', { value: target });
  document.dispatchEvent(event);
  return event.defaultPrevented;
}

test('key events are written as the operations write them', () => {
  /** @param {Record<string, unknown>} event */
  const first = (event) => keyNames(/** @type {any} */ ({ ...NONE, ...event }))[0];
  assert.equal(first({ key: 'f' }), 'F');
  assert.equal(first({ key: 'Delete', shiftKey: true }), 'Shift+Del');
  assert.equal(first({ key: 'Z', ctrlKey: true, shiftKey: true }), 'Ctrl+Shift+Z');
  assert.equal(first({ key: 'µ', code: 'KeyM', altKey: true }), 'Alt+M');
  assert.equal(first({ key: ' ' }), 'Space');
  assert.equal(first({ key: '?', shiftKey: true }), '?');
});

test('where a key types a letter of another script, its place counts; where it types a Latin one, that does', () => {
  /** @param {string} key @param {string} code @param {object} [more] */
  const first = (key, code, more = {}) => keyNames({ ...NONE, key, code, ...more })[0];
  assert.equal(first('ф', 'KeyA'), 'A');
  assert.equal(first('Я', 'KeyZ', { ctrlKey: true, shiftKey: true }), 'Ctrl+Shift+Z');
  assert.equal(first('λ', 'KeyL'), 'L');
  assert.equal(first('z', 'KeyY', { ctrlKey: true }), 'Ctrl+Z', 'QWERTZ');
  assert.equal(first('a', 'KeyQ'), 'A', 'AZERTY');
  assert.equal(first("'", 'KeyQ'), "'", 'Dvorak: it is no Q');
  assert.equal(first('m', 'Semicolon', { altKey: true }), 'Alt+M', 'AZERTY');
  assert.equal(first('é', 'KeyW'), 'É', 'BÉPO: it is no W');
  assert.equal(first('Ô', 'KeyJ', { altKey: true, shiftKey: true }), 'Alt+Shift+J', 'macOS');
});

test('the row of digits is the row of digits where its keys type something else without Shift', () => {
  pressKey('&', { code: 'Digit1' });
  pressKey('1', { code: 'Digit1', shiftKey: true });
  pressKey('_', { code: 'Digit8' });
  pressKey('8', { code: 'Digit8', shiftKey: true });
  pressKey('*', { code: 'Digit8', shiftKey: true });
  assert.deepEqual(done, ['1', '1', '8', 'Shift+8', 'Shift+8']);
});

test('keys of an input method are no keys of the page', () => {
  pressKey('A', { isComposing: true });
  pressKey('A', { keyCode: 229 });
  assert.deepEqual(done, []);
  pressKey('A', { isComposing: false, keyCode: 65 });
  assert.deepEqual(done, ['A']);
});

test('a key that is held judges one track, and steps on through the frames', () => {
  for (const key of ['a', 'Delete', 'f']) {
    pressKey(key);
    for (let k = 0; k < 3; k++) assert.equal(pressKey(key, { repeat: true }), true, 'nor does the browser do anything with it');
  }
  assert.deepEqual(done, ['A', 'Del', 'F', 'F', 'F', 'F']);
});

test("the arrows are the review's after a click on a row or a button, so Alt and an arrow never leave the page", () => {
  const row = new Part('[tabindex="0"]', { scrollHeight: 900, clientHeight: 300 });
  const button = new Part('button');
  for (const target of [row, button]) for (const key of ['ArrowLeft', 'ArrowDown']) pressKey(key, {}, target);
  assert.deepEqual(done, ['ArrowLeft', 'ArrowLeft', 'ArrowDown'], 'what scrolls keeps its own');
  for (const target of [row, button]) {
    assert.equal(pressKey('ArrowLeft', { altKey: true }, target), true);
    assert.equal(pressKey('ArrowDown', { shiftKey: true }, target), true);
  }
  assert.deepEqual(done.slice(3), ['Alt+ArrowLeft', 'Shift+ArrowDown', 'Alt+ArrowLeft', 'Shift+ArrowDown']);
});

test('what has the focus keeps the keys that it needs itself', () => {
  const button = new Part('button');
  const text = new Part('input');
  assert.equal(pressKey(' ', {}, button), false);
  for (const key of ['a', 'ArrowLeft', 'Home']) assert.equal(pressKey(key, {}, text), false);
  assert.deepEqual(done, []);
  assert.equal(pressKey('Escape', {}, button), true);
});

test('what is typed before the dialog that was asked for is drawn is typed into it', () => {
  dialog.asked = { kind: 'relabel' };
  assert.equal(pressKey('a'), false, 'the browser types it where the focus is');
  assert.deepEqual([dialog.open, done], [true, []]);
});
