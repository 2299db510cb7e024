// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { createMemoryOutbox } from '../../../static/js/editing/outbox.js';
import { createUserOutbox } from '../../../static/js/editing/user_outbox.js';

/** @param {string} op_id @param {string} author @returns {any} */
const pending = (op_id, author) => ({ op_id, run: 'r', author, command: { name: 'undo', op_id: '' }, seen: {} });

test('unsaved edits of another person wait for that person', async () => {
  const inner = createMemoryOutbox();
  for (const one of [pending('1', 'ann'), pending('2', 'bob'), pending('3', 'ann')]) await inner.put(one);
  /** @type {string|null} */ let person = 'ann';
  const outbox = createUserOutbox(inner, Promise.resolve(), () => person);
  const ids = async () => [(await outbox.all()).map(({ op_id }) => op_id), (await outbox.load('r')).map(({ op_id }) => op_id)];
  assert.deepEqual(await ids(), [
    ['1', '3'],
    ['1', '3'],
  ]);
  await outbox.remove('1');
  person = 'bob';
  assert.deepEqual(await ids(), [['2'], ['2']]);
  person = null;
  assert.deepEqual(await ids(), [
    ['2', '3'],
    ['2', '3'],
  ]);
});

test('the outbox is not read before the person is known', async () => {
  const inner = createMemoryOutbox();
  await inner.put(pending('1', 'ann'));
  let resolvePerson = () => {};
  const outbox = createUserOutbox(inner, new Promise((resolve) => (resolvePerson = () => resolve(undefined))), () => 'bob');
  let read = false;
  const all = outbox.all().finally(() => (read = true));
  await new Promise((resolve) => setTimeout(resolve, 5));
  assert.equal(read, false);
  resolvePerson();
  assert.deepEqual(await all, []);
});
