// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { createParser, openStream } from '../../../static/js/api/events.js';
import { deferred } from '../deferred.js';
import { waitUntil } from '../wait_until.js';

/** @param {string} text @param {number} size @returns {string[]} */
const pieces = (text, size) => Array.from({ length: Math.ceil(text.length / size) }, (_, at) => text.slice(at * size, (at + 1) * size));

test('messages come out whole, however the text is cut and whichever line ends it has', () => {
  for (const end of ['\n', '\r\n', '\r']) {
    const text = ['id: 5', 'event: change', 'data: {"a":', 'data: 1}', '', ': beat', '', 'id: 6', 'data: x', '', ''].join(end);
    for (const size of [1, 2, 3, 7, 100]) {
      /** @type {any[]} */
      const seen = [];
      const parse = createParser((message) => seen.push(message));
      pieces(text, size).forEach(parse);
      parse('\n');
      assert.deepEqual(
        seen,
        [
          { id: '5', event: 'change', data: '{"a":\n1}' },
          { id: '6', event: 'message', data: 'x' },
        ],
        `${JSON.stringify(end)} by ${size}`,
      );
    }
  }
});

/** @param {number} seq */
const change = (seq) => `id: ${seq}\nevent: change\ndata: {"seq":${seq},"kind":"run","subject":"r","data":{}}\n\n`;

/**
 * Connections that each give some text and then break; afterwards the server is silent.
 * @param {(string|number)[]} script   text, or the status of a refusal
 */
async function runScript(script) {
  const seen = /** @type {number[]} */ ([]);
  const lastEventIds = /** @type {(string|null)[]} */ ([]);
  const states = /** @type {string[]} */ ([]);
  const waits = /** @type {number[]} */ ([]);
  const storage = /** @type {(string|null)[]} */ ([]);
  let resets = 0;
  let denied = 0;
  const { promise: finished, resolve: finish } = deferred();
  const fetch = /** @type {any} */ (
    async (/** @type {string} */ _, /** @type {RequestInit} */ init) => {
      lastEventIds.push(new Headers(init.headers).get('Last-Event-ID'));
      const next = script.shift();
      if (next === undefined) {
        finish();
        return new Promise((_, refuse) => init.signal?.addEventListener('abort', refuse)); // as a browser's does
      }
      return typeof next === 'number' ? new Response('', { status: next }) : new Response(next);
    }
  );
  const end = new AbortController();
  openStream({
    fetch,
    signal: end.signal,
    onEvent: (event) => seen.push(event.seq),
    onConnection: (state) => states.push(state),
    onStorage: (text) => storage.push(text),
    onReset: () => (resets += 1),
    onDenied: () => (denied += 1),
    wait: async (ms) => {
      waits.push(ms);
    },
  });
  await finished;
  end.abort();
  return { seen, asked: lastEventIds, states, waits, storage, resets, denied };
}

test('a broken stream continues after the last number, without gaps or repeats', async () => {
  const found = await runScript([
    `id: 3\nevent: hello\ndata: {"seq": 3}\n\n${change(4)}${change(5)}`,
    `id: 5\nevent: hello\ndata: {}\n\n${change(5)}${change(6)}`,
  ]);
  assert.deepEqual(found.seen, [4, 5, 6]);
  assert.deepEqual(found.asked, [null, '5', '6']);
  assert.deepEqual(found.states, ['online', 'offline', 'online', 'offline']);
});

test('an event before the number zero is not lost: the first hello counts', async () => {
  const found = await runScript(['id: 0\nevent: hello\ndata: {}\n\n', change(1)]);
  assert.deepEqual(found.asked, [null, '0', '1']);
  assert.deepEqual(found.seen, [1]);
});

test('half a message of a broken connection is dropped', async () => {
  const found = await runScript([`id: 1\nevent: hello\ndata: {}\n\n${change(2)}id: 3\nevent: change\ndata: {"seq":3,`, change(3)]);
  assert.deepEqual(found.seen, [2, 3]);
});

test('refusals wait longer each time; the number after a reset counts from there', async () => {
  const found = await runScript([503, 503, 503, `id: 40\nevent: reset\ndata: {}\n\n${change(41)}`]);
  assert.deepEqual(found.waits.slice(0, 3), [500, 1000, 2000]);
  assert.equal(found.resets, 1);
  assert.deepEqual(found.seen, [41]);
});

test('the end of a run that cannot be stored is received although it has no number', async () => {
  const unstored = 'event: unstored\ndata: {"kind":"run","subject":"r","data":{"note":"over"}}\n\n';
  const found = await runScript([`id: 3\nevent: hello\ndata: {"seq": 3}\n\n${unstored}${change(4)}`]);
  assert.deepEqual(found.seen, [undefined, 4]);
  assert.deepEqual(found.asked, [null, '4']);
});

test('a full disk is reported beside the numbered stream', async () => {
  const full = (/** @type {string} */ text) => `event: storage\ndata: {"text":${text}}\n\n`;
  const found = await runScript([`id: 3\nevent: hello\ndata: {"seq": 3}\n\n${full('"full"')}${change(4)}${full('null')}`]);
  assert.deepEqual(found.storage, ['full', null]);
  assert.deepEqual(found.seen, [4]);
  assert.deepEqual(found.asked, [null, '4']);
});

test('a lost credential is distinguished from a lost server', async () => {
  const found = await runScript([401, 'id: 1\nevent: hello\ndata: {}\n\n']);
  assert.equal(found.denied, 1);
});

test('a connection without a byte for twelve seconds, three heartbeats, counts as lost', async (context) => {
  context.mock.timers.enable({ apis: ['setTimeout'] });
  const states = /** @type {string[]} */ ([]);
  /** @type {ReadableStreamDefaultController<Uint8Array>|undefined} */
  let bytes;
  const fetch = /** @type {any} */ (
    async (/** @type {string} */ _, /** @type {RequestInit} */ { signal }) => {
      const body = new ReadableStream({ start: (controller) => void (bytes = controller) });
      signal?.addEventListener('abort', () => bytes?.error(new Error('aborted')));
      return new Response(body);
    }
  );
  const end = new AbortController();
  openStream({
    fetch,
    signal: end.signal,
    onEvent: () => {},
    onConnection: (state) => states.push(state),
    wait: () => new Promise(() => {}),
  });
  const read = () => new Promise((resolve) => setImmediate(resolve));
  await read();
  bytes?.enqueue(new TextEncoder().encode('id: 1\nevent: hello\ndata: {}\n\n'));
  await read();
  context.mock.timers.tick(11_000);
  bytes?.enqueue(new TextEncoder().encode(': still here\n\n'));
  await read();
  context.mock.timers.tick(11_000);
  await read();
  assert.deepEqual(states, ['online']);
  context.mock.timers.tick(1000);
  await read();
  assert.deepEqual(states, ['online', 'offline']);
  end.abort();
});

test('a paused stream has no connection and continues after the last number', async () => {
  /** @type {(string|null)[]} */ const asked = [];
  /** @type {string[]} */ const states = [];
  /** @type {number[]} */ const seen = [];
  let connections = 0;
  const end = new AbortController();
  const stream = openStream({
    signal: end.signal,
    fetch: /** @type {any} */ (
      async (/** @type {string} */ _, /** @type {RequestInit} */ init) => {
        asked.push(new Headers(init.headers).get('Last-Event-ID'));
        connections += 1;
        const body = new ReadableStream({
          start(controller) {
            const first = asked.length === 1 ? 'id: 3\nevent: hello\ndata: {}\n\n' + change(4) : change(5);
            controller.enqueue(new TextEncoder().encode(first));
            init.signal?.addEventListener('abort', () => ((connections -= 1), controller.error(new Error('aborted'))));
          },
        });
        return new Response(body);
      }
    ),
    onEvent: (event) => seen.push(event.seq),
    onConnection: (state) => states.push(state),
    wait: async () => {},
  });
  await waitUntil(() => seen.length === 1);
  stream.pause();
  stream.pause();
  await waitUntil(() => connections === 0);
  for (let turn = 0; turn < 50; turn += 1) await Promise.resolve();
  stream.retry(); // the network is back, but nobody looks
  for (let turn = 0; turn < 50; turn += 1) await Promise.resolve();
  assert.deepEqual([asked.length, connections], [1, 0]);
  stream.resume();
  await waitUntil(() => seen.length === 2);
  assert.deepEqual([asked, states, seen], [[null, '4'], ['online'], [4, 5]], 'it was never offline');
  stream.pause();
  await waitUntil(() => connections === 0);
  end.abort();
});

test('a retry ends a connection that may be dead, and the next one continues after the last number', async () => {
  const requestedIds = /** @type {(string|null)[]} */ ([]);
  const fetch = /** @type {any} */ (
    async (/** @type {string} */ _, /** @type {RequestInit} */ { headers, signal }) => {
      requestedIds.push(new Headers(headers).get('Last-Event-ID'));
      const body = new ReadableStream({
        start(controller) {
          controller.enqueue(new TextEncoder().encode('id: 7\nevent: hello\ndata: {}\n\n'));
          signal?.addEventListener('abort', () => controller.error(new Error('aborted')));
        },
      });
      return new Response(body);
    }
  );
  const states = /** @type {string[]} */ ([]);
  const end = new AbortController();
  const onConnection = (/** @type {string} */ state) => states.push(state);
  const stream = openStream({ fetch, signal: end.signal, onEvent: () => {}, onConnection, wait: async () => {} });
  await waitUntil(() => states.length === 1);
  stream.retry();
  await waitUntil(() => states.length === 3);
  end.abort();
  assert.deepEqual(states, ['online', 'offline', 'online']);
  assert.deepEqual(requestedIds, [null, '7']);
});
