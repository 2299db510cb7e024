// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import {
  clampView,
  dragHandle,
  fit,
  handleAt,
  iou,
  moveBox,
  panToBox,
  normalizeBox,
  sizeOf,
  toPicture,
  toScreen,
  zoomAt,
  zoomToBox,
} from '../../../static/js/model/geometry.js';

const PICTURE = { width: 960, height: 540 };
const SCREEN = { width: 640, height: 480 };

test("screen and picture points are each other's inverse", () => {
  const view = { zoom: 3.7, x: 100, y: 50 };
  const [x, y] = toPicture(view, SCREEN, ...toScreen(view, SCREEN, 12.5, 99));
  assert.ok(Math.abs(x - 12.5) < 1e-9 && Math.abs(y - 99) < 1e-9);
});

test('the whole picture fits', () => {
  const view = fit(PICTURE, SCREEN);
  const [left, top] = toScreen(view, SCREEN, 0, 0);
  const [right, bottom] = toScreen(view, SCREEN, 960, 540);
  assert.ok(Math.abs(left) < 1e-9 && Math.abs(right - 640) < 1e-9 && top > 0 && bottom < 480);
});

test('zooming keeps the point under the pointer, down to the pixel', () => {
  let view = fit(PICTURE, SCREEN);
  const before = toPicture(view, SCREEN, 400, 200);
  for (let k = 0; k < 40; k++) view = zoomAt(view, SCREEN, PICTURE, 1.3, 400, 200);
  const after = toPicture(view, SCREEN, 400, 200);
  assert.equal(view.zoom, 64);
  assert.ok(Math.abs(before[0] - after[0]) < 1e-6 && Math.abs(before[1] - after[1]) < 1e-6);
});

test('some of the picture stays in view', () => {
  assert.deepEqual(clampView({ zoom: 2, x: -500, y: 9999 }, PICTURE), { zoom: 2, x: 0, y: 540 });
});

test('handles: corners before edges before the inside', () => {
  assert.equal(handleAt([10, 10, 30, 30], 10, 10, 4), 'nw');
  assert.equal(handleAt([10, 10, 30, 30], 20, 29, 4), 's');
  assert.equal(handleAt([10, 10, 30, 30], 20, 20, 4), 'move');
  assert.equal(handleAt([10, 10, 30, 30], 50, 50, 4), null);
});

test('a handle dragged over the other side turns the box, not inside out', () => {
  assert.deepEqual(dragHandle([10, 10, 30, 30], 'e', -35, 0), [-5, 10, 10, 30]);
  assert.deepEqual(dragHandle([10, 10, 30, 30], 'nw', 2, 3), [12, 13, 30, 30]);
  assert.deepEqual(dragHandle([10, 10, 30, 30], 'move', 2, 3), [12, 13, 32, 33]);
});

test('a settled box lies in the picture and is never empty', () => {
  for (const box of /** @type {import('../../../static/js/types.js').Box[]} */ ([
    [-50, -50, -40, -40],
    [959.9, 539.9, 2000, 2000],
    [5, 5, 5, 5],
  ])) {
    const [x1, y1, x2, y2] = normalizeBox(box, PICTURE);
    assert.ok(0 <= x1 && x1 + 2 <= x2 && x2 <= 960 && 0 <= y1 && y1 + 2 <= y2 && y2 <= 540, String([x1, y1, x2, y2]));
  }
});

test('nudging keeps the size at the edge', () => {
  assert.deepEqual(moveBox([3, 3, 13, 13], -10, 0, PICTURE), [0, 3, 10, 13]);
  assert.deepEqual(moveBox([940, 500, 955, 539], 10, 10, PICTURE), [945, 501, 960, 540]);
});

test('overlap', () => {
  assert.equal(iou([0, 0, 10, 10], [0, 0, 10, 10]), 1);
  assert.equal(iou([0, 0, 10, 10], [5, 0, 15, 10]), 1 / 3);
  assert.equal(iou([0, 0, 10, 10], [20, 0, 30, 10]), 0);
});

test('the middle of a small box moves it, however near its handles are', () => {
  const box = /** @type {[number, number, number, number]} */ ([100, 100, 112, 112]);
  assert.equal(handleAt(box, 106, 106, 20), 'move');
  assert.equal(handleAt(box, 101, 101, 20), 'nw');
  assert.equal(handleAt(box, 95, 95, 20), 'nw');
  assert.equal(handleAt(box, 70, 106, 20), null);
});

test('a view follows a box that is out of sight, and no other', () => {
  const view = { zoom: 4, x: 100, y: 100 };
  const screen = { width: 400, height: 300 };
  assert.equal(panToBox(view, screen, [90, 90, 110, 110]), view);
  assert.equal(panToBox(view, screen, [60, 70, 70, 80]), view);
  assert.deepEqual(panToBox(view, screen, [300, 20, 310, 40]), { zoom: 4, x: 305, y: 30 });
  assert.deepEqual(panToBox(view, screen, [0, 0, 160, 80]), { zoom: 2, x: 80, y: 40 });
});

test('a small box is zoomed to the given side, a tiny one up to a limit', () => {
  assert.deepEqual(zoomToBox([10, 10, 30, 50], 120, PICTURE), { zoom: 3, x: 20, y: 30 });
  assert.equal(zoomToBox([10, 10, 12, 12], 120, PICTURE).zoom, 16);
});

test('pixels that are not square are shown at their true shape, and every point is still its own', () => {
  const picture = sizeOf(/** @type {any} */ ({ width: 480, height: 360, pixel_ratio: 4 / 3 }));
  const view = fit(picture, { width: 640, height: 360 });
  for (const [point, place] of [
    [
      [0, 0],
      [0, 0],
    ],
    [
      [480, 360],
      [640, 360],
    ],
    [
      [120, 90],
      [160, 90],
    ],
  ]) {
    const shown = toScreen(view, { width: 640, height: 360 }, point[0], point[1]);
    assert.ok(Math.hypot(shown[0] - place[0], shown[1] - place[1]) < 1e-9);
    const back = toPicture(view, { width: 640, height: 360 }, shown[0], shown[1]);
    assert.ok(Math.hypot(back[0] - point[0], back[1] - point[1]) < 1e-9);
  }
  const near = zoomAt(view, SCREEN, picture, 2, 400, 200);
  assert.deepEqual(toPicture(near, SCREEN, 400, 200).map(Math.round), toPicture(view, SCREEN, 400, 200).map(Math.round));
  assert.equal(near.stretch, 4 / 3);
  const close = zoomToBox([0, 0, 30, 40], 120, picture);
  assert.ok(Math.abs(close.zoom - 3) < 1e-9 && close.stretch === 4 / 3, 'the box is as wide as high on screen');
  assert.equal(panToBox(view, SCREEN, [470, 350, 480, 360]).stretch, 4 / 3);
  assert.deepEqual(sizeOf(/** @type {any} */ ({ width: 3, height: 2, pixel_ratio: 1 })), { width: 3, height: 2 });
});

test('a handle is as near sideways as it looks', () => {
  assert.equal(handleAt([0, 0, 60, 60], 63, 30, 4), 'e');
  assert.equal(handleAt([0, 0, 60, 60], 63, 30, 4, 2), null);
});
