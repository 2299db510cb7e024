// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { ApiError } from '../../../static/js/api/errors.js';
import { pollUntilFinished } from '../../../static/js/views/poll_output.js';

/** Waits for a file, with an answer or an error for each request. @param {(string|ApiError)[]} answers @param {() => boolean} [left] */
async function waited(answers, left = () => false) {
  const rest = [...answers];
  const ask = async (/** @type {string} */ id) => {
    const next = rest.shift();
    if (next instanceof ApiError) throw next;
    return { id, state: String(next) };
  };
  const file = await pollUntilFinished({ id: 'f', state: 'queued' }, ask, { intervalMs: 1, isAbandoned: left });
  return [file?.state, rest.length];
}

test('a file that is being made is waited for while the server is away or late', async () => {
  const away = new ApiError(0, 'offline', 'No answer.');
  const late = new ApiError(0, 'timeout', 'Late.');
  assert.deepEqual(await waited(['running', away, late, away, 'running', 'complete']), ['complete', 0]);
  assert.deepEqual(await waited([away, 'failed', 'complete']), ['failed', 1]);
});

test('a file that was removed, and a person who has left, end the waiting', async () => {
  await assert.rejects(waited([new ApiError(404, 'not_found', 'Gone.'), 'complete']), /Gone/);
  assert.deepEqual(await waited(['running', 'complete'], () => true), [undefined, 2]);
});
