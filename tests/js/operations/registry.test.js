// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { allOperations } from '../../../static/js/operations/registry.js';
import { initialState } from '../../../static/js/store/initial.js';
import { pluck } from '../pluck.js';

const operations = allOperations();
/** Keys that the product promises. */
const DOCUMENTED = [
  ...'F D V C Space R E N M Alt+M K O Q Del Shift+Del Ctrl+Z Ctrl+Shift+Z 1 2 3 4 5'.split(' '),
  ...'6 7 8 J Shift+J T Shift+T Alt+T [ ] A X L Ctrl+S F1 Ctrl+K Shift+L 9 Shift+9'.split(' '),
];

test('a short name is a part of the name, as who speaks to the page says what is written', () => {
  for (const { label, short = '' } of operations) assert.ok(label.toLowerCase().includes(short.toLowerCase()), label);
});

test('every promised key does something, and no key does two things but Enter and Escape, which are about proposals while there are any', () => {
  const keys = operations.flatMap((operation) => operation.keys);
  assert.deepEqual(
    DOCUMENTED.filter((key) => !keys.includes(key)),
    [],
  );
  assert.deepEqual(keys.filter((key, at) => keys.indexOf(key) !== at).sort(), ['Enter', 'Escape']);
  assert.deepEqual(
    pluck(
      operations.filter((one) => one.keys.includes('Enter')),
      'id',
    ),
    ['accept-follow', 'mark'],
  );
  assert.deepEqual(
    pluck(
      operations.filter((one) => one.keys.includes('Escape')),
      'id',
    ),
    ['drop-follow', 'select-mode'],
  );
});

test('frames are stepped with the keys that CVAT has for it', () => {
  const keyOf = (/** @type {string} */ id) => operations.find((operation) => operation.id === id)?.keys[0];
  assert.deepEqual(['next-frame', 'previous-frame', 'on-10', 'back-10', 'next-key', 'previous-key'].map(keyOf), [
    'F',
    'D',
    'V',
    'C',
    'R',
    'E',
  ]);
});

test('names are unique; every operation says what it does', () => {
  assert.equal(new Set(operations.map(({ id }) => id)).size, operations.length);
  for (const { id, label, tooltip, group } of operations) assert.ok(label && tooltip && group, id);
});

test('outside the review screen only what belongs to the whole page can be had', () => {
  assert.deepEqual(
    pluck(
      operations.filter((operation) => operation.available(initialState())),
      'id',
    ),
    [
      ...'open-add-video open-run-queue open-export open-import-bundle open-retrain'.split(' '),
      ...'palette help preferences theme-auto theme-light theme-dark'.split(' '),
      ...'screen-library screen-search screen-files screen-labels screen-models'.split(' '),
    ],
  );
  const session = /** @type {any} */ ({ person: { name: 'Ada', role: 'annotator' } });
  assert.deepEqual(
    operations
      .filter((operation) => operation.available({ ...initialState(), session }))
      .map(({ id }) => id)
      .filter((id) => /^(open|screen-team)/.test(id)),
    ['screen-team'],
  );
});

test('keys that move may be held; one that judges, cuts, marks or opens something happens once for each press', () => {
  assert.deepEqual(
    operations.filter(({ repeats }) => repeats).flatMap(({ keys }) => keys),
    [
      ...'D F C V R E J Shift+J Tab Shift+Tab'.split(' '),
      ...['Left', 'Right', 'Up', 'Down'].flatMap((arrow) => [`Arrow${arrow}`, `Shift+Arrow${arrow}`, `Alt+Arrow${arrow}`]),
      'Ctrl+Z',
      'Ctrl+Shift+Z',
      'Ctrl+Y',
    ],
  );
});
