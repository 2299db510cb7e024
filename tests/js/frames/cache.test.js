// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { createFrameCache } from '../../../static/js/frames/cache.js';
import { tick } from '../wait_until.js';

/** @param {number} maxBytes */
function createCache(maxBytes) {
  /** @type {Map<number, {answer: (ordinal?: number) => void, reject: () => void, aborted: boolean}>} */
  const requests = new Map();
  /** @type {number[]} */
  const closed = [];
  const api = /** @type {any} */ ({
    frame: (/** @type {string} */ _video, /** @type {number} */ frame, /** @type {any} */ { signal }) =>
      new Promise((resolve, reject) => {
        const request = {
          answer: (ordinal = frame) => resolve({ blob: frame, ordinal, exact: true }),
          reject: () => reject(new Error('The file is gone.')),
          aborted: false,
        };
        signal.addEventListener('abort', () => {
          request.aborted = true;
          reject(new DOMException('', 'AbortError'));
        });
        requests.set(frame, request);
      }),
  });
  const decode = async (/** @type {any} */ frame) => /** @type {any} */ ({ width: 10, height: 10, close: () => closed.push(frame) });
  return { cache: createFrameCache(api, 'v', { maxBytes, decode }), asked: requests, closed };
}

test('a picture of another ordinal is never handed out', async () => {
  const { cache, asked } = createCache(1e6);
  const loading = cache.load(7);
  asked.get(7)?.answer(8);
  await assert.rejects(loading, /Asked for frame 7, got 8/);
  assert.equal(cache.peek(7), null);
});

test('memory is bounded, and recently used pictures stay', async () => {
  const { cache, asked, closed } = createCache(400 * 3);
  for (const frame of [1, 2, 3]) {
    const loading = cache.load(frame);
    asked.get(frame)?.answer();
    await loading;
  }
  cache.peek(1);
  const loading = cache.load(4);
  asked.get(4)?.answer();
  await loading;
  assert.deepEqual(closed, [2]);
  assert.ok(cache.peek(1) && cache.peek(3) && cache.peek(4));
});

test('a seek cancels earlier prefetches and the load that it replaces', async () => {
  const { cache, asked } = createCache(1e6);
  const stale = cache.load(10);
  stale.catch(() => {});
  cache.prefetch([11, 12]);
  void cache.load(500);
  cache.prefetch([501]);
  assert.deepEqual(
    [10, 11, 12].map((frame) => asked.get(frame)?.aborted),
    [true, true, true],
  );
  assert.equal(asked.get(500)?.aborted, false);
  await assert.rejects(stale, { name: 'AbortError' });
});

test('a cancelled picture that is needed again is requested again', async () => {
  const { cache, asked } = createCache(1e6);
  void cache.load(1);
  cache.prefetch([2]);
  cache.prefetch([]);
  assert.equal(asked.get(2)?.aborted, true);
  const again = cache.load(2);
  asked.get(2)?.answer();
  assert.equal((await again).frame, 2);
});

test('no more than five requests at once, and the rest follow', async () => {
  const { cache, asked } = createCache(1e6);
  cache.prefetch([1, 2, 3, 4, 5, 6, 7]);
  assert.equal(asked.size, 5);
  asked.get(1)?.answer();
  await tick();
  assert.equal(asked.size, 6);
});

test('after the end nothing is kept', async () => {
  const { cache, asked, closed } = createCache(1e6);
  const loading = cache.load(1);
  asked.get(1)?.answer();
  await loading;
  cache.clear();
  assert.deepEqual(closed, [1]);
});

test('a soft preview is shown until the picture is requested, and never replaces it', async () => {
  /** @type {boolean[]} */
  const requests = [];
  /** @type {string[]} */
  const closed = [];
  const api = /** @type {any} */ ({
    frame: async (/** @type {string} */ _video, /** @type {number} */ frame, /** @type {any} */ { preview }) => {
      requests.push(preview);
      return { blob: preview ? 'soft' : 'sharp', ordinal: frame, exact: !preview };
    },
  });
  const decode = async (/** @type {any} */ blob) => /** @type {any} */ ({ width: 1, height: 1, close: () => closed.push(blob) });
  const cache = createFrameCache(api, 'v', { decode });
  assert.equal((await cache.preview(5)).width, 0);
  assert.equal(cache.peek(5)?.width, 0);
  assert.equal((await cache.load(5)).width, 1280);
  assert.deepEqual(closed, ['soft']);
  assert.equal((await cache.preview(5)).width, 1280); // it is there: nothing is asked
  assert.deepEqual(requests, [true, false]);
});

test('the picture does not wait for a preview that is still on its way', async () => {
  /** @type {boolean[]} */
  const aborted = [];
  const api = /** @type {any} */ ({
    frame: (/** @type {string} */ _video, /** @type {number} */ frame, /** @type {any} */ { preview, signal }) =>
      new Promise((resolve, reject) => {
        if (!preview) resolve({ blob: 'sharp', ordinal: frame, exact: true });
        signal.addEventListener('abort', () => {
          aborted.push(preview);
          reject(new DOMException('', 'AbortError'));
        });
      }),
  });
  const decode = async () => /** @type {any} */ ({ width: 1, height: 1, close: () => {} });
  const cache = createFrameCache(api, 'v', { decode });
  const soft = cache.preview(5);
  soft.catch(() => {});
  assert.equal((await cache.load(5)).width, 1280);
  assert.deepEqual(aborted, [true]);
});

test('a picture that is requested wider while it loads is loaded wider', async () => {
  /** @type {number[]} */
  const widths = [];
  const api = /** @type {any} */ ({
    frame: (/** @type {string} */ _video, /** @type {number} */ frame, /** @type {any} */ { width, signal }) =>
      new Promise((resolve, reject) => {
        widths.push(width);
        if (width === 2560) resolve({ blob: 'sharp', ordinal: frame, exact: true });
        signal.addEventListener('abort', () => reject(new DOMException('', 'AbortError')));
      }),
  });
  const cache = createFrameCache(api, 'v', { decode: async () => /** @type {any} */ ({ width: 1, height: 1, close: () => {} }) });
  cache.load(5).catch(() => {});
  cache.setWidth(640);
  cache.load(5).catch(() => {});
  cache.setWidth(2560);
  const picture = cache.load(5);
  assert.deepEqual(widths, [1280, 2560]);
  assert.equal((await picture).width, 2560);
});

test('while requested pictures fail, nothing is prefetched', async () => {
  const { cache, asked } = createCache(1e6);
  const gone = cache.load(3);
  cache.prefetch([4, 5]);
  asked.get(3)?.reject();
  await assert.rejects(gone, /gone/);
  for (const frame of [4, 5]) asked.get(frame)?.reject();
  await tick();
  cache.prefetch([6, 7]);
  await tick();
  assert.equal(asked.has(6), false);
  const back = cache.load(8);
  asked.get(8)?.answer();
  await back;
  cache.prefetch([9]);
  assert.equal(asked.has(9), true);
});
