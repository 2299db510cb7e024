// @ts-check
/**
 * The stream of server events, as server-sent events over `fetch`.
 *
 * `EventSource` is not used: it stops for good on the first answer other than 200, for example while the server
 * restarts, and cannot resume after the event number of an earlier connection.
 */

import { sleep } from './sleep.js';

/** @typedef {import('../types.js').ServerEvent} ServerEvent */

/**
 * @typedef {object} Stream
 * @property {() => void} retry     connect anew at once: the present connection may be dead, and waiting is not needed
 * @property {() => void} pause     give the connection up until `resume`; what happens meanwhile arrives after it
 * @property {() => void} resume
 */

/**
 * @typedef {object} StreamOptions
 * @property {(event: ServerEvent) => void} onEvent
 * @property {(connection: 'online'|'offline') => void} [onConnection]   online: no event is missed from now on
 * @property {(text: string|null) => void} [onStorage]   a sentence that says the disk is full; null: there is space again
 * @property {() => void} [onReset]  the server no longer has the missed events: load everything again
 * @property {() => void} [onDenied] access was denied (401, 403): the user has to act
 * @property {typeof fetch} [fetch]
 * @property {(ms: number, signal: AbortSignal) => Promise<void>} [wait]
 * @property {AbortSignal} signal    closes the stream
 */

const MIN_RETRY_DELAY_MS = 500;
const MAX_RETRY_DELAY_MS = 15_000;
/** Time without a byte after which the connection counts as lost, ms; the server sends a heartbeat every 4 s. */
const MAX_SILENCE_MS = 12_000;

/**
 * Receive events until the signal is aborted. Reconnects by itself, with the number of the last event. The first message of a
 * connection, `hello`, carries the current number of the stream; `reset` reports a gap.
 *
 * @param {StreamOptions} options
 * @returns {Stream}
 */
export function openStream(options) {
  const { onEvent, onConnection, onStorage, onReset, onDenied, wait = sleep, signal: closed } = options;
  const fetch = options.fetch ?? globalThis.fetch.bind(globalThis);
  /** Number of the newest received event. @type {number|null} */
  let last = null;
  let delayAborter = new AbortController();
  let silenceAborter = new AbortController();
  let delay = MIN_RETRY_DELAY_MS;
  /** Ends the pause; null: there is none. @type {AbortController|null} */
  let pause = null;

  /** @param {{id: string, event: string, data: string}} message */
  function handleMessage(message) {
    if (message.event === 'reset' || message.event === 'hello') {
      if (last === null || message.event === 'reset') last = Number(message.id);
      if (message.event === 'reset') onReset?.();
      else onConnection?.('online');
      return;
    }
    if (!message.data) return;
    /** @type {any} */
    let event;
    try {
      event = JSON.parse(message.data);
    } catch {
      return; // Half a message of a broken connection; the next connection sends it again.
    }
    if (message.event === 'storage') {
      onStorage?.(event.text);
      return;
    }
    if (message.event === 'unstored') {
      onEvent(event); // a run's end that cannot be stored has no number
      return;
    }
    if (typeof event.seq !== 'number' || (last !== null && event.seq <= last)) return;
    last = event.seq;
    onEvent(event);
  }

  async function listen() {
    const connectionAborter = (silenceAborter = new AbortController());
    /** @type {Record<string, string>} */
    const headers = { Accept: 'text/event-stream' };
    if (last !== null) headers['Last-Event-ID'] = String(last);
    /** @type {ReturnType<typeof setTimeout>|undefined} */
    let timer;
    const restartSilenceTimer = () => {
      clearTimeout(timer);
      timer = setTimeout(() => connectionAborter.abort(), MAX_SILENCE_MS);
    };
    restartSilenceTimer();
    try {
      const signal = AbortSignal.any([closed, connectionAborter.signal]);
      const answer = await fetch('/api/events', { headers, signal, credentials: 'same-origin' });
      if (answer.status === 401 || answer.status === 403) {
        onDenied?.();
        throw new Error(`events: ${answer.status}`);
      }
      if (!answer.ok || !answer.body) throw new Error(`events: ${answer.status}`);
      const parse = createParser(handleMessage);
      const decoder = new TextDecoder();
      const reader = answer.body.getReader();
      for (;;) {
        const { done, value } = await reader.read();
        if (done) return;
        restartSilenceTimer();
        delay = MIN_RETRY_DELAY_MS;
        parse(decoder.decode(value, { stream: true }));
      }
    } finally {
      clearTimeout(timer);
    }
  }

  async function run() {
    while (!closed.aborted) {
      if (pause !== null) await aborted(AbortSignal.any([closed, pause.signal]));
      if (closed.aborted) return;
      try {
        await listen();
      } catch {
        // Any failure is treated alike: report it, wait, connect again.
      }
      if (closed.aborted) return;
      if (pause !== null) continue;
      onConnection?.('offline');
      delayAborter = new AbortController();
      await wait(delay, AbortSignal.any([closed, delayAborter.signal]));
      delay = Math.min(delay * 2, MAX_RETRY_DELAY_MS);
    }
  }

  function reconnect() {
    delay = MIN_RETRY_DELAY_MS;
    silenceAborter.abort();
    delayAborter.abort();
  }

  void run();
  return {
    retry: reconnect,
    pause: () => {
      if (pause !== null) return;
      pause = new AbortController();
      reconnect();
    },
    resume: () => {
      pause?.abort();
      pause = null;
    },
  };
}

/** Resolves when the signal is aborted. @param {AbortSignal} signal @returns {Promise<void>} */
const aborted = (signal) =>
  new Promise((resolve) => {
    if (signal.aborted) resolve();
    else signal.addEventListener('abort', () => resolve(), { once: true });
  });

/**
 * A parser of server-sent events. It accepts text in chunks of any size.
 *
 * @param {(message: {id: string, event: string, data: string}) => void} emit
 * @returns {(text: string) => void}
 */
export function createParser(emit) {
  let buffer = '';
  let id = '';
  let event = '';
  /** @type {string[]} */
  let data = [];

  /** @param {string} line */
  function parseLine(line) {
    if (line === '') {
      if (data.length || event) emit({ id, event: event || 'message', data: data.join('\n') });
      event = '';
      data = [];
      return;
    }
    const colon = line.indexOf(':');
    if (colon === 0) return; // A comment: the server's heartbeat.
    const name = colon < 0 ? line : line.slice(0, colon);
    const value = colon < 0 ? '' : line.slice(colon + 1).replace(/^ /, '');
    if (name === 'id') id = value;
    else if (name === 'event') event = value;
    else if (name === 'data') data.push(value);
  }

  return (text) => {
    buffer += text;
    // A CR at the end may be half of CR LF, so it waits for the next chunk.
    for (;;) {
      const match = /\r\n|\n|\r(?!$)/.exec(buffer);
      if (!match) return;
      parseLine(buffer.slice(0, match.index));
      buffer = buffer.slice(match.index + match[0].length);
    }
  };
}
