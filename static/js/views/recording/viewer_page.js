// @ts-check
/**
 * Runs in the page `/rerun/viewer.html`: starts the viewer on its canvas, and translates between it and the outer page.
 * `messages.js` defines the messages.
 */

import { readMessage } from './messages.js';
import { seekRequest, selectRequest } from './protocol.js';
import { createTimeSync } from './time_sync.js';

/** @typedef {import('./messages.js').ToFrame} ToFrame */
/** @typedef {import('./messages.js').FromFrame} FromFrame */
/**
 * @typedef {object} WebHandle
 * @property {(canvas: HTMLCanvasElement) => Promise<void>} start
 * @property {() => boolean} has_panicked
 * @property {() => string|undefined} panic_message
 * @property {(request: Uint8Array) => Promise<Uint8Array>} viewer_control
 * @property {(id: string, name: string) => void} open_channel
 * @property {(id: string, data: Uint8Array) => void} send_rrd_to_channel
 * @property {(id: string) => void} close_channel
 */

const TIMELINE = 'frame';
const CHANNEL = 'recording';
/** The longest time until a recording counts as open, ms. */
const MAX_OPENING_MS = 5000;
/** Number of attempts to seek once the viewer has a time, and before: without a graphics card it loads for half a minute. */
const MAX_SEEK_TRIES = 40;
const MAX_EARLY_SEEK_TRIES = 800;
/** Pause between two attempts, ms. */
const SEEK_RETRY_MS = 150;
/** Interval of checks whether the viewer still runs, ms. */
const HEALTH_CHECK_MS = 1000;

const canvas = /** @type {HTMLCanvasElement} */ (document.getElementById('viewer'));
const note = /** @type {HTMLElement} */ (document.getElementById('note'));
/** @type {WebHandle|null} */ let handle = null;
/** The present timeline; recordings open on this one. */
let timeline = TIMELINE;
const sync = createTimeSync();
/** The message to send when the recording is open. @type {FromFrame|null} */
let openMessage = null;
let hasFailed = false;

/** @param {FromFrame} message */
function postToPage(message) {
  if (parent !== window) parent.postMessage(message, location.origin);
}

/** @param {string} reason @param {string} message */
function fail(reason, message) {
  if (hasFailed) return;
  hasFailed = true;
  canvas.hidden = true;
  note.textContent = message;
  postToPage({ type: 'failed', reason, message });
}

/** @param {string} source @returns {Promise<void>} */
function loadScript(source) {
  return new Promise((resolve, reject) => {
    const script = document.createElement('script');
    script.src = source;
    script.onload = () => resolve();
    script.onerror = () => reject(new Error(`${source} cannot be loaded`));
    document.head.append(script);
  });
}

/** @param {string} url @returns {Promise<Uint8Array>} */
async function fetchRecording(url) {
  const answer = await fetch(url);
  if (!answer.ok) throw new Error(`the recording cannot be fetched (${answer.status})`);
  return new Uint8Array(await answer.arrayBuffer());
}

/** Whether the browser has WebGL 2, which the viewer needs. */
function canDraw() {
  try {
    return document.createElement('canvas').getContext('webgl2') !== null;
  } catch {
    return false;
  }
}

/** @param {string} version @param {'light'|'dark'} theme @param {string} url */
async function start(version, theme, url) {
  if (!canDraw()) {
    fail('no_webgl', 'The viewer draws with WebGL 2, which this browser does not offer.');
    return;
  }
  note.textContent = 'Loading the viewer …';
  console.debug = () => {}; // the viewer logs some thousand messages there while it starts
  const recording = fetchRecording(url);
  recording.catch(() => {}); // reported below
  const base = `/rerun/${encodeURIComponent(version)}`;
  await loadScript(`${base}/re_viewer.js`);
  /* global wasm_bindgen -- of that classic script */
  // @ts-expect-error - it has no types
  const bindgen = /** @type {any} */ (wasm_bindgen);
  await bindgen({ module_or_path: fetch(`${base}/re_viewer_bg.wasm`) });
  handle = /** @type {WebHandle} */ (
    new bindgen.WebHandle({
      url: [],
      render_backend: 'webgl',
      hide_welcome_screen: true,
      enable_history: false,
      notebook: false,
      persist: false,
      theme,
      on_viewer_event: onViewerEvent,
    })
  );
  canvas.hidden = false;
  await handle.start(canvas);
  // The viewer itself loads files without credentials, so it gets the bytes.
  const data = await recording;
  handle.open_channel(CHANNEL, CHANNEL);
  handle.send_rrd_to_channel(CHANNEL, data);
  handle.close_channel(CHANNEL);
  note.textContent = '';
  const healthCheck = setInterval(() => {
    if (!handle?.has_panicked()) return;
    clearInterval(healthCheck);
    fail('crashed', `The viewer has stopped: ${handle.panic_message() ?? 'it gave no reason'}. Reload the page to try again.`);
  }, HEALTH_CHECK_MS);
}

/** @param {string} text   JSON */
function onViewerEvent(text) {
  /** @type {any} */ let event;
  try {
    event = JSON.parse(text);
  } catch {
    return;
  }
  if (event.type === 'recording_open') {
    sync.reset();
    openMessage = { type: 'opened', application: String(event.application_id), recording: String(event.recording_id) };
    setTimeout(announce, MAX_OPENING_MS);
  } else if (event.type === 'timeline_change') {
    timeline = String(event.timeline);
    onTime(Number(event.time));
  } else if (event.type === 'time_update') {
    onTime(Number(event.time));
  } else if (event.type === 'selection_change') {
    const item = event.items?.find((/** @type {any} */ one) => one.type === 'entity');
    postToPage({
      type: 'selected',
      entity: item ? String(item.entity_path) : null,
      instance: typeof item?.instance_id === 'number' ? item.instance_id : null,
    });
  }
}

/** Report that the recording is open, as soon as it has a time cursor; before that the cursor cannot be moved. */
function announce() {
  if (!openMessage) return;
  postToPage(openMessage);
  openMessage = null;
}

/** @param {number} time */
function onTime(time) {
  const frame = Math.floor(time);
  const moved = timeline === TIMELINE && Number.isFinite(frame) ? sync.report(frame) : null;
  announce(); // the page seeks next
  if (moved !== null) postToPage({ type: 'time', frame });
}

/** @param {number} frame */
async function seek(frame) {
  if (!handle || !sync.request(frame)) return;
  for (let tries = 1; ; tries++) {
    try {
      await handle.viewer_control(seekRequest(TIMELINE, frame));
      return;
    } catch (thrown) {
      if (!sync.isNewest(frame)) return; // a newer seek is on its way
      if (tries >= (sync.hasTime() ? MAX_SEEK_TRIES : MAX_EARLY_SEEK_TRIES)) {
        sync.giveUp();
        throw thrown;
      }
      await new Promise((resolve) => setTimeout(resolve, SEEK_RETRY_MS));
    }
  }
}

/** @param {string} entity */
async function select(entity) {
  await handle?.viewer_control(selectRequest(entity));
}

addEventListener('message', (event) => {
  if (event.origin !== location.origin || event.source !== parent) return;
  const message = /** @type {ToFrame|null} */ (readMessage(event.data, ['start', 'seek', 'select']));
  if (!message || hasFailed) return;
  /** @param {unknown} thrown */
  const failed = (thrown) => {
    if (message.type === 'start')
      fail('failed', `The viewer cannot be started: ${thrown instanceof Error ? thrown.message : String(thrown)}.`);
    else postToPage({ type: 'refused', what: message.type, message: thrown instanceof Error ? thrown.message : String(thrown) });
  };
  if (message.type === 'start') start(message.version, message.theme, message.url).catch(failed);
  else if (message.type === 'seek') seek(message.frame).catch(failed);
  else select(message.entity).catch(failed);
});
postToPage({ type: 'ready' });
