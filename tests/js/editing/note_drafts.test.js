// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { createNoteDrafts } from '../../../static/js/editing/note_drafts.js';

function memoryStorage() {
  /** @type {Map<string, string>} */
  const stored = new Map();
  const storage = {
    getItem: (/** @type {string} */ name) => stored.get(name) ?? null,
    setItem: (/** @type {string} */ name, /** @type {string} */ value) => void stored.set(name, value),
    removeItem: (/** @type {string} */ name) => void stored.delete(name),
  };
  return { held: stored, storage };
}

test('each track of each run has a note of its own, and a reload finds it', () => {
  const { storage } = memoryStorage();
  const drafts = createNoteDrafts(() => storage);
  drafts.set('r', 'm1', 'first ');
  drafts.set('r', 'm2', 'second');
  assert.deepEqual([drafts.get('r', 'm1'), drafts.get('r', 'm2'), drafts.get('s', 'm1')], ['first ', 'second', '']);
  assert.equal(createNoteDrafts(() => storage).get('r', 'm1'), 'first ');
});

test('listeners of note drafts are called for every change, until their signal is aborted', () => {
  const { storage } = memoryStorage();
  const drafts = createNoteDrafts(() => storage);
  const life = new AbortController();
  let received = 0;
  drafts.onChange(() => void (received += 1), life.signal);
  drafts.set('r', 'm1', 'x');
  life.abort();
  drafts.set('r', 'm1', 'y');
  assert.equal(received, 1);
});

test('a note without words leaves nothing behind', () => {
  const { held, storage } = memoryStorage();
  const drafts = createNoteDrafts(() => storage);
  drafts.set('r', 'm1', 'x');
  drafts.set('r', 'm1', ' \n');
  assert.deepEqual([drafts.get('r', 'm1'), held.size], ['', 0]);
});

test('without storage it is kept as long as the page', () => {
  const drafts = createNoteDrafts(() => {
    throw new Error('refused');
  });
  assert.equal(drafts.get('r', 'm1'), '');
  drafts.set('r', 'm1', 'x');
  assert.equal(drafts.get('r', 'm1'), 'x');
});
