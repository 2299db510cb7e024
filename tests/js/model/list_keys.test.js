// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { nextIndex } from '../../../static/js/model/list_keys.js';

test('keys walk a grid and stop at its ends', () => {
  // five items in rows of three
  const cases = /** @type {[string, number, number|null][]} */ ([
    ['ArrowRight', 2, 3],
    ['ArrowRight', 4, 4],
    ['ArrowLeft', 0, 0],
    ['ArrowDown', 1, 4],
    ['ArrowDown', 2, 4],
    ['ArrowDown', 4, 4],
    ['ArrowUp', 1, 1],
    ['ArrowUp', 4, 1],
    ['End', 0, 4],
    ['Home', 4, 0],
    ['PageDown', 0, 4],
    ['x', 0, null],
  ]);
  for (const [key, at, to] of cases) assert.equal(nextIndex(key, at, 5, { page: 2, columns: 3 }), to, `${key} from ${at}`);
  assert.equal(nextIndex('ArrowRight', 1, 5, { page: 2, columns: 1 }), 2, 'a narrow grid is still a grid');
});

test('keys walk a list; left and right are not its own', () => {
  const cases = /** @type {[string, number, number|null][]} */ ([
    ['ArrowDown', 0, 1],
    ['ArrowDown', 4, 4],
    ['ArrowUp', 0, 0],
    ['PageDown', 0, 3],
    ['PageUp', 2, 0],
    ['End', 1, 4],
    ['Home', 3, 0],
    ['ArrowRight', 1, null],
    ['ArrowLeft', 1, null],
    ['ArrowDown', -1, 0],
    ['ArrowUp', -1, 0],
    ['End', -1, 4],
  ]);
  for (const [key, at, to] of cases) assert.equal(nextIndex(key, at, 5, { page: 3 }), to, `${key} from ${at}`);
  assert.equal(nextIndex('Home', 0, 0, { page: 3 }), null);
  assert.equal(nextIndex('End', 0, 5, { page: 3, isInTextField: true }), null, 'in a field of text it is the key of the field');
});
