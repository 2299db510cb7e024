// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { OPEN_END } from '../../../static/js/model/documents.js';
import { engineGaps } from '../../../static/js/model/engine_gaps.js';

test('gaps lie between the boxes of a track and after its end, unless it reaches the newest frame', () => {
  const lanes = { track: [1, 1, 1, 2, 3], first: [0, 5, 9, 4, 2], last: [4, 6, 12, 20, 19], source: [0, 1, 0, 0, 0] };
  assert.deepEqual(engineGaps(lanes, new Set([1, 2])), [
    { track: 1, first: 7, last: 8 },
    { track: 1, first: 13, last: OPEN_END },
  ]);
  assert.deepEqual(engineGaps(lanes, new Set([3])), [{ track: 3, first: 20, last: OPEN_END }]);
  assert.deepEqual(engineGaps(null, new Set([1])), []);
});
