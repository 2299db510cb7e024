// @ts-check
/** The iframe of the viewer: one recording, with time cursor and selection synchronised with the page. */

import { h } from '../dom.js';
import { readMessage } from './messages.js';

/** @typedef {import('./messages.js').ToFrame} ToFrame */
/** @typedef {import('./messages.js').FromFrame} FromFrame */
/**
 * @typedef {object} EmbeddedViewer
 * @property {HTMLIFrameElement} element
 * @property {(frame: number) => void} seek      ignored if the viewer is already there
 * @property {(entity: string) => void} select
 * @property {() => void} destroy
 */

/** Pause between two seeks while the cursor moves, ms; only the newest is sent. */
const PAUSE = 60;
/** Time after opening in which the viewer still takes the focus by itself, ms. */
const SETTLES = 3000;
/** The longest time between Tab and the focus that it causes, ms. */
const BY_TAB = 200;
const HEARD = ['ready', 'opened', 'time', 'selected', 'refused', 'failed'];

/**
 * @param {object} options
 * @param {string} options.version
 * @param {string} options.url             address of the recording
 * @param {'light'|'dark'} options.theme
 * @param {number} options.frame           initial frame
 * @param {() => void} options.onOpen
 * @param {(frame: number) => void} options.onMove         called when a person has moved the viewer's time cursor
 * @param {(entity: string|null, instance: number|null) => void} options.onSelect
 * @param {(message: string) => void} options.onFail
 * @returns {EmbeddedViewer}
 */
export function createEmbeddedViewer({ version, url, theme, frame, onOpen, onMove, onSelect, onFail }) {
  const ended = new AbortController();
  const element = h('iframe.recording-stage', { src: '/rerun/viewer.html', title: 'Rerun viewer' });
  let wanted = frame;
  /** The viewer's frame; null: not known. @type {number|null} */
  let there = null;
  let open = false;
  /** @type {string|null} */
  let entity = null;
  /** @type {ReturnType<typeof setTimeout>|undefined} */
  let timer;
  /** The element that had the focus before. @type {EventTarget|null} */
  let held = document.activeElement;
  let tabbed = -BY_TAB;
  let settled = Infinity;

  /** @param {ToFrame} message */
  const post = (message) => element.contentWindow?.postMessage(message, location.origin);

  function flush() {
    timer = undefined;
    if (!open || ended.signal.aborted || wanted === there) return;
    there = wanted;
    post({ type: 'seek', frame: wanted });
    timer = setTimeout(flush, PAUSE);
  }

  /** @param {FromFrame} message */
  function received(message) {
    if (message.type === 'ready') {
      post({ type: 'start', version, theme, url });
    } else if (message.type === 'opened') {
      open = true;
      settled = performance.now() + SETTLES;
      flush();
      if (entity !== null) post({ type: 'select', entity });
      onOpen();
    } else if (message.type === 'time') {
      // Before the first seek arrives, the viewer reports its own initial frame.
      if (!open || message.frame === there || timer !== undefined) return;
      there = wanted = message.frame;
      onMove(message.frame);
    } else if (message.type === 'selected') {
      if (open) onSelect(message.entity, message.instance);
    } else if (message.type === 'failed') {
      onFail(message.message);
    }
  }

  // The viewer takes the focus when it starts. The page keeps it until a person enters the viewer by pointer or Tab.
  document.addEventListener(
    'focusin',
    ({ target }) => {
      if (target !== element) held = target;
    },
    { signal: ended.signal },
  );
  document.addEventListener(
    'keydown',
    ({ key }) => {
      if (key === 'Tab') tabbed = performance.now();
    },
    { signal: ended.signal, capture: true },
  );
  addEventListener(
    'blur',
    () =>
      setTimeout(() => {
        const theirs = element.matches(':hover') || performance.now() - tabbed < BY_TAB;
        if (performance.now() > settled || document.activeElement !== element || theirs) return;
        if (held instanceof HTMLElement && held !== document.body && held.isConnected) held.focus({ preventScroll: true });
        else element.blur();
      }),
    { signal: ended.signal },
  );

  addEventListener(
    'message',
    (event) => {
      if (event.origin !== location.origin || event.source !== element.contentWindow) return;
      const message = readMessage(event.data, HEARD);
      if (message) received(/** @type {FromFrame} */ (message));
    },
    { signal: ended.signal },
  );

  return {
    element,
    seek(to) {
      wanted = to;
      if (timer === undefined) flush();
    },
    select(path) {
      entity = path;
      if (open) post({ type: 'select', entity: path });
    },
    destroy() {
      ended.abort();
      clearTimeout(timer);
      element.remove();
    },
  };
}
