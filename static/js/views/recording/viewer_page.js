// @ts-check
/**
 * Runs in the page `/rerun/viewer.html`: starts the viewer on its canvas, and translates between it and the outer page.
 * `messages.js` defines the messages.
 */

import { readMessage } from './messages.js';
import { seekRequest, selectRequest } from './protocol.js';

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
const MOST_ASKED = 32;
/** The longest time until a recording counts as open, ms. */
const LONGEST_OPENING = 5000;
/** Number of attempts to seek while the viewer loads the recording, and the pause between them, ms. */
const TRIES = 40;
const PAUSE = 150;
/** Interval of checks whether the viewer still runs, ms. */
const PULSE = 1000;

const canvas = /** @type {HTMLCanvasElement} */ (document.getElementById('viewer'));
const note = /** @type {HTMLElement} */ (document.getElementById('note'));
/** @type {WebHandle|null} */
let handle = null;
/** The present timeline; recordings open on this one. */
let timeline = TIMELINE;
/** The frame that both sides know. @type {number|null} */
let reported = null;
/** Frames that the page has requested and the viewer has not shown yet. The page is not notified of these. @type {number[]} */
let asked = [];
/** The message to send when the recording is open. @type {FromFrame|null} */
let opening = null;
let broken = false;

/** @param {FromFrame} message */
function tell(message) {
  if (parent !== window) parent.postMessage(message, location.origin);
}

/** @param {string} reason @param {string} message */
function fail(reason, message) {
  if (broken) return;
  broken = true;
  canvas.hidden = true;
  note.textContent = message;
  tell({ type: 'failed', reason, message });
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
      on_viewer_event: received,
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
  const pulse = setInterval(() => {
    if (!handle?.has_panicked()) return;
    clearInterval(pulse);
    fail('crashed', `The viewer has stopped: ${handle.panic_message() ?? 'it gave no reason'}. Reload the page to try again.`);
  }, PULSE);
}

/** @param {string} text   JSON */
function received(text) {
  /** @type {any} */
  let event;
  try {
    event = JSON.parse(text);
  } catch {
    return;
  }
  if (event.type === 'recording_open') {
    opening = { type: 'opened', application: String(event.application_id), recording: String(event.recording_id) };
    setTimeout(announce, LONGEST_OPENING);
  } else if (event.type === 'timeline_change') {
    timeline = String(event.timeline);
    receivedTime(Number(event.time));
  } else if (event.type === 'time_update') {
    receivedTime(Number(event.time));
  } else if (event.type === 'selection_change') {
    const item = event.items?.find((/** @type {any} */ one) => one.type === 'entity');
    tell({
      type: 'selected',
      entity: item ? String(item.entity_path) : null,
      instance: typeof item?.instance_id === 'number' ? item.instance_id : null,
    });
  }
}

/** Report that the recording is open, as soon as it has a time cursor; before that the cursor cannot be moved. */
function announce() {
  if (!opening) return;
  tell(opening);
  opening = null;
}

/** @param {number} time */
function receivedTime(time) {
  const frame = Math.floor(time);
  if (opening) reported = frame; // the viewer's own initial frame; the page seeks next
  announce();
  if (timeline !== TIMELINE || !Number.isFinite(frame)) return;
  const place = asked.indexOf(frame);
  if (place >= 0) {
    asked = asked.slice(place + 1);
    reported = frame;
  }
  if (frame === reported) return;
  reported = frame;
  tell({ type: 'time', frame });
}

/** @param {number} frame */
async function seek(frame) {
  if (!handle || (frame === reported && asked.length === 0)) return;
  asked = [...asked, frame].slice(-MOST_ASKED);
  for (let tries = 1; ; tries++) {
    try {
      await handle.viewer_control(seekRequest(TIMELINE, frame));
      return;
    } catch (thrown) {
      if (asked.at(-1) !== frame) return; // a newer seek is on its way
      if (tries >= TRIES) {
        asked = [];
        throw thrown;
      }
      await new Promise((resolve) => setTimeout(resolve, PAUSE));
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
  if (!message || broken) return;
  /** @param {unknown} thrown */
  const failed = (thrown) => {
    if (message.type === 'start')
      fail('failed', `The viewer cannot be started: ${thrown instanceof Error ? thrown.message : String(thrown)}.`);
    else tell({ type: 'refused', what: message.type, message: thrown instanceof Error ? thrown.message : String(thrown) });
  };
  if (message.type === 'start') start(message.version, message.theme, message.url).catch(failed);
  else if (message.type === 'seek') seek(message.frame).catch(failed);
  else select(message.entity).catch(failed);
});
tell({ type: 'ready' });
