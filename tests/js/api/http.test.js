// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { ApiError } from '../../../static/js/api/errors.js';
import { createApi } from '../../../static/js/api/client.js';

/**
 * An API whose server answers as told.
 * @param {(url: string, init: RequestInit) => Response|Promise<Response>} answer
 */
function apiOf(answer) {
  /** @type {{url: string, init: RequestInit}[]} */
  const calls = [];
  const fetch = /** @type {typeof globalThis.fetch} */ (
    async (url, init = {}) => {
      calls.push({ url: String(url), init });
      return answer(String(url), init);
    }
  );
  return { api: createApi({ fetch }), calls };
}

/** @param {unknown} value @param {number} [status] */
const json = (value, status = 200) => new Response(JSON.stringify(value), { status, headers: { 'Content-Type': 'application/json' } });

test('the error of the server arrives with code, field and details', async () => {
  const { api } = apiOf(() =>
    json({ error: { code: 'stale', message: 'Somebody was first.', field: 'key', details: { current: [1] } } }, 409),
  );
  await assert.rejects(api.run('a'), (/** @type {any} */ error) => {
    assert.ok(error instanceof ApiError);
    assert.deepEqual(
      [error.status, error.code, error.message, error.field, error.details.current],
      [409, 'stale', 'Somebody was first.', 'key', [1]],
    );
    assert.equal(error.isTemporary, false);
    return true;
  });
});

test('an answer of something else than our server is still a sentence', async () => {
  const { api } = apiOf(() => new Response('<h1>Too large</h1>', { status: 413 }));
  await assert.rejects(
    api.videos(),
    (/** @type {any} */ error) => error.code === 'bad_answer' && !error.isTemporary && /413/.test(error.message),
  );
});

test('a page that a proxy sends in place of the answer is not taken for a server that cannot be reached', async () => {
  const { api } = apiOf(() => new Response('<h1>Sign in</h1>'));
  await assert.rejects(api.videos(), { code: 'bad_answer', message: /^The answer is not from the review tool/ });
});

test('a proxy without the server says as much as no answer', async () => {
  for (const [status, code] of [
    [502, 'offline'],
    [503, 'offline'],
    [504, 'timeout'],
  ]) {
    const { api } = apiOf(() => new Response('<h1>Bad gateway</h1>', { status: Number(status) }));
    await assert.rejects(
      api.videos(),
      (/** @type {any} */ error) => error.status === 0 && error.code === code && error.isTemporary && !/50\d/.test(error.message),
    );
  }
});

test('no answer is "offline", a cancelled request "aborted"', async () => {
  const { api } = apiOf(() => Promise.reject(new TypeError('Failed to fetch')));
  await assert.rejects(api.videos(), (/** @type {any} */ error) => error.status === 0 && error.code === 'offline' && error.isTemporary);
  const stop = new AbortController();
  stop.abort();
  const waiting = apiOf((_, init) => new Promise((_resolve, reject) => reject(init.signal?.reason)));
  await assert.rejects(
    waiting.api.videos({ signal: stop.signal }),
    (/** @type {any} */ error) => error.code === 'aborted' && !error.isTemporary,
  );
});

test('a time limit ends a request that hangs', async () => {
  const { api } = apiOf(
    (_, init) => new Promise((_resolve, reject) => init.signal?.addEventListener('abort', () => reject(init.signal?.reason))),
  );
  // The clock of the limit does not keep Node alive by itself.
  const alive = setInterval(() => {}, 5);
  await assert.rejects(api.videos({ timeout: 20 }), (/** @type {any} */ error) => error.code === 'timeout');
  clearInterval(alive);
});

test('a wrong shape names route and field', async () => {
  const { api } = apiOf(() => json({ videos: [{ id: 'x', name: 3 }] }));
  await assert.rejects(api.videos(), /GET \/videos\[0\].*'name'/);
});

test('columns of different lengths are refused', async () => {
  const { api } = apiOf(() => json({ track: [1, 2], first: [0], last: [5, 6], source: [0, 0] }));
  await assert.rejects(api.lanes('a'), /column 'first'/);
});

test('an edit carries the revision of every touched track', async () => {
  const { api, calls } = apiOf(() => json({ op_id: 'o', seq: 4, docs: [], undo: null, redo: null }));
  await api.edit('r', { op_id: 'o', author: 'me', command: { name: 'merge', key: 'm1', frame: 3, others: ['m2'] } }, { m1: 3, m2: 0 });
  assert.equal(new Headers(calls[0].init.headers).get('If-Match'), '"m1:3", "m2:0"');
  assert.equal(calls[0].init.method, 'POST');
  assert.equal(JSON.parse(String(calls[0].init.body)).command.others[0], 'm2');
});

test('a frame says which ordinal it is, or it is refused', async () => {
  const good = apiOf(() => new Response('x', { headers: { 'X-Frame-Ordinal': '7' } }));
  const frame = await good.api.frame('v', 7, { width: 640 });
  assert.equal(frame.ordinal, 7);
  assert.match(good.calls[0].url, /\/frames\/7\?width=640$/);
  await assert.rejects(apiOf(() => new Response('x')).api.frame('v', 7), /ordinal/);
});

test('names are escaped in addresses', () => {
  const { api } = apiOf(() => json({}));
  assert.equal(api.thumbnailUrl('../x?y'), '/api/videos/..%2Fx%3Fy/thumbnail');
});
