// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { ApiError } from '../../../static/js/api/errors.js';
import { pollUntilFinished } from '../../../static/js/views/poll_output.js';

/** Polls a file with an answer or an error for each request. @param {(string|ApiError)[]} answers @param {() => boolean} [isAbandoned] */
async function poll(answers, isAbandoned = () => false) {
  const remaining = [...answers];
  const fetchFile = async (/** @type {string} */ id) => {
    const next = remaining.shift();
    if (next instanceof ApiError) throw next;
    return { id, state: String(next) };
  };
  const file = await pollUntilFinished({ id: 'f', state: 'queued' }, fetchFile, { intervalMs: 1, isAbandoned: isAbandoned });
  return [file?.state, remaining.length];
}

test('polling continues while the server is unreachable or slow', async () => {
  const offline = new ApiError(0, 'offline', 'No answer.');
  const timedOut = new ApiError(0, 'timeout', 'Late.');
  assert.deepEqual(await poll(['running', offline, timedOut, offline, 'running', 'complete']), ['complete', 0]);
  assert.deepEqual(await poll([offline, 'failed', 'complete']), ['failed', 1]);
});

test('polling ends when the file is removed or the view is closed', async () => {
  await assert.rejects(poll([new ApiError(404, 'not_found', 'Gone.'), 'complete']), /Gone/);
  assert.deepEqual(await poll(['running', 'complete'], () => true), [undefined, 2]);
});
