// @ts-check
import assert from 'node:assert/strict';
import test from 'node:test';

import { cropRegion, cssPosition } from '../../../static/js/model/crop_region.js';

const PICTURE = { width: 1280, height: 720 };

test('the part is a square around both boxes', () => {
  assert.deepEqual(
    cropRegion(
      [
        [100, 100, 140, 140],
        [120, 100, 160, 130],
      ],
      PICTURE,
    ),
    [76, 66, 184, 174],
  );
});

test('it is moved into the picture and no larger than that', () => {
  assert.deepEqual(cropRegion([[0, 0, 40, 40]], PICTURE), [0, 0, 72, 72]);
  assert.deepEqual(cropRegion([[1240, 700, 1280, 720]], PICTURE), [1208, 648, 1280, 720]);
  assert.deepEqual(cropRegion([[0, 0, 1280, 720]], PICTURE), [280, 0, 1000, 720]);
});

test('what surrounds a tiny box is seen', () => {
  assert.deepEqual(cropRegion([[50, 50, 54, 54]], PICTURE), [40, 40, 64, 64]);
});

test('a box has its place in the part', () => {
  assert.deepEqual(cssPosition([10, 20, 30, 30], [0, 0, 40, 40]), { left: '25.00%', top: '50.00%', width: '50.00%', height: '25.00%' });
});
