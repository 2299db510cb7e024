// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { placeLabels } from '../../../static/js/model/label_layout.js';

/** @typedef {import('../../../static/js/types.js').Box} Box */

const SCREEN = { width: 800, height: 450 };
/** @param {Box} box @param {'above'|'below'} [where] */
const label = (box, where = 'above') => ({ box, wide: 120, high: 16, where });
/** @param {{x: number, y: number}|null} at @returns {Box} */
const areaOf = (at) => (at ? [at.x, at.y, at.x + 120, at.y + 16] : [0, 0, 0, 0]);
/** @param {Box} a @param {Box} b */
const overlap = (a, b) => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];

test('a sign alone has its label above it, at the upper edge below it', () => {
  assert.deepEqual(placeLabels([label([300, 200, 330, 230])], SCREEN), [{ x: 299, y: 182 }]);
  assert.deepEqual(placeLabels([label([300, 4, 330, 34])], SCREEN), [{ x: 299, y: 36 }]);
  assert.deepEqual(placeLabels([label([300, 400, 330, 445], 'below')], SCREEN), [{ x: 299, y: 382 }]);
});

test('signs on one post: no label lies on a sign or on another label', () => {
  /** @type {Box[]} */
  const post = [
    [640, 220, 668, 250],
    [642, 252, 670, 280],
    [644, 282, 670, 306],
  ];
  const wanted = [...post.map((box) => label(box)), ...post.map((box) => label(box, 'below'))];
  const places = placeLabels(wanted, SCREEN).map(areaOf);
  for (const place of places) for (const box of post) assert.ok(!overlap(place, box), `${place} lies on ${box}`);
  places.forEach((a, i) => places.slice(i + 1).forEach((b) => assert.ok(!overlap(a, b), `${a} lies on ${b}`)));
});

test('a small sign behind a long label is not covered', () => {
  const small = /** @type {Box} */ ([380, 182, 396, 198]);
  const [first] = placeLabels([label([300, 200, 320, 220]), label(small)], SCREEN);
  assert.ok(!overlap(areaOf(first), small));
});

test('at the right edge labels go to the left side', () => {
  const [first, second] = placeLabels([label([760, 200, 795, 235]), label([760, 238, 795, 270])], SCREEN);
  assert.deepEqual(first, { x: 680, y: 182 });
  assert.deepEqual(second, { x: 638, y: 238 });
});

test('boxes outside the screen have no label', () => {
  assert.deepEqual(placeLabels([label([820, 100, 850, 130]), label([100, -40, 130, -5])], SCREEN), [null, null]);
});

test('if every side is taken, a label is placed some lines away and marked', () => {
  // three layers' boxes of one sign, between two others of which each has a label
  const boxes = /** @type {Box[]} */ ([
    [400, 200, 430, 230],
    [401, 201, 431, 231],
    [399, 199, 429, 229],
    [402, 200, 432, 230],
    [400, 201, 430, 231],
    [401, 199, 431, 229],
    [400, 200, 431, 231],
    [399, 200, 430, 231],
  ]);
  const places = placeLabels(
    boxes.map((box) => label(box)),
    SCREEN,
  );
  const areas = places.map(areaOf);
  areas.forEach((a, i) => areas.slice(i + 1).forEach((b) => assert.ok(!overlap(a, b), `${a} lies on ${b}`)));
  assert.equal(places[0]?.apart, undefined);
  assert.ok(
    places.some((at) => at?.apart),
    'some are not beside it',
  );
});

test('from near, a label does not stand in the box of another sign', () => {
  /** @type {Box[]} */
  const boxes = [
    [300, -50, 500, 200],
    [280, 203, 520, 440],
  ]; // the upper one is cut: its label would go below it
  for (const shift of [0, 6]) {
    const layers = /** @type {Box[]} */ (boxes.map((box) => box.map((edge) => edge + shift)));
    const [upper] = placeLabels(
      [...boxes, ...layers].map((box) => label(box)),
      SCREEN,
    );
    assert.ok(!overlap(areaOf(upper), boxes[1]), `${areaOf(upper)} lies in ${boxes[1]}`);
  }
});
