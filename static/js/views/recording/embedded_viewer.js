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
const SEEK_INTERVAL_MS = 60;
/** Time after opening in which the viewer still takes the focus by itself, ms. */
const FOCUS_GUARD_MS = 3000;
/** The longest time between Tab and the focus that it causes, ms. */
const TAB_FOCUS_MS = 200;
const MESSAGE_TYPES = ['ready', 'opened', 'time', 'selected', 'refused', 'failed'];

/**
 * @param {object} options
 * @param {string} options.version
 * @param {string} options.url                       address of the recording
 * @param {'light'|'dark'} options.theme
 * @param {number} options.frame                     initial frame
 * @param {() => void} options.onOpen
 * @param {(frame: number) => void} options.onMove   called when a person has moved the viewer's time cursor
 * @param {(entity: string|null, instance: number|null) => void} options.onSelect
 * @param {(message: string) => void} options.onFail
 * @returns {EmbeddedViewer}
 */
export function createEmbeddedViewer({ version, url, theme, frame, onOpen, onMove, onSelect, onFail }) {
  const lifetime = new AbortController();
  const element = h('iframe.recording-stage', { src: '/rerun/viewer.html', title: 'Rerun viewer' });
  let targetFrame = frame;
  /** The viewer's frame; null: not known. @type {number|null} */
  let viewerFrame = null;
  let isOpen = false;
  /** @type {string|null} */ let entity = null;
  /** @type {ReturnType<typeof setTimeout>|undefined} */ let timer;
  /** The element that had the focus before. @type {EventTarget|null} */
  let lastFocused = document.activeElement;
  let lastTabTime = -TAB_FOCUS_MS;
  let guardEnd = Infinity;

  /** @param {ToFrame} message */
  const post = (message) => element.contentWindow?.postMessage(message, location.origin);

  function sendSeek() {
    timer = undefined;
    if (!isOpen || lifetime.signal.aborted || targetFrame === viewerFrame) return;
    viewerFrame = targetFrame;
    post({ type: 'seek', frame: targetFrame });
    timer = setTimeout(sendSeek, SEEK_INTERVAL_MS);
  }

  /** @param {FromFrame} message */
  function onMessage(message) {
    if (message.type === 'ready') {
      post({ type: 'start', version, theme, url });
    } else if (message.type === 'opened') {
      isOpen = true;
      guardEnd = performance.now() + FOCUS_GUARD_MS;
      sendSeek();
      if (entity !== null) post({ type: 'select', entity });
      onOpen();
    } else if (message.type === 'time') {
      // Before the first seek arrives, the viewer reports its own initial frame.
      if (!isOpen || message.frame === viewerFrame || timer !== undefined) return;
      viewerFrame = targetFrame = message.frame;
      onMove(message.frame);
    } else if (message.type === 'selected') {
      if (isOpen) onSelect(message.entity, message.instance);
    } else if (message.type === 'failed') {
      onFail(message.message);
    }
  }

  // The viewer takes the focus when it starts. The page keeps it until a person enters the viewer by pointer or Tab.
  document.addEventListener(
    'focusin',
    ({ target }) => {
      if (target !== element) lastFocused = target;
    },
    { signal: lifetime.signal },
  );
  document.addEventListener(
    'keydown',
    ({ key }) => {
      if (key === 'Tab') lastTabTime = performance.now();
    },
    { signal: lifetime.signal, capture: true },
  );
  addEventListener(
    'blur',
    () =>
      setTimeout(() => {
        const isDeliberate = element.matches(':hover') || performance.now() - lastTabTime < TAB_FOCUS_MS;
        if (performance.now() > guardEnd || document.activeElement !== element || isDeliberate) return;
        if (lastFocused instanceof HTMLElement && lastFocused !== document.body && lastFocused.isConnected)
          lastFocused.focus({ preventScroll: true });
        else element.blur();
      }),
    { signal: lifetime.signal },
  );

  addEventListener(
    'message',
    (event) => {
      if (event.origin !== location.origin || event.source !== element.contentWindow) return;
      const message = readMessage(event.data, MESSAGE_TYPES);
      if (message) onMessage(/** @type {FromFrame} */ (message));
    },
    { signal: lifetime.signal },
  );

  return {
    element,
    seek(to) {
      targetFrame = to;
      if (timer === undefined) sendSeek();
    },
    select(path) {
      entity = path;
      if (isOpen) post({ type: 'select', entity: path });
    },
    destroy() {
      lifetime.abort();
      clearTimeout(timer);
      element.remove();
    },
  };
}
